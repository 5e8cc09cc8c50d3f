//! The cut-off of the position filter, chosen from the noise of the positions.

use super::excerpt::Excerpt;
use super::noise::{noise, velocity_per_position};
use crate::description::Weights;
use crate::log::{Channels, Quantity};
use crate::model::Model;

/// Bounds of what is chosen, Hz: below the first the filter smears reversals of
/// direction, above the second it passes what no arm does.
const LOWEST_HZ: f64 = 10.0;
const HIGHEST_HZ: f64 = 40.0;

/// Part of the sampling rate that the cut-off stays below.
const SHARE_OF_RATE: f64 = 0.2;

/// How far noise may move through the Coulomb transition, beta times the
/// standard deviation of the velocity: where all samples count alike, and where
/// those in the transition count less.
const TRANSITION_NOISE: f64 = 0.08;
const WEIGHTED_TRANSITION_NOISE: f64 = 0.4;

/// Cut-off, Hz, at which weighted samples bear that much; with finer positions,
/// and so a higher cut-off, less by its root. What a filter smears falls
/// faster with its cut-off than what noise does rises, and on the twin errors
/// are least near 13 Hz at 4096 counts and near 26 Hz at 16384.
const WEIGHTED_AT_HZ: f64 = 12.0;

/// Chooses the cut-off of the position filter from the noise of the positions.
///
/// Where all samples count alike it is the highest at which no velocity's noise,
/// times the sharpness β of its Coulomb friction, exceeds 0.08. Where samples in the
/// transition count less, noise harms less and what the filter smears counts more:
/// the bound is 0.4 at 12 Hz and falls with the root of the cut-off above. Either way
/// the choice lies between 10 and 40 Hz, and below a fifth of the sampling rate.
///
/// Returns it in Hz, and why.
#[must_use]
pub(crate) fn choose_cutoff(
    model: &Model,
    channels: &Channels,
    weights: Weights,
    excerpt: &Excerpt,
) -> (f64, String) {
    let period = excerpt.period();
    let highest = HIGHEST_HZ.min(SHARE_OF_RATE / period);
    let mut best = (highest, None);
    for (i, channel) in channels.all.iter().enumerate() {
        if channel.quantity == Quantity::MotorTorque {
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
            "the positions are so fine that their noise asks for no lower one; none higher is chosen"
                .to_owned()
        }
        Some((column, noise, step)) => {
            let origin = match step {
                Some(step) => format!("counts of {step:.2e} rad (m)"),
                None => "noise".to_owned(),
            };
            let bound = if best.0 < LOWEST_HZ.min(highest) {
                "; lower than 10 Hz would smear reversals of direction"
            } else {
                ""
            };
            let above = match weights {
                Weights::None => "a higher cut-off would let it through the Coulomb transition",
                Weights::Transition => {
                    "with a higher cut-off it would cost more in the Coulomb transition, although \
                     samples there count less, than a filter that smears less would gain"
                }
            };
            format!("\"{column}\" has {origin}, {noise:.1e} rad (m) rms: {above}{bound}")
        }
    };
    (best.0.max(LOWEST_HZ.min(highest)), reason)
}
