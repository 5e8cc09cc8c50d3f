//! The catalogue: one file a kind. A new cause is a file and a line of [`catalogue`].

mod catalogued;
mod delay;
mod drift;
mod eccentricity;
mod gain;
mod laws;
pub(super) mod lost_counts;
mod offset;
mod words;

pub(super) use catalogued::Catalogued;

use super::found::Telling;
use super::unknown::Unknown;
use crate::finding::Finding;

/// Returns the finding about an unknown.
pub(super) fn finding(of: &Telling<'_>) -> Finding {
    match of.found.kind {
        "delay" => delay::finding(of),
        "timing" => delay::timing(of),
        "gain" => gain::finding(of),
        "offset" => offset::finding(of),
        "drift" => drift::finding(of),
        "lost-counts" => lost_counts::finding(of),
        _ => eccentricity::finding(of),
    }
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
        laws::list,
    ]
    .iter()
    .flat_map(|list| list(of))
    .collect()
}
