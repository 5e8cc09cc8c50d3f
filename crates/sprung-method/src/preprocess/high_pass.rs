//! The high-pass filter of deflections from sensors on links.
//!
//! The integral of their reading drifts. The rows of a joint with such a sensor pass the filter
//! `h = (s/(s + w))^order`, which removes the drift. Both sides of a row pass the same filter, so the row stays
//! exact.

use crate::description::RowFilter;

/// One stage `s/(s + w)` and `1/(s + w)`, by Tustin's rule.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HighPass {
    decay: f64,
    /// Gain of differences.
    high: f64,
    /// Gain of sums, s.
    low: f64,
    settling: u64,
}

/// State of one stage.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Stage {
    pub(super) input: f64,
    output: f64,
}

impl HighPass {
    /// - `period`: T, s.
    pub(crate) fn new(kind: &RowFilter, period: f64) -> Self {
        let corner = kind.corner;
        let c = 2.0 / period;
        Self {
            decay: (c - corner) / (c + corner),
            high: c / (c + corner),
            low: (c + corner).recip(),
            settling: (kind.settling_time_constants / (corner * period)).ceil() as u64,
        }
    }

    /// Returns the number of samples in which the filter settles.
    pub(crate) fn settling(&self) -> u64 {
        self.settling
    }

    /// Returns the output of `s/(s + w)`.
    pub(super) fn rise(&self, stage: &mut Stage, input: f64) -> f64 {
        stage.output = self.decay * stage.output + self.high * (input - stage.input);
        stage.input = input;
        stage.output
    }

    /// Returns the output of `1/(s + w)`.
    pub(super) fn sum(&self, stage: &mut Stage, input: f64) -> f64 {
        stage.output = self.decay * stage.output + self.low * (input + stage.input);
        stage.input = input;
        stage.output
    }

    /// Returns the output of `(s/(s + w))^order`, one stage per order.
    pub(crate) fn process(&self, stages: &mut [Stage], input: f64) -> f64 {
        (stages.iter_mut()).fold(input, |input, stage| self.rise(stage, input))
    }
}
