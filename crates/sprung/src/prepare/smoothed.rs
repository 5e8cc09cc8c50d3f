//! The signals of an excerpt with one cut-off of the position filter.

use super::sweep::CUTOFF_STEP;
use crate::preprocess::SignalBlock;
use crate::regression::{Probe, Reading, System, reduce_signals};

/// Lowest sampling rate of thinned signals, Hz, and the same as a multiple of the highest cut-off.
/// An arm moves much slower, and a reversal passes the Coulomb transition in some milliseconds.
const THINNED_RATE_HZ: f64 = 250.0;
const THINNED_RATE_PER_CUTOFF: f64 = 4.0;

/// Fewest samples of thinned signals.
const THINNED_SAMPLES: usize = 2000;

/// Filtered positions, velocities and torques of an excerpt.
#[derive(Clone, Debug)]
pub(crate) struct Smoothed {
    period: f64,
    // One block for each segment of the log that is long enough for the filters.
    stretches: Vec<SignalBlock>,
}

impl Smoothed {
    /// - `period`: T, s.
    pub(super) fn new(period: f64, stretches: Vec<SignalBlock>) -> Self {
        Self { period, stretches }
    }

    /// Returns the regression; `None` if there are no samples or the filter pair does not fit the
    /// period.
    pub(crate) fn reduce(&self, reading: &Reading) -> Option<System> {
        let rows: Vec<usize> = (0..reading.model().rows()).collect();
        self.reduce_rows(reading, &rows, &[])
    }

    /// Returns the regression of some rows with further columns; `None` as for
    /// [`Smoothed::reduce`].
    pub(crate) fn reduce_rows(
        &self,
        reading: &Reading,
        rows: &[usize],
        probes: &[Probe],
    ) -> Option<System> {
        reduce_signals(reading, self.period, &self.stretches, rows, probes)
            .ok()
            .flatten()
    }

    /// Returns fewer samples with the same information for choices: every k-th filtered position
    /// and velocity, and the mean of the k torques that are held until the next one.
    ///
    /// The filtered motion has a narrow band, so k follows from the cut-off: the rate stays above
    /// four times the cut-off one step above that of `reading`, and above 250 Hz. Short signals keep
    /// more samples.
    ///
    /// - `reading`: with the cut-off before a choice, so that all cut-offs of a sweep are compared
    ///   at the same rate.
    pub(crate) fn thinned(mut self, reading: &Reading) -> Self {
        let highest_hz = CUTOFF_STEP * reading.position_cutoff_hz();
        let rate = THINNED_RATE_HZ.max(THINNED_RATE_PER_CUTOFF * highest_hz);
        let samples: usize = self.stretches.iter().map(SignalBlock::len).sum();
        let every = (1.0 / (rate * self.period)) as usize;
        let every = every.min(samples / THINNED_SAMPLES);
        if every > 1 {
            self.period *= every as f64;
            for stretch in &mut self.stretches {
                *stretch = stretch.thinned(every);
            }
        }
        self
    }
}
