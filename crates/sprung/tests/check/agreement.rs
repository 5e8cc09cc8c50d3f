//! `check` and `identify` have the same findings about a log.

use std::collections::BTreeSet;

use rayon::prelude::*;
use sprung_base::finding::Finding;
use sprung_model::Model;
use sprung_robot::{Experiment, Laws};

use crate::logs::identify_log;
use crate::twin::{Demo, Table};
use crate::{faults, going_on, report};

/// Codes of findings about results, which only `identify` has.
const OF_RESULTS: [&str; 3] = ["gravity-tilted", "zero-off", "laws-missing"];

/// Ends of texts by which `identify` turns a warning of the check into a note.
const ENDS: [&str; 2] = [
    ". The intervals and the promise contain the effect",
    ". The likelihood of the whole robot does not confirm",
];

/// Returns findings as a set, because their order may differ. Severities are left out, because
/// `identify` measures the effect on the result.
fn words(findings: &[Finding]) -> BTreeSet<String> {
    (findings.iter())
        .filter(|finding| !OF_RESULTS.contains(&finding.code.as_str()))
        .map(|finding| {
            let text = ENDS.iter().fold(finding.text.as_str(), |text, end| {
                text.split_once(end).map_or(text, |(before, _)| before)
            });
            let Finding {
                code,
                parameters,
                remedy,
                evidence,
                setting,
                ..
            } = finding;
            format!("{code} {parameters:?} {text} {remedy} {evidence:?} {setting:?}")
        })
        .collect()
}

/// Returns the findings of `identify` with the laws of the file, which a check has; `None` if it cannot estimate
/// parameters.
fn identified(experiment: &Experiment, table: &Table) -> Option<BTreeSet<String>> {
    let mut experiment = experiment.clone();
    experiment.identify.laws = Laws::Declared;
    let experiment = &experiment;
    let model = Model::new(experiment).unwrap();
    let found = identify_log(experiment, &model, &table.csv());
    found
        .ok()
        .map(|found| words(&found.identification.findings))
}

#[test]
fn check_and_identify_say_the_same_of_every_fault() {
    let demo = Demo::new();
    let all = faults();
    let compared: Vec<bool> = (all.par_iter())
        .map(|checked| {
            let experiment = going_on(&checked.fault.experiment(&demo.experiment));
            let identified = identified(&experiment, &checked.fault.table);
            if let Some(identified) = &identified {
                let name = checked.kind.name;
                assert_eq!(words(&checked.report.findings), *identified, "{name}");
            }
            identified.is_some()
        })
        .collect();
    let compared = compared.iter().filter(|compared| **compared).count();
    assert!(compared > all.len() / 2, "{compared} of {}", all.len());
}

#[test]
fn samples_that_gaps_leave_too_few_of_are_counted_alike() {
    let demo = Demo::new();
    let mut table = demo.table(1, 1.0);
    // Two gaps of 50 ms with 20 samples between them.
    for time in &mut table.time[4000..] {
        *time += 0.05;
    }
    for time in &mut table.time[4020..] {
        *time += 0.05;
    }
    let experiment = going_on(&demo.experiment);
    let checked = words(&report(&experiment, &table).findings);
    let lost = checked
        .iter()
        .any(|finding| finding.contains("20 samples between gaps"));
    assert!(lost, "{checked:#?}");
    assert_eq!(Some(checked), identified(&experiment, &table));
}
