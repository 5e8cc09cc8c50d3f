//! Estimates of the delays of channels from the normal equations.

use sprung_core::linear::dot;

use super::filter::NormalEquations;
use super::sandwich::{Influence, widening};
use super::solve::covariance as covariance_of;
use super::unknowns::Unknowns;
use crate::estimate::statistics::between_parts;
use crate::log::{Channels, Signal};
use crate::unknowns::Place;

/// Estimate of the delay of a channel relative to the other channels, or of all torques, s.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ChannelUpdate {
    /// The channel, or all torques.
    pub(super) place: Place,
    /// Index of the channel, or of the first torque, in [`Channels::all`].
    pub(super) channel: usize,
    /// Assumed value.
    pub(super) assumed: f64,
    /// Estimated value minus assumed value.
    pub(super) correction: f64,
    /// Standard error of the value; infinite if the log does not determine it.
    pub(super) standard_error: f64,
    /// Whether the description requests an estimate of this delay.
    pub(super) estimated: bool,
}

impl ChannelUpdate {
    /// Returns whether it is the delay of all torques.
    pub(super) fn is_of_torques(&self) -> bool {
        self.place == Place::All(Signal::Torque)
    }

    /// Returns the estimated value.
    pub(super) fn value(&self) -> f64 {
        self.assumed + self.correction
    }

    /// Returns the correction in standard errors.
    pub(super) fn significance(&self) -> f64 {
        self.correction.abs() / self.standard_error
    }
}

/// Estimate of a delay by one Gauss-Newton step.
struct Step {
    correction: f64,
    influence: Influence,
}

/// Returns the estimate of each delay by one Gauss-Newton step, in which the other unknowns follow. Delays without a
/// request for an estimate are changed one at a time.
///
/// The standard errors contain the scatter of the score over segments of the log, and the changes
/// of the delays between folds. The standard errors by the information alone are too small on
/// real machines.
///
/// - `covariance`: covariance of the unknowns with values and the delays to be estimated, \[count ×
///   count\].
/// - `parts`: normal equations of the folds.
/// - `assumed`: assumed delay of each channel, s.
pub(super) fn channel_updates(
    unknowns: &Unknowns,
    (normal, gradients): (&NormalEquations, &[Vec<f64>]),
    covariance: &[f64],
    parts: &[&NormalEquations],
    duration: f64,
    (channels, assumed): (&Channels, &[f64]),
) -> Vec<ChannelUpdate> {
    let count = covariance.len().isqrt();
    let steps = steps(unknowns, normal, covariance, count);
    let of_parts: Vec<Vec<Step>> = (parts.iter())
        .filter_map(|part| {
            let covariance = covariance_of(&part.first(count).information, count)?;
            Some(self::steps(unknowns, part, &covariance, count))
        })
        .collect();
    let influences: Vec<&Influence> = steps.iter().map(|step| &step.influence).collect();
    let widening = widening(&influences, gradients, duration);
    (unknowns.effects().zip(&steps).enumerate())
        .map(|(i, (effect, step))| {
            let mut of_place =
                (0..channels.all.len()).filter(|&at| effect.place.contains(at, channels));
            let channel = of_place.next().unwrap_or_default();
            let widened = |step: &Step| widening[i] * step.influence.variance.sqrt();
            let moved: Vec<(f64, f64)> = (of_parts.iter())
                .map(|of_part| (of_part[i].correction, widened(&of_part[i])))
                .filter(|(value, error)| value.is_finite() && error.is_finite())
                .collect();
            let between = between_parts(&moved).map_or(0.0, |found| found.standard_error());
            ChannelUpdate {
                place: effect.place,
                channel,
                assumed: assumed[channel],
                correction: step.correction,
                standard_error: widened(step).hypot(between),
                estimated: unknowns.values() + i < count,
            }
        })
        .collect()
}

fn steps(
    unknowns: &Unknowns,
    normal: &NormalEquations,
    covariance: &[f64],
    count: usize,
) -> Vec<Step> {
    let values = unknowns.values();
    (0..unknowns.effects().count())
        .map(|i| {
            let influence = match values + i {
                at if at < count => with_others(covariance, count, at),
                at => beside_others(normal, covariance, count, at),
            };
            let correction = -dot(&influence.row, &normal.gradient);
            Step {
                correction,
                influence,
            }
        })
        .collect()
}

/// Returns the influence on a delay to be estimated, with the other unknowns eliminated.
fn with_others(covariance: &[f64], count: usize, at: usize) -> Influence {
    Influence {
        row: covariance[at * count..(at + 1) * count].to_vec(),
        variance: covariance[at * (count + 1)],
    }
}

/// Returns the influence on a delay that is not among the unknowns, with the unknowns eliminated. Its variance is
/// infinite if the log does not determine the delay.
fn beside_others(
    normal: &NormalEquations,
    covariance: &[f64],
    count: usize,
    at: usize,
) -> Influence {
    let cross = &normal.information[at * normal.count..at * normal.count + count];
    let mut row: Vec<f64> = (covariance.chunks(count).map(|row| -dot(row, cross))).collect();
    let information = normal.information[at * (normal.count + 1)] + dot(&row, cross);
    let variance = information.max(0.0).recip();
    row.resize(at, 0.0);
    row.push(1.0);
    for entry in &mut row {
        *entry /= information;
    }
    Influence { row, variance }
}
