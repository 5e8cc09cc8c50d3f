//! Identifications and checks of logs in memory, and their findings.

use sprung_base::finding::Finding;
use sprung_base::progress::Unheard;
use sprung_method::check::{CheckReport, check};
use sprung_method::estimate::{Identified, IdentifyError, identify};
use sprung_model::Model;
use sprung_robot::Experiment;

use crate::in_memory::with_source;

pub(crate) fn identify_log(
    experiment: &Experiment,
    model: &Model,
    log: &[u8],
) -> Result<Identified, IdentifyError> {
    with_source(log, |source| {
        identify(experiment, model, &mut [source], &mut Unheard)
    })
}

pub(crate) fn check_log(experiment: &Experiment, model: &Model, log: &[u8]) -> CheckReport {
    with_source(log, |source| {
        let checked = check(experiment, model, &mut [source], &mut Unheard);
        checked.unwrap().report
    })
}

/// Returns the finding with a code.
#[track_caller]
pub(crate) fn named<'f>(findings: &'f [Finding], code: &str) -> &'f Finding {
    let found = findings.iter().find(|finding| finding.code == code);
    found.unwrap_or_else(|| panic!("no {code} in {findings:#?}"))
}
