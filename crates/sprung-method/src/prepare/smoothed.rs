//! The signals of an excerpt with one cut-off of the position filter.

use crate::preprocess::{Butterworth, SignalBlock, ZeroPhase};
use crate::regression::{Reading, Reduction, System, reduce_signals};

/// Ratio of neighbouring cut-offs in a sweep.
pub(crate) const CUTOFF_STEP: f64 = std::f64::consts::SQRT_2;

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
    segments: Vec<SignalBlock>,
}

impl Smoothed {
    /// - `period`: T, s.
    pub(super) fn new(period: f64, segments: Vec<SignalBlock>) -> Self {
        Self { period, segments }
    }

    /// Returns the sampling period, s.
    pub(crate) fn period(&self) -> f64 {
        self.period
    }

    /// Returns the signals of each segment without gap.
    pub(crate) fn segments(&self) -> &[SignalBlock] {
        &self.segments
    }

    /// Returns every n-th sample, with torques that pass the filter of the positions and are continuous instead of held; `None` if a
    /// segment is too short for the filter.
    pub(crate) fn continuous(mut self, filter: &Butterworth, every: usize) -> Option<Self> {
        for segment in &mut self.segments {
            for column in segment
                .tau
                .iter_mut()
                .chain(&mut segment.spring)
                .filter(|column| !column.is_empty())
            {
                let mut running = ZeroPhase::new(filter.clone());
                let mut filtered = Vec::with_capacity(column.len());
                running.push(column, &mut filtered);
                if !running.finish(&mut filtered) {
                    return None;
                }
                *column = filtered;
            }
            // A held torque has the mean of two values at the time stamp between them.
            for column in &mut segment.tau {
                for k in (1..column.len()).rev() {
                    column[k] = 0.5 * (column[k] + column[k - 1]);
                }
            }
            *segment = segment.picked(every);
        }
        self.period *= every as f64;
        Some(self)
    }

    /// Returns the regression, without samples for plots; `None` if there are no samples or the
    /// filter pair does not fit the period.
    pub(crate) fn reduce(&self, reading: &Reading) -> Option<System> {
        self.reduce_by(Reduction::new(reading.model()).without_samples(), reading)
    }

    /// Returns the regression of the rows and probes of an empty reduction; `None` as for
    /// [`Smoothed::reduce`].
    pub(crate) fn reduce_by(&self, empty: Reduction, reading: &Reading) -> Option<System> {
        reduce_signals(reading, self.period, &self.segments, empty)
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
        let samples: usize = self.segments.iter().map(SignalBlock::len).sum();
        let every = (1.0 / (rate * self.period)) as usize;
        let every = every.min(samples / THINNED_SAMPLES);
        if every > 1 {
            self.period *= every as f64;
            for segment in &mut self.segments {
                *segment = segment.thinned(every);
            }
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo;
    use crate::description::{self, no_files};
    use crate::log::Channels;
    use crate::model::Model;

    fn reading(cutoff_hz: f64) -> Reading {
        let experiment =
            description::read("experiment.toml", demo::EXPERIMENT, &[], &mut no_files).unwrap();
        let model = Model::new(&experiment).unwrap();
        let channels = Channels::new(&experiment.robot, experiment.log.as_ref().unwrap()).unwrap();
        Reading::new(&model, &experiment.identify, &channels, cutoff_hz)
    }

    fn signals(samples: u32) -> Smoothed {
        let mut block = SignalBlock::new(1);
        for k in 0..samples {
            for column in [&mut block.q, &mut block.dq, &mut block.phi, &mut block.dphi] {
                column[0].push(f64::from(k));
            }
            block.tau[0].push(f64::from(k));
            block.time.push(1e-3 * f64::from(k));
        }
        Smoothed::new(1e-3, vec![block])
    }

    #[test]
    fn positions_are_picked_and_torques_averaged() {
        let thinned = signals(9003).thinned(&reading(20.0));
        assert!((thinned.period - 4e-3).abs() < 1e-15);
        let block = &thinned.segments[0];
        assert_eq!(block.len(), 2250);
        assert!((block.time[2] - 8e-3).abs() < 1e-15);
        assert!((block.dphi[0][2] - 8.0).abs() < 1e-12);
        assert!((block.tau[0][2] - 9.5).abs() < 1e-12);
    }

    #[test]
    fn high_cut_offs_and_short_signals_keep_more_samples() {
        // 100 Hz and one step more: at least 566 samples per second.
        let fast = signals(9000).thinned(&reading(100.0));
        assert_eq!(fast.segments[0].len(), 9000);
        let short = signals(5000).thinned(&reading(20.0));
        assert_eq!(short.segments[0].len(), 2500);
    }
}
