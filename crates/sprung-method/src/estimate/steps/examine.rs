//! The third step: findings about the logs, before anything is estimated from them.

use super::pass::ReadLogs;
use super::prepare::Ready;
use super::refuse::refuse;
use crate::check;
use crate::estimate::errors::IdentifyError;
use crate::estimate::judge::at_rest;
use crate::finding::{Finding, Severity};
use crate::unknowns::LAWS_MISSING;

/// Returns all findings about the logs.
///
/// # Errors
///
/// [`IdentifyError::Refused`] if the logs contradict the experiment file.
pub(in crate::estimate) fn examine(
    ready: &Ready,
    read: &ReadLogs,
) -> Result<Vec<Finding>, IdentifyError> {
    let prepared = &ready.prepared;
    let mut about_logs = examine_or_refuse(ready, read)?;
    // A faulty log resembles missing laws.
    let is_other = |finding: &Finding| finding.code != LAWS_MISSING;
    let is_faulty = (about_logs.iter().filter(|finding| is_other(finding)))
        .any(|finding| finding.severity > Severity::Info);
    about_logs.retain(|finding| !is_faulty || is_other(finding));
    about_logs.extend(at_rest(prepared, &read.system));
    Ok(about_logs)
}

/// Returns the findings about the logs. Refuses logs that contradict the experiment file.
fn examine_or_refuse(ready: &Ready, read: &ReadLogs) -> Result<Vec<Finding>, IdentifyError> {
    let prepared = &ready.prepared;
    let examined = check::examine(prepared, &read.examined, &ready.about_unknowns);
    refuse(prepared.reading().settings(), &examined.findings)?;
    let mut findings = prepared.findings();
    findings.extend(examined.findings);
    Ok(findings)
}
