//! Statistics gathered while a log is read.

use super::channel::{Extent, Figures};
use super::deflection::{DeflectionJump, DeflectionSteps, Pair};
use crate::block::LogBlock;
use crate::columns::channels::Channels;
use crate::description::Quantity;

#[derive(Clone, Copy, Debug, Default)]
struct Cross {
    motor: f64,
    link: f64,
    motor_link: f64,
    link_link: f64,
    motor_motor: f64,
}

/// Straight line through motor position versus link position of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Slope; about 1 for two encoders of one joint.
    pub slope: f64,
    /// Correlation of the two positions.
    pub correlation: f64,
}

/// Statistics of all channels of a log.
#[derive(Clone, Debug)]
pub struct Summary {
    figures: Vec<Option<Figures>>,
    pairs: Vec<Option<(usize, usize)>>,
    cross: Vec<Cross>,
    deflections: Vec<DeflectionSteps>,
    samples: u64,
}

impl Summary {
    /// Returns an empty summary.
    #[must_use]
    pub fn new(channels: &Channels) -> Self {
        let pairs: Vec<Option<(usize, usize)>> = (0..channels.instruments.joint_count())
            .map(|joint| {
                let motor = channels.index(Quantity::MotorPosition, joint)?;
                let link = channels.index(Quantity::LinkPosition, joint)?;
                Some((motor, link))
            })
            .collect();
        Self {
            figures: vec![None; channels.all.len()],
            cross: vec![Cross::default(); pairs.len()],
            deflections: vec![DeflectionSteps::default(); pairs.len()],
            pairs,
            samples: 0,
        }
    }

    /// Takes the next block.
    pub fn take(&mut self, block: &LogBlock) {
        self.samples += block.len() as u64;
        for (figures, values) in self.figures.iter_mut().zip(&block.values) {
            let mut gaps = block.gaps.iter().copied().peekable();
            for (k, (&time, &value)) in block.time.iter().zip(values).enumerate() {
                let figures = figures.get_or_insert_with(|| Figures::new(time, value));
                if gaps.next_if_eq(&k).is_some() {
                    figures.gap();
                }
                figures.take(time, value);
            }
        }
        for (steps, pair) in self.deflections.iter_mut().zip(&self.pairs) {
            let Some((motor, link)) = *pair else { continue };
            let mut gaps = block.gaps.iter().copied().peekable();
            let positions = block.values[motor].iter().zip(&block.values[link]);
            for (k, (&time, (&motor, &link))) in block.time.iter().zip(positions).enumerate() {
                if gaps.next_if_eq(&k).is_some() {
                    steps.gap();
                }
                steps.take(Pair { time, motor, link });
            }
        }
        for (cross, pair) in self.cross.iter_mut().zip(&self.pairs) {
            let Some((motor, link)) = *pair else { continue };
            // Positions count from the first sample, so offsets do not enter the correlation.
            let from = |channel: usize| {
                let figures = self.figures[channel].as_ref();
                figures.map_or(0.0, |figures| figures.extent().first)
            };
            let (motor_0, link_0) = (from(motor), from(link));
            for (m, l) in block.values[motor].iter().zip(&block.values[link]) {
                let (m, l) = (m - motor_0, l - link_0);
                cross.motor += m;
                cross.link += l;
                cross.motor_link += m * l;
                cross.link_link += l * l;
                cross.motor_motor += m * m;
            }
        }
    }

    /// Returns the statistics of a channel, by its index in [`Channels::all`].
    #[must_use]
    pub fn figures(&self, channel: usize) -> Option<&Figures> {
        self.figures[channel].as_ref()
    }

    /// Returns the range of a channel, by its index in [`Channels::all`].
    #[must_use]
    pub fn extent(&self, channel: usize) -> Option<Extent> {
        Some(self.figures(channel)?.extent())
    }

    /// Returns the correlation of motor and link position of a joint, both relative to their first
    /// sample. Returns `None` unless both are logged and move.
    #[must_use]
    pub fn correlation(&self, joint: usize) -> Option<f64> {
        let cross = self.cross.get(joint)?;
        let scale = (cross.link_link * cross.motor_motor).sqrt();
        (scale > 0.0).then(|| cross.motor_link / scale)
    }

    /// Returns the line of motor position versus link position of a joint; `None` unless both are
    /// logged and move. The slope is the ratio of the two standard deviations (reduced major axis),
    /// so neither position is treated as free of noise.
    #[must_use]
    pub fn line(&self, joint: usize) -> Option<Line> {
        let cross = self.cross.get(joint)?;
        let n = self.samples as f64;
        let link = cross.link_link - cross.link * cross.link / n;
        let motor = cross.motor_motor - cross.motor * cross.motor / n;
        let both = cross.motor_link - cross.motor * cross.link / n;
        (link > 0.0 && motor > 0.0).then(|| Line {
            slope: (motor / link).sqrt().copysign(both),
            correlation: both / (motor * link).sqrt(),
        })
    }

    /// Returns the jump of one of the two positions of a joint.
    pub(crate) fn deflection_jump(&self, joint: usize) -> Option<DeflectionJump> {
        self.deflections.get(joint)?.jump()
    }

    /// Returns whether one of the two positions of a joint jumps against the other one.
    #[must_use]
    pub fn loses_counts(&self, joint: usize) -> bool {
        self.deflection_jump(joint).is_some()
    }

    /// Returns the number of samples.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.samples
    }
}
