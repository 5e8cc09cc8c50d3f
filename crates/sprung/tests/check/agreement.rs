//! `check` and `identify` say the same of a log.

use std::collections::BTreeSet;

use sprung::check::check;
use sprung::description::{Estimator, Experiment, OnCheckError};
use sprung::estimate::identify;
use sprung::finding::Finding;
use sprung::model::Model;
use sprung::progress::Unheard;

use crate::faults::KINDS;
use crate::in_memory::with_source;
use crate::twin::{Demo, Table};

/// Said of results, not of logs.
const OF_RESULTS: &str = "gravity-tilted";

/// Findings in any order.
fn words(findings: &[Finding]) -> BTreeSet<String> {
    (findings.iter())
        .filter(|finding| finding.code != OF_RESULTS)
        .map(|finding| format!("{finding:?}"))
        .collect()
}

/// What both say of a log; nothing of `identify` where no parameters can be estimated.
fn both(experiment: &Experiment, table: &Table) -> (BTreeSet<String>, Option<BTreeSet<String>>) {
    let model = Model::new(experiment).unwrap();
    let mut experiment = experiment.clone();
    experiment.identify.estimator = vec![Estimator::LeastSquares];
    experiment.identify.on_check_error = OnCheckError::GoOn;
    let log = table.csv();
    let checked = with_source(&log, |source| {
        check(&experiment, &model, &mut [source], &mut Unheard)
    });
    let identified = with_source(&log, |source| {
        identify(&experiment, &model, &mut [source], &mut Unheard)
    });
    let identified = identified.ok().map(|found| found.identification.findings);
    (
        words(&checked.unwrap().report.findings),
        identified.as_deref().map(words),
    )
}

#[test]
fn check_and_identify_say_the_same_of_every_fault() {
    let demo = Demo::new();
    let mut compared = 0;
    for kind in &KINDS {
        let fault = kind.inject(&demo, kind.sizes[3], 2);
        let (checked, identified) = both(&fault.experiment(&demo.experiment), &fault.table);
        if let Some(identified) = identified {
            assert_eq!(checked, identified, "{}", kind.name);
            compared += 1;
        }
    }
    assert!(compared > KINDS.len() / 2, "{compared} of {}", KINDS.len());
}

#[test]
fn samples_that_gaps_leave_too_few_of_are_counted_alike() {
    let demo = Demo::new();
    let mut table = demo.table(1, 1.0);
    // Two gaps of 50 ms, 20 samples apart.
    for time in &mut table.time[4000..] {
        *time += 0.05;
    }
    for time in &mut table.time[4020..] {
        *time += 0.05;
    }
    let (checked, identified) = both(&demo.experiment, &table);
    let lost = checked
        .iter()
        .any(|finding| finding.contains("20 samples between gaps"));
    assert!(lost, "{checked:#?}");
    assert_eq!(Some(checked), identified);
}
