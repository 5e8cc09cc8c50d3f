//! Excerpts with fewer samples, for searches with many trials.

use super::excerpt::Excerpt;
use crate::log::{Channels, LogBlock, Quantity};
use crate::regression::Reading;

/// Smallest sampling rate, relative to the cut-off of the positions, and largest product of λ and
/// the period. The filtered signals then change little between two samples.
const MIN_RATE_OVER_CUTOFF: f64 = 6.0;
const MAX_FILTER_STEP: f64 = 0.2;

impl Excerpt {
    /// Returns the excerpt with the fewest samples that the filters of a reading allow.
    ///
    /// - `longest`: limit of the period, s.
    #[must_use]
    pub(crate) fn thinned_for(&self, reading: &Reading, longest: f64) -> Self {
        let period = (MIN_RATE_OVER_CUTOFF * reading.position_cutoff_hz()).recip();
        let by_filter = MAX_FILTER_STEP / reading.filter_cutoff();
        let every = (period.min(by_filter).min(longest) / self.period()).floor();
        self.thinned(reading.channels(), (every as usize).max(1))
    }

    /// Returns every n-th position, and the mean of the torques from there to the next one: a
    /// controller holds each torque until its next sample. A gap ends a mean.
    #[must_use]
    fn thinned(&self, channels: &Channels, every: usize) -> Self {
        if every == 1 {
            return self.clone();
        }
        let mut thinned = self.emptied(every);
        let count = channels.all.len();
        let mut sums = vec![0.0; count];
        let (mut time, mut taken, mut after_gap) = (0.0, 0, false);
        for block in self.blocks() {
            let mut few = LogBlock::new(count);
            for k in 0..block.len() {
                if block.gaps.contains(&k) {
                    (taken, after_gap) = (0, true);
                }
                if taken == 0 {
                    time = block.time[k];
                    sums.fill(0.0);
                }
                for (i, channel) in channels.all.iter().enumerate() {
                    if channel.quantity == Quantity::MotorTorque {
                        sums[i] += block.values[i][k] / every as f64;
                    } else if taken == 0 {
                        sums[i] = block.values[i][k];
                    }
                }
                taken += 1;
                if taken == every {
                    if std::mem::take(&mut after_gap) {
                        few.gaps.push(few.len());
                    }
                    few.time.push(time);
                    for (values, value) in few.values.iter_mut().zip(&sums) {
                        values.push(*value);
                    }
                    taken = 0;
                }
            }
            thinned.push(&few);
        }
        thinned
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo;
    use crate::description::{no_files, read};

    #[test]
    fn positions_are_picked_and_torques_averaged_up_to_a_gap() {
        let experiment = read("experiment.toml", demo::EXPERIMENT, &[], &mut no_files).unwrap();
        let channels = Channels::new(&experiment.robot, experiment.log.as_ref().unwrap()).unwrap();
        let block = |from: usize, samples: usize, gaps: Vec<usize>| LogBlock {
            time: (from..from + samples).map(|k| k as f64).collect(),
            values: vec![(from..from + samples).map(|k| k as f64).collect(); 6],
            gaps,
        };
        let mut excerpt = Excerpt::new(1.0, 2);
        // The gap interrupts the third group of two samples; the blocks end within groups.
        excerpt.push(&block(0, 3, Vec::new()));
        excerpt.push(&block(3, 6, vec![2]));
        let thinned = excerpt.thinned(&channels, 2);
        let values = |quantity: fn(&crate::log::Channel) -> bool| -> Vec<f64> {
            let channel = channels.all.iter().position(quantity).unwrap();
            thinned.channel(channel).collect()
        };
        assert_eq!(thinned.period().to_bits(), 2.0_f64.to_bits());
        assert_eq!(values(|c| c.quantity.is_position()), [0.0, 2.0, 5.0, 7.0]);
        assert_eq!(values(|c| !c.quantity.is_position()), [0.5, 2.5, 5.5, 7.5]);
        assert_eq!(thinned.blocks()[1].gaps, [1]);
        assert_eq!(thinned.samples(), 4);
    }
}
