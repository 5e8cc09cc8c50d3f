//! Logs checked against their description.

use super::examine::examine;
use super::pass::read_all;
use super::result::Checked;
use super::tell::told;
use crate::description::Experiment;
use crate::log::LogSource;
use crate::model::Model;
use crate::prepare::{PrepareError, prepare};
use crate::progress::Listener;

/// Checks logs against their description, prepared as an identification prepares them.
///
/// Each is read once, block by block, and the beginning of the first before; memory does not
/// grow with it.
///
/// - `sources`: the logs, all with the same columns.
/// - `progress`: told of what is chosen and of the samples read so far.
///
/// # Errors
///
/// [`PrepareError`] if the description is not complete or a log cannot be read. A
/// log that is wrong is a report.
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
    Ok(told(&prepared, &figures, found))
}
