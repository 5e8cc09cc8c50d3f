//! What a search found, and what a finding says of it.

use super::result::{AddedLaw, UnknownStatus};
use super::unknown::{Kind, Place, wave};
use crate::prepare::Excerpt;

/// A rival of an unknown.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Competing {
    /// Id of the rival.
    pub(crate) id: String,
    /// Correlation of both columns without what parameters and other unknowns explain.
    pub(crate) correlation: f64,
}

/// An unknown that was found.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Found {
    /// Stable name, as in `delay q1_rad`.
    pub(crate) id: String,
    pub(crate) kind: Kind,
    pub(crate) place: Place,
    /// Size, and its standard error.
    pub(crate) value: f64,
    pub(crate) standard_error: f64,
    pub(crate) unit: &'static str,
    /// Time at which it begins, s.
    pub(crate) begins: Option<f64>,
    /// The law that it adds to a description.
    pub(crate) law: Option<AddedLaw>,
    /// Relative fall of the held-out squares of the torques.
    pub(crate) gain: f64,
    /// Part of its column that no parameter mimics.
    pub(crate) own: f64,
    /// Parameter that mimics most of it.
    pub(crate) mimic: Option<String>,
    /// Relative fall of the error of the joint's torques by the laws of a joint (root mean square), on held-out parts.
    pub(crate) fall: f64,
    /// Others that may stand for it.
    pub(crate) competing: Vec<Competing>,
}

/// Returns the amplitude of two phases of a wave, and its standard error.
pub(super) fn amplitude(one: [f64; 2], other: [f64; 2]) -> [f64; 2] {
    let value = one[0].hypot(other[0]);
    let error = (one[0] * one[1]).hypot(other[0] * other[1]);
    [value, error / value.max(f64::MIN_POSITIVE)]
}

/// Returns what was found with one entry for both phases of a wave.
pub(super) fn with_whole_waves(found: Vec<Found>) -> Vec<Found> {
    let mut whole: Vec<Found> = Vec::new();
    for mut one in found {
        let Some(id) = wave(one.kind, &one.id).map(str::to_owned) else {
            whole.push(one);
            continue;
        };
        let Some(first) = whole.iter_mut().find(|first| first.id == id) else {
            (one.id, one.value) = (id, one.value.abs());
            whole.push(one);
            continue;
        };
        let phases = [&*first, &one].map(|phase| [phase.value, phase.standard_error]);
        [first.value, first.standard_error] = amplitude(phases[0], phases[1]);
        first.gain = first.gain.max(one.gain);
    }
    whole
}

/// What a finding says of.
pub(super) struct Telling<'a> {
    pub(super) found: &'a Found,
    /// Its columns.
    pub(super) columns: Vec<&'a str>,
    /// Name of its joint; empty for all joints.
    pub(super) joint: &'a str,
    pub(super) file: &'a str,
    pub(super) status: UnknownStatus,
    /// Whether it is a law that sprung adds with laws = "auto".
    pub(super) is_addable: bool,
    pub(super) excerpt: &'a Excerpt,
    /// Which parameter would move with it, if only the likelihood shows it.
    pub(super) moves: Option<&'a str>,
    /// Factor of the gain in its line: of an estimated gain, or 1 for a number of the file; `None` without a gain.
    pub(super) gain: Option<f64>,
}
