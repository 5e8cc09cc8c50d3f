//! Zero-phase Butterworth low-pass in second-order sections, block by block.
//!
//! The result equals SciPy's `sosfiltfilt` with odd padding of three cut-off periods. SciPy's
//! default padding of a few samples leaves a transient at the ends that ruins an identification.

use std::f64::consts::PI;

use crate::numbers::Shown;

/// Relative size below which transients of the backward pass are neglected.
const NEGLIGIBLE_TRANSIENT: f64 = 1e-16;

/// Periods of the cut-off frequency that pad each end.
const PADDING_PERIODS: f64 = 3.0;

/// Errors in the settings of a zero-phase filter.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FilterDesignError {
    /// The cut-off is not between zero and half the sampling rate.
    #[error(
        "a cut-off of {} Hz needs more than {} samples per second, the log has \
         {rate_hz:.6}; choose position_cutoff_hz below {:.6} Hz{}",
        Shown(*cutoff_hz), Shown(2.0 * cutoff_hz), rate_hz / 2.0,
        if *rate_hz < 10.0 { ", or name the column under time_ms if it holds milliseconds" } else { "" }
    )]
    AboveNyquist {
        /// Requested cut-off, Hz.
        cutoff_hz: f64,
        /// Sampling rate, Hz.
        rate_hz: f64,
    },
}

#[derive(Clone, Copy, Debug)]
struct Section {
    b: [f64; 3],
    a: [f64; 2],
    // Steady state of the section for a constant input of 1.
    settled: [f64; 2],
}

/// Rounds a number of samples, with a bound for absurd settings.
fn count(samples: f64) -> usize {
    samples.round().min(1e15) as usize
}

/// Order in which samples are filtered.
#[derive(Clone, Copy)]
enum Direction {
    Forward,
    Backward,
}

/// A Butterworth low-pass in second-order sections.
#[derive(Clone, Debug)]
pub struct Butterworth {
    sections: Vec<Section>,
    slowest: f64,
    padding: usize,
}

impl Butterworth {
    /// Designs the filter by the bilinear transform with a prewarped cut-off.
    ///
    /// - `order`: at least 1; `cutoff`: -3 dB of one pass, Hz.
    /// - `period`: T, s.
    ///
    /// # Errors
    ///
    /// [`FilterDesignError::AboveNyquist`] unless `0 < cutoff < 1 / (2 T)`.
    pub fn new(order: usize, cutoff: f64, period: f64) -> Result<Self, FilterDesignError> {
        if !(cutoff > 0.0 && 2.0 * cutoff * period < 1.0) {
            return Err(FilterDesignError::AboveNyquist {
                cutoff_hz: cutoff,
                rate_hz: 1.0 / period,
            });
        }
        // Poles of the analog prototype in units of 2 / T.
        let warped = (PI * cutoff * period).tan();
        let mut sections = Vec::with_capacity(order.div_ceil(2));
        let mut slowest: f64 = 0.0;
        for pair in 0..order / 2 {
            let angle = PI * (2 * pair + 1) as f64 / (2 * order) as f64;
            let (re, im) = (-warped * angle.sin(), warped * angle.cos());
            // z = (1 + s) / (1 - s) for s = re ± j im.
            let d = (1.0 - re).powi(2) + im * im;
            let z_re = (1.0 - re * re - im * im) / d;
            let z_abs2 = ((1.0 + re).powi(2) + im * im) / d;
            let gain = 4.0 * warped * warped / d;
            let b = gain / 4.0;
            sections.push(Section::new([b, 2.0 * b, b], [-2.0 * z_re, z_abs2]));
            slowest = slowest.max(z_abs2.sqrt());
        }
        if order % 2 == 1 {
            let z = (1.0 - warped) / (1.0 + warped);
            let b = warped / (1.0 + warped);
            sections.push(Section::new([b, b, 0.0], [-z, 0.0]));
            slowest = slowest.max(z.abs());
        }
        Ok(Self {
            sections,
            slowest,
            padding: count(PADDING_PERIODS / (cutoff * period)).max(1),
        })
    }

    /// Returns the number of samples that pad each end; a signal must be longer.
    #[must_use]
    pub fn padding(&self) -> usize {
        self.padding
    }

    /// Returns the number of samples at each end that the padding affects unless the signal is
    /// constant there: one period of the cut-off.
    #[must_use]
    pub fn edge(&self) -> usize {
        self.padding.div_ceil(PADDING_PERIODS as usize)
    }

    /// Returns the number of samples that a wrong initial state of the backward pass affects.
    fn overlap(&self) -> usize {
        count(NEGLIGIBLE_TRANSIENT.ln() / self.slowest.max(1e-3).ln()) + 8
    }

    fn settled(&self, input: f64) -> Vec<[f64; 2]> {
        self.sections
            .iter()
            .map(|section| section.settled.map(|s| s * input))
            .collect()
    }

    /// Filters samples in place, from the first to the last or the other way round.
    fn run(&self, state: &mut [[f64; 2]], mut samples: &mut [f64], direction: Direction) {
        // A filter at rest passes zeros.
        if state.as_flattened().iter().all(|memory| *memory == 0.0) {
            let is_not_zero = |sample: &f64| *sample != 0.0;
            samples = match direction {
                Direction::Forward => match samples.iter().position(is_not_zero) {
                    Some(first) => &mut samples[first..],
                    None => return,
                },
                Direction::Backward => match samples.iter().rposition(is_not_zero) {
                    Some(last) => &mut samples[..=last],
                    None => return,
                },
            };
        }
        for (Section { b, a, .. }, state) in self.sections.iter().zip(state) {
            let [mut first, mut second] = *state;
            let step = |sample: &mut f64| {
                let x = *sample;
                let y = b[0] * x + first;
                first = b[1] * x - a[0] * y + second;
                second = b[2] * x - a[1] * y;
                *sample = y;
            };
            match direction {
                Direction::Forward => samples.iter_mut().for_each(step),
                Direction::Backward => samples.iter_mut().rev().for_each(step),
            }
            *state = [first, second];
        }
    }
}

impl Section {
    fn new(b: [f64; 3], a: [f64; 2]) -> Self {
        let last = b[2] - a[1];
        Self {
            b,
            a,
            settled: [b[1] - a[0] + last, last],
        }
    }
}

/// Filters one signal forward and backward, block by block.
///
/// The backward pass of a block starts so far after the block that its initial state has no
/// effect: the result equals that for the whole signal to round-off.
#[derive(Clone, Debug)]
pub struct ZeroPhase {
    filter: Butterworth,
    overlap: usize,
    block: usize,
    // First samples, until there are enough of them to pad the start.
    head: Vec<f64>,
    started: bool,
    state: Vec<[f64; 2]>,
    // Forward results that await the backward pass.
    pending: Vec<f64>,
    // Last samples, for the padding of the end.
    tail: Vec<f64>,
}

impl ZeroPhase {
    /// Returns a filter for a new signal.
    #[must_use]
    pub fn new(filter: Butterworth) -> Self {
        let overlap = filter.overlap();
        Self {
            state: filter.settled(0.0),
            overlap,
            block: (2 * overlap).max(2048),
            filter,
            head: Vec::new(),
            started: false,
            pending: Vec::new(),
            tail: Vec::new(),
        }
    }

    /// Processes the next samples and appends finished samples to `out`.
    pub fn push(&mut self, samples: &[f64], out: &mut Vec<f64>) {
        let padding = self.filter.padding;
        let mut samples = samples;
        let head;
        if !self.started {
            if self.head.len() + samples.len() <= padding {
                self.head.extend_from_slice(samples);
                return;
            }
            if !self.head.is_empty() {
                self.head.extend_from_slice(samples);
                head = std::mem::take(&mut self.head);
                samples = &head;
            }
            self.start(samples);
        }
        let before = self.pending.len();
        self.pending.extend_from_slice(samples);
        let new = &mut self.pending[before..];
        self.filter.run(&mut self.state, new, Direction::Forward);
        let last = &samples[samples.len().saturating_sub(padding + 1)..];
        let surplus = (self.tail.len() + last.len()).saturating_sub(padding + 1);
        self.tail.drain(..surplus.min(self.tail.len()));
        self.tail.extend_from_slice(last);
        if self.pending.len() >= self.block + self.overlap {
            let ready = self.pending.len() - self.overlap;
            self.backward(&[], ready, out);
        }
    }

    /// Ends the signal and appends the remaining samples to `out`.
    ///
    /// Returns false and appends nothing if the signal is not longer than the padding.
    #[must_use]
    pub fn finish(mut self, out: &mut Vec<f64>) -> bool {
        if !self.started {
            return false;
        }
        let n = self.tail.len();
        let last = self.tail[n - 1];
        let odd = |i: usize| 2.0 * last - self.tail[n - 1 - i];
        let mut extension: Vec<f64> = (1..n).map(odd).collect();
        (self.filter).run(&mut self.state, &mut extension, Direction::Forward);
        let ready = self.pending.len();
        self.backward(&extension, ready, out);
        true
    }

    fn start(&mut self, head: &[f64]) {
        let padding = self.filter.padding;
        let odd = |i: usize| 2.0 * head[0] - head[i];
        self.state = self.filter.settled(odd(padding));
        let mut extension: Vec<f64> = (1..=padding).rev().map(odd).collect();
        (self.filter).run(&mut self.state, &mut extension, Direction::Forward);
        self.started = true;
    }

    /// Runs the backward pass over `beyond` and the pending samples, and appends the first `ready`
    /// results to `out`.
    fn backward(&mut self, beyond: &[f64], ready: usize, out: &mut Vec<f64>) {
        let start = beyond
            .last()
            .or(self.pending.last())
            .copied()
            .unwrap_or(0.0);
        let mut state = self.filter.settled(start);
        let mut beyond = beyond.to_vec();
        (self.filter).run(&mut state, &mut beyond, Direction::Backward);
        let waiting = self.pending[ready..].to_vec();
        let mut filtered = std::mem::replace(&mut self.pending, waiting);
        (self.filter).run(&mut state, &mut filtered, Direction::Backward);
        filtered.truncate(ready);
        if out.is_empty() {
            *out = filtered;
        } else {
            out.append(&mut filtered);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signal(n: usize) -> Vec<f64> {
        (0..n)
            .map(|k| {
                let t = k as f64 * 1e-3;
                0.4 + (7.0 * t).sin() + 0.2 * (200.0 * t).cos() + 0.01 * ((k * k) % 17) as f64
            })
            .collect()
    }

    fn filter_in_blocks(filter: &Butterworth, x: &[f64], block: usize) -> Vec<f64> {
        let mut zero_phase = ZeroPhase::new(filter.clone());
        let mut out = Vec::new();
        for part in x.chunks(block) {
            zero_phase.push(part, &mut out);
        }
        assert!(zero_phase.finish(&mut out));
        out
    }

    #[test]
    fn blocks_give_the_result_of_the_whole_signal() {
        let x = signal(60_000);
        for (order, cutoff) in [(2, 10.0), (1, 3.0), (5, 40.0), (8, 2.0)] {
            let filter = Butterworth::new(order, cutoff, 1e-3).unwrap();
            // A single push: the backward pass starts at the end of the log only if the block is
            // longer than the log.
            let mut whole = ZeroPhase::new(filter.clone());
            whole.block = usize::MAX / 2;
            let mut expected = Vec::new();
            whole.push(&x, &mut expected);
            assert!(expected.is_empty() && whole.finish(&mut expected));
            assert_eq!(expected.len(), x.len());
            for block in [1, 777, 4096] {
                let found = filter_in_blocks(&filter, &x, block);
                assert_eq!(found.len(), x.len());
                let worst = (found.iter().zip(&expected))
                    .map(|(a, b)| (a - b).abs())
                    .fold(0.0, f64::max);
                assert!(worst < 1e-12, "order {order}, block {block}: {worst:e}");
            }
        }
    }

    #[test]
    fn gain_at_the_cut_off_is_one_half_without_phase() {
        // Two passes of -3 dB each.
        let filter = Butterworth::new(2, 10.0, 1e-3).unwrap();
        let x: Vec<f64> = (0..20_000)
            .map(|k| (std::f64::consts::TAU * 10.0 * f64::from(k) * 1e-3).sin())
            .collect();
        let y = filter_in_blocks(&filter, &x, 4096);
        for k in 5000..15_000 {
            assert!((y[k] - 0.5 * x[k]).abs() < 1e-9);
        }
    }

    #[test]
    fn a_straight_line_passes_unchanged() {
        let filter = Butterworth::new(2, 10.0, 1e-3).unwrap();
        let x: Vec<f64> = (0..5000).map(|k| 0.3 - 0.01 * f64::from(k)).collect();
        let y = filter_in_blocks(&filter, &x, 999);
        let error = |k: usize| (x[k] - y[k]).abs();
        // The start of the padding is a corner of the line, whose transient is the slope over the pole's size. It
        // decays by the real part of the pole, 1/√2, over three periods of the cut-off, in each of the two passes.
        let transient = 0.01 * 2_f64.sqrt() / (std::f64::consts::TAU * 0.01);
        let limit = 2.0 * transient * (-3.0 * std::f64::consts::TAU / 2_f64.sqrt()).exp();
        assert!((0..5000).all(|k| error(k) < limit));
        assert!((500..4500).all(|k| error(k) < 1e-9));
    }

    #[test]
    fn short_signals_and_high_cut_offs_are_refused() {
        let filter = Butterworth::new(2, 10.0, 1e-3).unwrap();
        let mut zero_phase = ZeroPhase::new(filter.clone());
        let mut out = Vec::new();
        zero_phase.push(&vec![1.0; filter.padding()], &mut out);
        assert!(!zero_phase.finish(&mut out) && out.is_empty());
        let message = Butterworth::new(2, 500.0, 1e-3).unwrap_err().to_string();
        assert!(message.contains("below 500"), "{message}");
    }
}
