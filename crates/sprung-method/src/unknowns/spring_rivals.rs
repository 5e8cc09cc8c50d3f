//! Hysteresis and play of springs. Each is applied in earnest in the place of what else was found, and the search is repeated.

use sprung_core::parameters::JointParameter;
use sprung_core::presliding::ELEMENTS;

use super::added_law::may_add_laws;
use super::confirmed_laws::{falls, found_law, of_presliding};
use super::found::Found;
use super::law_columns::{Judged, LawColumns, with_laws_of};
use super::result::{AddedLaw, UnknownResult};
use super::searched::{Settled, applied, searched, told};
use crate::description::SpringTerm;
use crate::finding::Finding;
use crate::prepare::{PrepareError, Prepared, find_plays};
use crate::progress::Listener;
use crate::regression::Reading;

/// Least fall of the held-out error of a joint (logarithm) from which on a law is applied in earnest.
const LEAST_FALL: f64 = 0.1;

/// A law takes the place of what was found if it leaves less than this part of the held-out error.
const REPLACES: f64 = 0.93;

/// Part of the held-out squares of a joint that a cubic spring must leave at most before a play is sought.
const CURVED: f64 = 0.98;

/// Part of the torques that stays unexplained from which on laws are tried without any sign of them.
const MUCH_UNEXPLAINED: f64 = 0.01;

/// What a search found, with laws of springs that took the place of other causes.
pub(super) struct WithSprings {
    /// Before the search, with the laws of springs.
    pub(super) base: Prepared,
    pub(super) found: Settled,
    pub(super) laws: Vec<UnknownResult>,
    pub(super) findings: Vec<Finding>,
    /// Columns of laws with which nothing was found; `None` if no law was tried.
    pub(super) columns: Option<LawColumns>,
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
        columns: None,
    };
    let joints: Vec<usize> = (0..best.base.experiment().robot.joint.len())
        .filter(|&at| may_have(&best, at))
        .collect();
    let delays = best.found.prepared.reading().delays().to_vec();
    let cutoff = best.base.reading().position_cutoff_hz();
    let (laws, columns) = rivals(&best.base, &delays, &joints);
    best.columns = columns;
    for laws in one_of_each_joint(laws) {
        let Some(with) = best.with(&laws, progress)? else {
            continue;
        };
        let is_better =
            |at: usize| left(&with.found, cutoff, at) < REPLACES * left(&best.found, cutoff, at);
        let better: Vec<(usize, Found)> = (laws.iter())
            .filter(|(at, _)| is_better(*at))
            .cloned()
            .collect();
        let with = match better.len() {
            0 => None,
            all if all == laws.len() => Some(with),
            _ => best.with(&better, progress)?,
        };
        best = with.unwrap_or(best);
    }
    Ok(best)
}

impl WithSprings {
    /// Returns what is found with further laws; `None` for a log that cannot be searched.
    fn with(
        &self,
        laws: &[(usize, Found)],
        progress: &mut dyn Listener,
    ) -> Result<Option<Self>, PrepareError> {
        let laws: Vec<Found> = laws.iter().map(|(_, law)| law.clone()).collect();
        let (results, about) = told(&laws, &self.base);
        let base = applied(self.base.clone(), (&laws, &results), progress)?;
        let Some(found) = searched(&base, progress)? else {
            return Ok(None);
        };
        // A law takes the place of another one of its joint.
        let is_kept = |law: &&UnknownResult| results.iter().all(|other| other.place != law.place);
        let kept = self.laws.iter().filter(is_kept).cloned();
        Ok(Some(Self {
            base,
            found,
            laws: kept.chain(results.clone()).collect(),
            findings: [&self.findings[..], &about.findings].concat(),
            columns: None,
        }))
    }
}

/// Returns groups of laws with at most one of each joint, the likeliest first: rows of different joints hardly affect each other.
fn one_of_each_joint(mut laws: Vec<(usize, Found)>) -> Vec<Vec<(usize, Found)>> {
    laws.sort_by(|(_, one), (_, other)| other.fall.total_cmp(&one.fall));
    let mut groups: Vec<Vec<(usize, Found)>> = Vec::new();
    for law in laws {
        match groups
            .iter_mut()
            .find(|group| group.iter().all(|(at, _)| *at != law.0))
        {
            Some(group) => group.push(law),
            None => groups.push(vec![law]),
        }
    }
    groups
}

/// Returns the held-out error of a joint (root mean square) without the faults that were found.
fn left(of: &Settled, cutoff: f64, at: usize) -> f64 {
    let prepared = &of.prepared;
    let reading = prepared.weighted_reading().with_position_cutoff(cutoff);
    let excerpt = of.faultless.as_ref().unwrap_or(prepared.excerpt());
    let judged = Judged::of(excerpt, &reading);
    judged.map_or(f64::INFINITY, |judged| {
        judged.left(at).iter().sum::<f64>().sqrt()
    })
}

/// Returns whether a joint may have a law of its spring that its description lacks: something was found at it, or much of the torques
/// stays unexplained.
fn may_have(of: &WithSprings, at: usize) -> bool {
    let experiment = of.base.experiment();
    let described = &experiment.robot.joint[at];
    let terms = described.spring_terms();
    described.is_flexible()
        && may_add_laws(experiment, at)
        && !terms.contains(&SpringTerm::Hysteresis)
        && !terms.contains(&SpringTerm::Play)
        && (of.found.unknowns.iter().any(|one| is_of_joint(of, one, at))
            || of.found.about.unexplained > Some(MUCH_UNEXPLAINED))
}

/// Returns whether an unknown is at a joint.
fn is_of_joint(of: &WithSprings, one: &UnknownResult, at: usize) -> bool {
    let channels = of.base.reading().channels();
    let mut of_joint = channels.all.iter().filter(|channel| channel.joint == at);
    one.place == of.base.experiment().robot.joint[at].name
        || of_joint.any(|channel| one.place == channel.column)
}

/// Returns the laws of springs whose held-out error is less than without them, each with its joint, and the columns of laws in the log
/// as it is.
///
/// - `delays`: that were found; some may be shadows of these laws.
fn rivals(
    prepared: &Prepared,
    delays: &[f64],
    joints: &[usize],
) -> (Vec<(usize, Found)>, Option<LawColumns>) {
    if joints.is_empty() {
        return (Vec::new(), None);
    }
    let reading = prepared.weighted_reading();
    let Some(columns) = columns_of(prepared, &reading, joints) else {
        return (Vec::new(), None);
    };
    let mut found = rivals_in(prepared, &reading, joints, &columns);
    if delays != reading.delays() {
        let late = reading.with_delays(delays);
        let columns = columns_of(prepared, &late, joints);
        let others = columns.map(|columns| rivals_in(prepared, &late, joints, &columns));
        for rival in others.into_iter().flatten() {
            if found.iter().all(|(_, other)| other.id != rival.1.id) {
                found.push(rival);
            }
        }
    }
    (found, Some(columns))
}

fn law(term: SpringTerm) -> AddedLaw {
    AddedLaw {
        of: "spring".to_owned(),
        law: term.word().to_owned(),
        ..AddedLaw::default()
    }
}

/// Returns the columns of hysteresis and cubic springs of some joints, and of presliding friction.
fn columns_of(prepared: &Prepared, reading: &Reading, joints: &[usize]) -> Option<LawColumns> {
    let terms = [SpringTerm::Hysteresis, SpringTerm::Cubic];
    let springs = (joints.iter()).flat_map(|&at| terms.map(|term| (at, law(term))));
    let laws: Vec<(usize, AddedLaw)> = springs.chain(of_presliding(prepared)).collect();
    LawColumns::new(prepared, reading, &laws)
}

fn rivals_in(
    prepared: &Prepared,
    reading: &Reading,
    joints: &[usize],
    columns: &LawColumns,
) -> Vec<(usize, Found)> {
    let Some(without) = columns.judged(&[]) else {
        return Vec::new();
    };
    let of_joints = |joints: &[usize], term: SpringTerm| -> Vec<(usize, AddedLaw)> {
        joints.iter().map(|&at| (at, law(term))).collect()
    };
    let hysteresis = of_joints(joints, SpringTerm::Hysteresis);
    let of_play = law(SpringTerm::Play);
    let curved = curved(prepared, joints, columns, &without);
    let laws = of_joints(&curved, SpringTerm::Play);
    let with_play = with_laws_of(prepared.experiment(), reading, &laws);
    let plays = with_play.map_or(Vec::new(), |reading| {
        find_plays(&reading, prepared.excerpt(), &curved)
    });
    let play: Vec<(usize, AddedLaw)> = (plays.iter())
        .map(|(at, play)| {
            let law = AddedLaw {
                play_half_width: Some(play.half_width),
                play_centre: Some(play.centre),
                ..of_play.clone()
            };
            (*at, law)
        })
        .collect();
    let mut found = Vec::new();
    for laws in [hysteresis, play] {
        if laws.is_empty() {
            continue;
        }
        let Some(with) = columns.judged(&laws) else {
            continue;
        };
        for (at, law) in laws {
            let both = [without.left(at), with.left(at)];
            if !falls(std::slice::from_ref(&both), LEAST_FALL) {
                continue;
            }
            let of_play = plays.iter().find(|(joint, _)| *joint == at);
            let size = match of_play.filter(|_| law.play_half_width.is_some()) {
                Some((_, play)) => (play.half_width, play.standard_error),
                None => with.sum(&elements(&with, at)),
            };
            found.push((at, found_law(prepared, (at, law), size, &both)));
        }
    }
    found
}

/// Returns the joints whose springs a cubic describes better than a line. It resembles a play, and needs no search.
fn curved(
    prepared: &Prepared,
    joints: &[usize],
    columns: &LawColumns,
    without: &Judged,
) -> Vec<usize> {
    let terms = |at: usize| prepared.experiment().robot.joint[at].spring_terms();
    let (known, open): (Vec<usize>, Vec<usize>) =
        (joints.iter()).partition(|&&at| terms(at).contains(&SpringTerm::Cubic));
    let laws: Vec<(usize, AddedLaw)> = (open.iter())
        .map(|&at| (at, law(SpringTerm::Cubic)))
        .collect();
    let with = columns.judged(&laws);
    let is_curved = |at: usize| {
        with.as_ref().is_none_or(|with| {
            let sum = |of: &Judged| of.left(at).iter().sum::<f64>();
            sum(with) < CURVED * sum(without)
        })
    };
    let curved = open.into_iter().filter(|&at| is_curved(at));
    known.into_iter().chain(curved).collect()
}

/// Returns the parameters of the hysteresis of a spring.
fn elements(of: &Judged, at: usize) -> Vec<usize> {
    (0..ELEMENTS as u8)
        .filter_map(|element| of.index(JointParameter::Hysteresis(element), at))
        .collect()
}
