//! Refuses logs that contradict the experiment file.

use crate::check::Refusal;
use crate::description::{Identify, OnCheckError};
use crate::estimate::errors::IdentifyError;
use crate::finding::{Finding, Severity};

/// Refuses the logs if a finding is an error, unless the settings request to continue.
pub(super) fn refuse<'a>(
    settings: &Identify,
    findings: impl IntoIterator<Item = &'a Finding>,
) -> Result<(), IdentifyError> {
    let errors: Vec<Finding> = (findings.into_iter())
        .filter(|finding| finding.severity == Severity::Error)
        .cloned()
        .collect();
    if errors.is_empty() || settings.on_check_error == OnCheckError::GoOn {
        return Ok(());
    }
    Err(IdentifyError::Refused(Refusal(errors)))
}
