//! Chooses the cut-off of the position filter from the noise of the positions.

use super::excerpt::Excerpt;
use super::noise::{noise, velocity_per_position};
use crate::description::Weights;
use crate::log::Channels;
use crate::model::Model;

/// Bounds of the choice, Hz. A lower cut-off smears reversals of direction; a higher one only adds
/// noise, because no arm moves so fast.
const LOWEST_HZ: f64 = 10.0;
const HIGHEST_HZ: f64 = 40.0;

/// Upper bound of the cut-off as a fraction of the sampling rate.
const MAX_SHARE_OF_RATE: f64 = 0.2;

/// Returns the upper bound of the cut-off, Hz, for a period, s.
#[must_use]
pub(crate) fn limit_by_rate(period: f64) -> f64 {
    MAX_SHARE_OF_RATE / period
}

/// Allowed noise in the argument of the Coulomb transition, β times the standard deviation of the
/// velocity: with equal weights, and with weights for the transition.
const TRANSITION_NOISE: f64 = 0.08;
const WEIGHTED_TRANSITION_NOISE: f64 = 0.4;

/// Cut-off, Hz, at which the weighted bound holds. Above it the bound falls with the root of the
/// cut-off, because smearing falls faster with the cut-off than noise rises. On the twin, errors
/// are smallest near 13 Hz at 4096 counts and near 26 Hz at 16384.
const WEIGHTED_AT_HZ: f64 = 12.0;

/// Chooses the cut-off of the position filter from the noise of the positions.
///
/// With equal weights this is the highest cut-off at which no velocity's noise, times the sharpness
/// β of its Coulomb friction, exceeds 0.08. With weights for the transition, noise has less effect
/// and smearing more: the bound is 0.4 at 12 Hz and falls with the root of the cut-off above. In
/// both cases the choice lies between 10 and 40 Hz and below a fifth of the sampling rate.
///
/// Returns the cut-off, Hz, and the reason for it.
#[must_use]
pub(crate) fn choose_cutoff(
    model: &Model,
    channels: &Channels,
    weights: Weights,
    excerpt: &Excerpt,
) -> (f64, String) {
    let period = excerpt.period();
    let highest = HIGHEST_HZ.min(limit_by_rate(period));
    let mut best = (highest, None);
    for (i, channel) in channels.all.iter().enumerate() {
        if !channel.quantity.is_position() {
            continue;
        }
        let Some((noise, step)) = noise(excerpt, i) else {
            continue;
        };
        let beta = model.sharpness(channel.joint);
        let per_hertz = beta * noise * velocity_per_position(1.0, period);
        let cutoff = match weights {
            Weights::None => (TRANSITION_NOISE / per_hertz).powf(2.0 / 3.0),
            Weights::Transition => {
                (WEIGHTED_TRANSITION_NOISE * WEIGHTED_AT_HZ.sqrt() / per_hertz).sqrt()
            }
        };
        if cutoff < best.0 {
            best = (cutoff, Some((&channel.column, noise, step)));
        }
    }
    let reason = match best.1 {
        None => {
            "the positions are so fine that their noise needs no lower cut-off; sprung chooses no higher one"
                .to_owned()
        }
        Some((column, noise, step)) => {
            let origin = match step {
                Some(step) => format!("counts of {step:.2e} rad (m)"),
                None => "noise".to_owned(),
            };
            let bound = if best.0 < LOWEST_HZ.min(highest) {
                "; a cut-off below 10 Hz would smear reversals of direction"
            } else {
                ""
            };
            let above = match weights {
                Weights::None => "a higher cut-off would let it through the Coulomb transition",
                Weights::Transition => {
                    "a higher cut-off would smear reversals less, but its noise in the Coulomb \
                     transition would cost more, although samples there have lower weights"
                }
            };
            format!("\"{column}\" has {origin}, {noise:.1e} rad (m) rms: {above}{bound}")
        }
    };
    (best.0.max(LOWEST_HZ.min(highest)), reason)
}
