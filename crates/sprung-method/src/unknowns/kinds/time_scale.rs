//! A clock that runs too fast or too slow: gravity and the inertias of links contradict each other.
//!
//! If a second of the log lasts `c` seconds, accelerations are `c²` times too large. Inertias of any size absorb this, but for those
//! that share the masses with the torques of gravity, so gravity seems to be `c²` times as large.

use super::catalogued::Catalogued;
use super::words::{falls, or_else};
use crate::finding::{Finding, Severity};
use crate::numbers::with_error;
use crate::unknowns::found::Telling;
use crate::unknowns::unknown::{Effect, Kind, Place, Unknown};

/// Usual error of the squared scale, and the least that is no error of the lengths.
const USUAL: f64 = 0.3;
const LEAST: f64 = 0.04;

pub(super) fn list(of: &Catalogued<'_>) -> Vec<Unknown> {
    let gravity = of.model.gravity();
    if of.is_known || gravity.iter().all(|g| *g == 0.0) {
        return Vec::new();
    }
    vec![Unknown {
        scale: USUAL,
        least: LEAST,
        ..Unknown::new(
            "time scale".to_owned(),
            Kind::TimeScale,
            Place::Robot,
            "",
            Effect::Gravity(gravity),
        )
    }]
}

/// Returns the relative change of the time scale of a relative change of gravity.
pub(in crate::unknowns) fn of_gravity(change: f64) -> f64 {
    (1.0 + change).max(0.0).sqrt() - 1.0
}

/// Finding: the time of the log has another scale.
pub(super) fn finding(of: &Telling<'_>) -> Finding {
    let [scale, error] = with_error(1.0 + of.found.value, of.found.standard_error);
    Finding::new(
        Severity::Warning,
        "time-scale",
        format!(
            "gravity and the inertias of the links agree if a second of the log lasts {scale} s (standard error {error} s): {}{}. \
             Lengths of the links or a gravity that are wrong have the same effect",
            falls(of),
            or_else(of)
        ),
        "compare the sampling rate of the recorder with a clock, and the lengths of the links with the robot",
    )
    .seen(of.file, "", of.found.value, "")
}
