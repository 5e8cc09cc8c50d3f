//! Checks logs against their description.

use super::assemble::assemble;
use super::examine::{OfLog, examine, is_wrong_itself};
use super::pass::read_all;
use super::result::Checked;
use super::unknowns::settled_or_other_meaning;
use crate::description::Experiment;
use crate::finding::Finding;
use crate::frequency::{Record, about_springs, springs_from_motor};
use crate::log::LogSource;
use crate::model::Model;
use crate::prepare::{PrepareError, Prepared, prepare};
use crate::progress::Listener;
use crate::regression::observed_signals;
use crate::unknowns::{Settled, UnknownStatus};

/// Checks logs against their description, prepared as an identification prepares them.
///
/// Each log is read once, block by block, after the beginning of the first log; memory does not
/// grow with the logs.
///
/// - `sources`: the logs, all with the same columns.
/// - `progress`: receives each choice and the number of samples read so far.
///
/// # Errors
///
/// [`PrepareError`] if the description is not complete or a log cannot be read. The report contains
/// the faults of a readable log.
pub fn check(
    experiment: &Experiment,
    model: &Model,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<Checked, PrepareError> {
    let prepared = prepare(experiment, model, sources, progress)?;
    let Settled {
        prepared,
        mut unknowns,
        about,
        ..
    } = settled_or_other_meaning(prepared, progress)?;
    let figures = read_all(prepared.reading(), sources, progress)?;
    let mut found = examine(&prepared, &OfLog::of_each(&prepared, &figures), &about);
    if is_wrong_itself(&found.findings) {
        unknowns.retain(|unknown| unknown.status != UnknownStatus::Found);
    }
    for (joint, found_joint) in found.joints.iter_mut().enumerate() {
        let line = (figures.first()).and_then(|first| first.summary.line(joint));
        found_joint.slope = line.map(|line| line.slope);
    }
    found.findings.extend(prepared.findings());
    found.findings.extend(springs(&prepared));
    Ok(assemble(&prepared, &figures, found, unknowns))
}

/// Returns findings about the springs from the motors that the settings request, by the beginning of the first log.
fn springs(prepared: &Prepared) -> Vec<Finding> {
    let (reading, excerpt) = (prepared.reading(), prepared.excerpt());
    if !reading.settings().springs_from_motor {
        return Vec::new();
    }
    let mut record = Record::new(reading.model().joint_count());
    let (period, blocks) = (excerpt.period(), excerpt.blocks());
    if observed_signals(reading, period, blocks, &mut record).is_err() {
        return Vec::new();
    }
    let springs = springs_from_motor(&record, reading.model());
    let file = prepared.names().first().map_or("", String::as_str);
    about_springs(&springs, reading.model(), file)
}
