//! The catalogue: one file a kind. A new cause is a file and a line of [`catalogue`].

mod catalogued;
mod changes;
mod delay;
mod drift;
mod eccentricity;
mod gain;
mod laws;
pub(super) mod lost_counts;
mod offset;
mod ripple;
mod saturation;
mod sharpness;
mod time_scale;
mod transmission_error;
mod warm_up;
mod waves;
mod words;

pub(super) use catalogued::Catalogued;
pub(super) use changes::CHANGE;
pub(crate) use delay::late;
pub(crate) use laws::LAWS_MISSING;
pub(crate) use sharpness::LEAST_CHANGE_OF_SHARPNESS;
pub(super) use time_scale::of_gravity;

use super::found::Telling;
use super::unknown::{Kind, Unknown};
use crate::finding::Finding;

/// Returns the finding about an unknown; `None` if the list of unknowns says enough.
pub(super) fn finding(of: &Telling<'_>) -> Option<Finding> {
    Some(match of.found.kind {
        Kind::Delay => delay::finding(of),
        Kind::Timing => delay::timing(of),
        Kind::Gain => gain::finding(of),
        Kind::Offset => offset::finding(of),
        Kind::Drift => drift::finding(of),
        Kind::LostCounts => lost_counts::finding(of),
        Kind::Eccentricity => eccentricity::finding(of),
        Kind::Saturation => saturation::finding(of),
        Kind::Ripple => ripple::finding(of),
        Kind::TransmissionError => transmission_error::finding(of),
        Kind::WarmUp => warm_up::finding(of),
        Kind::TimeScale => time_scale::finding(of),
        Kind::Law => return laws::finding(of),
        // The list of unknowns says it, or the validation.
        Kind::Sharpness | Kind::Friction | Kind::Stiffness | Kind::Play | Kind::Load => {
            return None;
        }
    })
}

/// Returns all unknowns that a log may have.
pub(super) fn catalogue(of: &Catalogued<'_>) -> Vec<Unknown> {
    [
        delay::list,
        gain::list,
        offset::list,
        drift::list,
        lost_counts::list,
        eccentricity::list,
        saturation::list,
        ripple::list,
        transmission_error::list,
        warm_up::list,
        sharpness::list,
        time_scale::list,
        laws::list,
        changes::list,
    ]
    .iter()
    .flat_map(|list| list(of))
    .collect()
}
