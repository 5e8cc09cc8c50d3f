//! Estimates of channel delays from the normal equations.

use super::filter::NormalEquations;
use super::unknowns::Unknowns;

/// Estimate of the delay of a channel relative to the other channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DelayUpdate {
    /// Index in [`Channels::all`](crate::log::Channels::all).
    pub(super) channel: usize,
    /// Assumed delay, s.
    pub(super) assumed: f64,
    /// Estimated delay minus assumed delay, s.
    pub(super) correction: f64,
    /// Standard error of the delay, s.
    pub(super) standard_error: f64,
    /// Whether the description asks to estimate this delay.
    pub(super) estimated: bool,
}

impl DelayUpdate {
    /// Returns the estimated delay, s.
    pub(super) fn delay(&self) -> f64 {
        self.assumed + self.correction
    }
}

/// Returns the estimate of each delay by one Gauss-Newton step, in which the other unknowns follow.
/// Delays that are not to be estimated are moved one at a time.
///
/// - `covariance`: covariance of the unknowns with values and the delays to be estimated, \[count ×
///   count\].
/// - `assumed`: assumed delay of each channel, s.
pub(super) fn delay_updates(
    unknowns: &Unknowns,
    normal: &NormalEquations,
    covariance: &[f64],
    count: usize,
    assumed: &[f64],
) -> Vec<DelayUpdate> {
    let values = unknowns.values();
    (unknowns.delayed().enumerate())
        .map(|(i, channel)| {
            let at = values + i;
            let estimated = at < count;
            let (information, gradient) = if estimated {
                with_others(normal, covariance, count, at)
            } else {
                beside_others(normal, covariance, count, at)
            };
            DelayUpdate {
                channel,
                assumed: assumed[channel],
                correction: -gradient / information,
                standard_error: information.max(0.0).sqrt().recip(),
                estimated,
            }
        })
        .collect()
}

/// Returns information and gradient of a delay to be estimated, with the other unknowns eliminated.
fn with_others(
    normal: &NormalEquations,
    covariance: &[f64],
    count: usize,
    at: usize,
) -> (f64, f64) {
    let row = &covariance[at * count..(at + 1) * count];
    let step: f64 = row.iter().zip(&normal.gradient).map(|(c, g)| c * g).sum();
    let information = covariance[at * (count + 1)].recip();
    (information, step * information)
}

/// Returns information and gradient of a delay that is not among the unknowns, with the unknowns
/// eliminated.
fn beside_others(
    normal: &NormalEquations,
    covariance: &[f64],
    count: usize,
    at: usize,
) -> (f64, f64) {
    let mut information = normal.information[at * (normal.count + 1)];
    let mut gradient = normal.gradient[at];
    let cross = &normal.information[at * normal.count..at * normal.count + count];
    for (j, a) in cross.iter().enumerate() {
        let row = &covariance[j * count..(j + 1) * count];
        for (k, factor) in row.iter().enumerate() {
            information -= a * factor * cross[k];
            gradient -= a * factor * normal.gradient[k];
        }
    }
    (information, gradient)
}
