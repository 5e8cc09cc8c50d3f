//! Other meanings of the columns of single joints compete by the motor rows: link and motor exchanged,
//! an encoder that counts in the other direction, a motor position of another scale, and columns of
//! two joints swapped. Only the best one of a joint speaks.

use super::context::CheckContext;
use super::resolution::{UNEXPLAINED, beyond_resolution};
use crate::log::{Channels, Quantity};
use crate::prepare::{MotorRowFit, RowFit, fit_rows};

/// Another meaning of the columns is possible if it reduces the residual below this fraction.
pub(super) const BETTER_RESIDUAL_SHARE: f64 = 0.9;

/// Residuals below this part of a torque count as equal.
const SAME_RESIDUAL: f64 = 1e-3;

/// Difference of mean logarithms of residuals below which two meanings explain a torque equally well.
const SAME_GAIN: f64 = 0.1;

/// Another meaning of the columns of one joint, or of a pair of joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Meaning {
    /// Link and motor position are exchanged.
    Exchanged,
    /// The link position counts in the other direction.
    LinkSign,
    /// The motor position counts in the other direction.
    MotorSign,
    /// The motor position moves so many times too far.
    MotorScale(f64),
    /// The columns of a quantity belong to the other joint.
    Swapped(Quantity),
}

/// A meaning that explains the torque of its joints.
#[derive(Clone, Debug)]
pub(super) struct Rival {
    pub(super) meaning: Meaning,
    pub(super) joints: Vec<usize>,
    /// Fits of these joints with this meaning.
    pub(super) fits: Vec<MotorRowFit>,
    /// Mean logarithm by which the residuals fall.
    gain: f64,
}

/// The best meaning of a joint, and others that explain its torque equally well.
pub(super) struct Winner {
    pub(super) best: Rival,
    pub(super) equal: Vec<Meaning>,
}

impl CheckContext<'_> {
    /// Returns the best meanings of the columns of some joints, each joint in at most one of them.
    ///
    /// - `fits`: fits of all joints as the file describes the columns, of few samples.
    /// - `shares`: parts of the torques that the resolution of the positions explains.
    pub(super) fn winners(
        &self,
        fits: &[RowFit],
        doubtful: &[usize],
        shares: &[f64],
    ) -> Vec<Winner> {
        let mut rivals = self.rivals(fits, doubtful);
        // A line is printed only if the corrected log is consistent.
        rivals.retain(|rival| {
            (rival.joints.iter().zip(&rival.fits)).all(|(&joint, fit)| {
                beyond_resolution(fit.relative_residual, shares[joint]) <= UNEXPLAINED
            })
        });
        rivals.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        let mut winners: Vec<Winner> = Vec::new();
        for rival in rivals {
            let shared = (winners.iter_mut()).find(|won| {
                won.best
                    .joints
                    .iter()
                    .any(|joint| rival.joints.contains(joint))
            });
            match shared {
                Some(won) => {
                    let is_equal =
                        rival.joints == won.best.joints && rival.gain > won.best.gain - SAME_GAIN;
                    if is_equal {
                        won.equal.push(rival.meaning);
                    }
                }
                None => winners.push(Winner {
                    best: rival,
                    equal: Vec::new(),
                }),
            }
        }
        winners
    }

    fn rivals(&self, fits: &[RowFit], doubtful: &[usize]) -> Vec<Rival> {
        let channels = self.reading.channels();
        let mut rivals = Vec::new();
        for (k, &one) in doubtful.iter().enumerate() {
            let exchanged = (channels.exchanged(one)).and_then(|now| self.with(&now, &[one]));
            let links = [Quantity::LinkPosition, Quantity::LinkDeflection];
            let has_link = !self.link(one).is_empty();
            let turned = |quantities: &[Quantity]| {
                let fit = self.scaled(quantities, one, -1.0).filter(|_| has_link);
                fit.map(|fit| vec![fit])
            };
            let scale = self.motor_scale(one, &fits[one]);
            let single = [
                (Meaning::Exchanged, exchanged),
                (Meaning::LinkSign, turned(&links)),
                (Meaning::MotorSign, turned(&[Quantity::MotorPosition])),
                (
                    Meaning::MotorScale(scale.map_or(1.0, |(ratio, _)| ratio)),
                    scale.map(|(_, fit)| vec![fit]),
                ),
            ];
            rivals.extend((single.into_iter()).filter_map(|(meaning, now)| {
                Some(rival(meaning, &[one], fits, now?)).filter(|rival| rival.is_better(fits))
            }));
            for &two in &doubtful[k + 1..] {
                rivals.extend(Quantity::all().filter_map(|quantity| {
                    let swapped = channels.swapped(quantity, one, two)?;
                    let now = self.with(&swapped, &[one, two])?;
                    Some(rival(Meaning::Swapped(quantity), &[one, two], fits, now))
                        .filter(|rival| rival.is_better(fits))
                }));
            }
        }
        rivals
    }

    /// Fits the torque rows of some joints with other meanings of the columns.
    fn with(&self, channels: &Channels, joints: &[usize]) -> Option<Vec<MotorRowFit>> {
        let reading = self.reading.with_channels(channels.clone());
        let fits = fit_rows(&self.few, &reading, joints)?;
        Some(fits.iter().map(|fit| fit.short(reading.model())).collect())
    }

    /// Fits the torque row of a joint with one column multiplied by `by`.
    pub(super) fn scaled(
        &self,
        quantities: &[Quantity],
        joint: usize,
        by: f64,
    ) -> Option<MotorRowFit> {
        let channel = (quantities.iter())
            .find_map(|&quantity| self.reading.channels().index(quantity, joint))?;
        let excerpt = self.few.scaled(channel, by);
        let fits = fit_rows(&excerpt, self.reading, &[joint])?;
        Some(fits.first()?.short(self.reading.model()))
    }

    /// Returns whether the two encoders of a joint move against each other.
    pub(super) fn encoders_oppose(&self, joint: usize) -> bool {
        let channels = self.reading.channels();
        let index = |quantity| channels.index(quantity, joint);
        let (Some(motor), Some(link)) = (
            index(Quantity::MotorPosition),
            index(Quantity::LinkPosition),
        ) else {
            return false;
        };
        let mean = |channel: usize| {
            self.excerpt.channel(channel).sum::<f64>() / self.excerpt.samples() as f64
        };
        let (a, b) = (mean(motor), mean(link));
        let pairs = self.excerpt.channel(motor).zip(self.excerpt.channel(link));
        pairs.map(|(x, y)| (x - a) * (y - b)).sum::<f64>() < 0.0
    }
}

impl Rival {
    fn is_better(&self, fits: &[RowFit]) -> bool {
        (self.joints.iter().zip(&self.fits)).all(|(&joint, now)| {
            let before = fits[joint].relative_residual();
            now.plausible && now.relative_residual < BETTER_RESIDUAL_SHARE * before
        })
    }
}

fn rival(meaning: Meaning, joints: &[usize], before: &[RowFit], now: Vec<MotorRowFit>) -> Rival {
    let gains = joints.iter().zip(&now).map(|(&joint, now)| {
        let before = before[joint].relative_residual();
        ((before + SAME_RESIDUAL) / (now.relative_residual + SAME_RESIDUAL)).ln()
    });
    Rival {
        meaning,
        gain: gains.sum::<f64>() / joints.len() as f64,
        joints: joints.to_vec(),
        fits: now,
    }
}
