//! Figures gathered while a log is read.

use super::LogBlock;
use super::channels::{Channels, Quantity};

/// What one channel did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// First value.
    pub first: f64,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
}

impl Extent {
    /// Returns whether the channel never changed.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        self.min.to_bits() == self.max.to_bits()
    }

    /// Returns the difference between the largest and the smallest value.
    #[must_use]
    pub fn range(&self) -> f64 {
        self.max - self.min
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Cross {
    motor_link: f64,
    link_link: f64,
    motor_motor: f64,
}

/// Figures of all channels of a log.
#[derive(Clone, Debug)]
pub struct Summary {
    extents: Vec<Option<Extent>>,
    pairs: Vec<Option<(usize, usize)>>,
    cross: Vec<Cross>,
    samples: u64,
}

impl Summary {
    /// Returns the summary of a log of which nothing was read.
    #[must_use]
    pub fn new(channels: &Channels) -> Self {
        let pairs: Vec<Option<(usize, usize)>> = (0..channels.rigid.len())
            .map(|joint| {
                let motor = channels.index(Quantity::MotorPosition, joint)?;
                let link = channels.index(Quantity::LinkPosition, joint)?;
                Some((motor, link))
            })
            .collect();
        Self {
            extents: vec![None; channels.all.len()],
            cross: vec![Cross::default(); pairs.len()],
            pairs,
            samples: 0,
        }
    }

    /// Takes the next block.
    pub fn take(&mut self, block: &LogBlock) {
        self.samples += block.len() as u64;
        for (extent, values) in self.extents.iter_mut().zip(&block.values) {
            let Some(&first) = values.first() else {
                continue;
            };
            let extent = extent.get_or_insert(Extent {
                first,
                min: first,
                max: first,
            });
            for &value in values {
                extent.min = extent.min.min(value);
                extent.max = extent.max.max(value);
            }
        }
        for (cross, pair) in self.cross.iter_mut().zip(&self.pairs) {
            let Some((motor, link)) = *pair else { continue };
            // Measured from the first sample, so that no offset counts.
            let from = |channel: usize| self.extents[channel].map_or(0.0, |extent| extent.first);
            let (motor_0, link_0) = (from(motor), from(link));
            for (m, l) in block.values[motor].iter().zip(&block.values[link]) {
                let (m, l) = (m - motor_0, l - link_0);
                cross.motor_link += m * l;
                cross.link_link += l * l;
                cross.motor_motor += m * m;
            }
        }
    }

    /// Returns what a channel did, by its index in [`Channels::all`].
    #[must_use]
    pub fn extent(&self, channel: usize) -> Option<Extent> {
        self.extents[channel]
    }

    /// Returns the correlation of motor and link position of a joint, both
    /// from their first sample on, if both are logged and moved.
    #[must_use]
    pub fn correlation(&self, joint: usize) -> Option<f64> {
        let cross = self.cross.get(joint)?;
        let scale = (cross.link_link * cross.motor_motor).sqrt();
        (scale > 0.0).then(|| cross.motor_link / scale)
    }

    /// Returns the number of samples.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.samples
    }
}
