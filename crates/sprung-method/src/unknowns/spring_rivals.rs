//! Hysteresis and play of springs. Each is applied in earnest in the place of what else was found, and the search is repeated.

use sprung_core::parameters::JointParameter;
use sprung_core::presliding::ELEMENTS;

use super::added_law::may_add_laws;
use super::confirmed_laws::{Judged, falls, found_law, with_laws_of};
use super::found::Found;
use super::result::{AddedLaw, UnknownResult};
use super::searched::{Settled, applied, searched, told};
use crate::description::SpringTerm;
use crate::finding::Finding;
use crate::prepare::{PrepareError, Prepared, find_play};
use crate::progress::Listener;
use crate::regression::Reading;

/// Least fall of the held-out error of a joint (logarithm) from which on a law is applied in earnest.
const LEAST_FALL: f64 = 0.1;

/// A law takes the place of what was found if it leaves less than this part of the held-out error.
const REPLACES: f64 = 0.93;

/// Part of the torques that stays unexplained from which on laws are tried without any sign of them.
const MUCH_UNEXPLAINED: f64 = 0.01;

/// What a search found, with laws of springs that took the place of other causes.
pub(super) struct WithSprings {
    /// Before the search, with the laws of springs.
    pub(super) base: Prepared,
    pub(super) found: Settled,
    pub(super) laws: Vec<UnknownResult>,
    pub(super) findings: Vec<Finding>,
}

/// Returns what was found, with hysteresis or play where one of them predicts the held-out parts better than all other causes.
///
/// # Errors
///
/// As of [`applied`].
pub(super) fn with_springs(
    base: Prepared,
    found: Settled,
    progress: &mut dyn Listener,
) -> Result<WithSprings, PrepareError> {
    let mut best = WithSprings {
        base,
        found,
        laws: Vec::new(),
        findings: Vec::new(),
    };
    for at in 0..best.base.experiment().robot.joint.len() {
        if may_have(&best, at) {
            let delays = best.found.prepared.reading().delays().to_vec();
            for rival in rivals(&best.base, &delays, at) {
                let (laws, about) = told(std::slice::from_ref(&rival), &best.base);
                let with = applied(
                    best.base.clone(),
                    (std::slice::from_ref(&rival), &laws),
                    progress,
                )?;
                let Some(found) = searched(&with, progress)? else {
                    continue;
                };
                let cutoff = best.base.reading().position_cutoff_hz();
                let left = |of: &Settled| left(&of.prepared, cutoff, at);
                if left(&found) < REPLACES * left(&best.found) {
                    best = WithSprings {
                        base: with,
                        found,
                        laws,
                        findings: about.findings,
                    };
                }
            }
        }
    }
    Ok(best)
}

/// Returns the held-out error of a joint (root mean square).
fn left(prepared: &Prepared, cutoff: f64, at: usize) -> f64 {
    let reading = prepared.weighted_reading().with_position_cutoff(cutoff);
    let judged = Judged::new(prepared, &reading, &[]);
    judged.map_or(f64::INFINITY, |judged| {
        judged.left(at).iter().sum::<f64>().sqrt()
    })
}

/// Returns whether a joint may have a law of its spring that its description lacks: something was found at it, or much of the torques
/// stays unexplained.
fn may_have(of: &WithSprings, at: usize) -> bool {
    let experiment = of.base.experiment();
    let described = &experiment.robot.joint[at];
    let name = &described.name;
    let channels = of.base.reading().channels();
    let columns: Vec<&str> = (channels.all.iter())
        .filter(|channel| channel.joint == at)
        .map(|channel| channel.column.as_str())
        .collect();
    let is_of_joint = |one: &UnknownResult| {
        one.place == *name || columns.iter().any(|column| one.place == *column)
    };
    let terms = described.spring_terms();
    described.is_flexible()
        && may_add_laws(experiment, at)
        && !terms.contains(&SpringTerm::Hysteresis)
        && !terms.contains(&SpringTerm::Play)
        && (of.found.unknowns.iter().any(is_of_joint)
            || of.found.about.unexplained > Some(MUCH_UNEXPLAINED))
}

/// Returns the laws of a joint's spring whose held-out error is less than without them.
///
/// - `delays`: that were found; some may be shadows of these laws.
fn rivals(prepared: &Prepared, delays: &[f64], at: usize) -> Vec<Found> {
    let reading = prepared.weighted_reading();
    let mut found = rivals_in(prepared, &reading, at);
    if delays != reading.delays() {
        for rival in rivals_in(prepared, &reading.with_delays(delays), at) {
            if found.iter().all(|other| other.id != rival.id) {
                found.push(rival);
            }
        }
    }
    found
}

fn rivals_in(prepared: &Prepared, reading: &Reading, at: usize) -> Vec<Found> {
    let Some(without) = Judged::new(prepared, reading, &[]) else {
        return Vec::new();
    };
    let law = |term: SpringTerm| AddedLaw {
        of: "spring".to_owned(),
        law: term.word().to_owned(),
        ..AddedLaw::default()
    };
    let judged = |law: &AddedLaw| {
        let with = Judged::new(prepared, reading, &[(at, law.clone())])?;
        let both = [without.left(at), with.left(at)];
        falls(std::slice::from_ref(&both), LEAST_FALL).then_some((with, both))
    };
    let hysteresis = || {
        let law = law(SpringTerm::Hysteresis);
        let (with, both) = judged(&law)?;
        let parameters: Vec<usize> = (0..ELEMENTS as u8)
            .filter_map(|at_element| with.index(JointParameter::Hysteresis(at_element), at))
            .collect();
        let sum = with.sum(&parameters);
        Some(found_law(prepared, (at, law), sum, &both))
    };
    let play = || {
        let law = law(SpringTerm::Play);
        let reading = with_laws_of(prepared, reading, [(at, &law)].into_iter())?;
        let play = find_play(&reading, prepared.excerpt(), at)?;
        let law = AddedLaw {
            play_half_width: Some(play.half_width),
            play_centre: Some(play.centre),
            ..law
        };
        let (_, both) = judged(&law)?;
        let size = (play.half_width, play.standard_error);
        Some(found_law(prepared, (at, law), size, &both))
    };
    hysteresis().into_iter().chain(play()).collect()
}
