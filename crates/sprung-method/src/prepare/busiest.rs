//! The part of an excerpt with the largest jerk of the robot.

use super::excerpt::Excerpt;
use crate::log::{Channels, LogBlock, Signal};

/// Time between the positions that give a jerk, s. The noise of the positions then hardly counts.
const JERK_STEP_S: f64 = 0.05;

/// Distance of the parts that are compared, relative to their length.
const STEP_OF_PARTS: f64 = 0.25;

impl Excerpt {
    /// Returns the part without a gap in which the joints jerk most, relative to their jerks in the
    /// whole excerpt; only jerks show a delay. Returns the excerpt itself if it is not longer, and
    /// `None` if every part has a gap.
    #[must_use]
    pub(crate) fn busiest(&self, channels: &Channels, samples: usize) -> Option<Self> {
        if samples >= self.samples() {
            return Some(self.clone());
        }
        let whole = self.as_one_block();
        let jerks = jerks(
            &whole,
            channels,
            (JERK_STEP_S / self.period()).ceil() as usize,
        );
        let of_part = |from: usize| jerks[from..from + samples].iter().sum::<f64>();
        let step = ((STEP_OF_PARTS * samples as f64) as usize).max(1);
        let from = (0..=whole.len() - samples)
            .step_by(step)
            .filter(|&from| {
                !(whole.gaps.iter()).any(|gap| (from + 1..from + samples).contains(gap))
            })
            .max_by(|&a, &b| of_part(a).total_cmp(&of_part(b)))?;
        let mut block = LogBlock::new(channels.all.len());
        block.extend(&whole, from..from + samples);
        let mut part = self.emptied(1);
        part.push(&block);
        Some(part)
    }

    fn as_one_block(&self) -> LogBlock {
        let mut whole = LogBlock::default();
        for block in self.blocks() {
            whole.values.resize(block.values.len(), Vec::new());
            let gaps = block.gaps.iter().map(|gap| whole.time.len() + gap);
            let gaps: Vec<usize> = gaps.collect();
            whole.gaps.extend(gaps);
            whole.extend(block, 0..block.len());
        }
        whole
    }
}

/// Returns the sum of the squared jerks of all joints at each sample, each joint's relative to its
/// mean.
///
/// - `step`: samples between the positions that give a jerk.
fn jerks(whole: &LogBlock, channels: &Channels, step: usize) -> Vec<f64> {
    let mut sums = vec![0.0; whole.len()];
    for joint in 0..channels.instruments.joint_count() {
        let Some(channel) = channels.telling(Signal::Motor, joint) else {
            continue;
        };
        let squares: Vec<f64> = (whole.values[channel].windows(3 * step + 1))
            .map(|w| (w[3 * step] - 3.0 * w[2 * step] + 3.0 * w[step] - w[0]).powi(2))
            .collect();
        let mean = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
        if mean > 0.0 {
            for (sum, square) in sums.iter_mut().zip(&squares) {
                *sum += square / mean;
            }
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo;
    use crate::description::{no_files, read};

    #[test]
    fn a_motion_after_a_standstill_is_found_beside_a_gap() {
        let experiment = read("experiment.toml", demo::EXPERIMENT, &[], &mut no_files).unwrap();
        let channels = Channels::new(&experiment.robot, experiment.log.as_ref().unwrap()).unwrap();
        // Both joints stand still for 3 s and then move; 4.4 s after the beginning there is a gap.
        let time: Vec<f64> = (0..6000).map(|k| f64::from(k) * 1e-3).collect();
        let position: Vec<f64> = (time.iter())
            .map(|t| {
                if *t < 3.0 {
                    0.0
                } else {
                    (5.0 * (t - 3.0)).sin()
                }
            })
            .collect();
        let mut excerpt = Excerpt::new(1e-3, 2);
        excerpt.push(&LogBlock {
            values: vec![position; channels.all.len()],
            gaps: vec![4400],
            time,
        });
        let part = excerpt.busiest(&channels, 1000).unwrap();
        let time = &part.blocks()[0].time;
        assert_eq!((part.samples(), part.blocks()[0].gaps.len()), (1000, 0));
        assert!(
            time[0] >= 2.75 && (time[999] < 4.4 || time[0] >= 4.4),
            "{}",
            time[0]
        );
        assert!(excerpt.busiest(&channels, 4500).is_none());
        assert_eq!(excerpt.busiest(&channels, 6000).unwrap().samples(), 6000);
    }
}
