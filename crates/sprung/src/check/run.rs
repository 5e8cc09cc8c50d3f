//! Checks logs against their description.

use super::assemble::assemble;
use super::examine::examine;
use super::pass::read_all;
use super::result::Checked;
use crate::description::Experiment;
use crate::log::LogSource;
use crate::model::Model;
use crate::prepare::{PrepareError, prepare};
use crate::progress::Listener;

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
    let figures = read_all(prepared.reading(), sources, progress)?;
    let mut found = examine(&prepared, &figures);
    found.findings.extend(prepared.findings());
    Ok(assemble(&prepared, &figures, found))
}
