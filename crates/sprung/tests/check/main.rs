//! Every finding of a check fires on a damaged log, and none fires on an undamaged one.
#![expect(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

mod agreement;
mod delays;
mod factors;
mod unknowns;

// The benchmark `faults` uses the same logs and faults.
#[path = "../../benches/faults/faults.rs"]
mod faults;
#[path = "../twin/in_memory.rs"]
mod in_memory;
#[path = "../twin/logs.rs"]
mod logs;
#[path = "../../benches/faults/twin.rs"]
mod twin;

use std::collections::BTreeSet;
use std::sync::OnceLock;

use faults::{Fault, KINDS, Kind};
use logs::{check_log, identify_log, named};
use rayon::prelude::*;
use sprung_base::finding::Severity;
use sprung_method::check::CheckReport;
use sprung_method::estimate::IdentifyError;
use sprung_method::unknowns::UnknownStatus;
use sprung_model::Model;
use sprung_robot::{Estimator, Experiment, OnCheckError};
use sprung_testing::contains;
use twin::{Demo, Table};

/// Percent of a torque's variance that a good model explains: all but a fifth, root mean square.
const EXPLAINED: f64 = 96.0;

fn report(experiment: &Experiment, table: &Table) -> CheckReport {
    let model = Model::new(experiment).unwrap();
    check_log(experiment, &model, &table.csv())
}

#[test]
fn nothing_is_wrong_with_a_whole_log() {
    let demo = Demo::new();
    for seed in 1..3 {
        let report = report(&demo.experiment, &demo.table(seed, 1.0));
        assert!(report.findings.is_empty(), "{:#?}", report.findings);
        assert!(!report.refused && report.worst().is_none());
        assert_eq!(report.joints.len(), 2);
        for joint in &report.joints {
            // The limit of the findings: a fifth of the torque is unexplained, root mean square.
            assert!(joint.explained_percent > EXPLAINED, "{joint:?}");
        }
        assert!(report.unknowns.is_empty(), "{:#?}", report.unknowns);
        let log = &report.logs[0];
        assert_eq!((log.samples, log.gaps), (10_000, 0));
        for column in &log.columns {
            // Bits of the range over noise times √12. The torques have the fewest: 3 N·m over 0.02 N·m are 5.4 bits.
            assert!(column.effective_bits.unwrap() > 5.0, "{column:?}");
        }
    }
}

#[test]
fn coarse_encoders_alarm_nobody() {
    let demo = Demo::new();
    for seed in 1..3 {
        let report = report(&demo.experiment, &demo.with_counts(seed, 4096));
        // Reversals within one count leave a larger part of the torque unexplained than a good model may; the check
        // knows this.
        assert!(
            report.joints[1].explained_percent < EXPLAINED,
            "{:?}",
            report.joints
        );
        assert!(report.worst().is_none(), "{:#?}", report.findings);
    }
}

#[test]
fn an_encoder_that_lost_its_zero_is_noted() {
    let demo = Demo::new();
    let mut table = demo.table(1, 1.0);
    for phi2 in &mut table.columns[3] {
        *phi2 += 1.5;
    }
    let report = report(&demo.experiment, &table);
    let found = named(&report.findings, "zeros-apart");
    let evidence = found.evidence.as_ref().unwrap();
    assert_eq!(evidence.column.as_deref(), Some("q2_rad"));
    // The inertia beyond the spring at 3° and 1 Hz deflects it by this angle.
    let inertia = 0.013_163 + 0.017_580;
    let deflection = inertia * 3_f64.to_radians() * std::f64::consts::TAU.powi(2) / 4.212_811;
    assert!((evidence.value + 1.5).abs() < deflection, "{evidence:?}");
}

#[test]
fn a_motor_that_counts_back_is_named_with_its_line() {
    let demo = Demo::new();
    for (column, name) in [(2, "phi1_rad"), (3, "phi2_rad")] {
        let mut table = demo.table(1, 1.0);
        table.columns[column]
            .iter_mut()
            .for_each(|phi| *phi = -*phi);
        let report = report(&demo.experiment, &table);
        let first = &report.findings[0];
        assert_eq!(first.code, "opposite-signs", "{:#?}", report.findings);
        let line = format!("[log] sign = {{ \"{name}\" = -1 }}");
        assert_eq!(first.setting.as_deref(), Some(&*line));
    }
}

/// A fault and the report of the check.
struct Checked {
    kind: &'static Kind,
    fault: Fault,
    report: CheckReport,
}

/// Returns a large fault of each kind with its report, which two tests need.
fn faults() -> &'static [Checked] {
    static ALL: OnceLock<Vec<Checked>> = OnceLock::new();
    ALL.get_or_init(|| {
        let demo = Demo::new();
        let check = |kind: &'static Kind| {
            // With this seed, the run of frozen samples is not at a reversal, where the check cannot see it.
            let fault = kind.inject(&demo, kind.sizes[3], 2);
            let report = report(&going_on(&fault.experiment(&demo.experiment)), &fault.table);
            Checked {
                kind,
                fault,
                report,
            }
        };
        KINDS.par_iter().map(check).collect()
    })
}

/// Returns the experiment with least squares alone that continues after errors of the check.
fn going_on(experiment: &Experiment) -> Experiment {
    let mut experiment = experiment.clone();
    experiment.identify.estimator = vec![Estimator::LeastSquares];
    experiment.identify.on_check_error = OnCheckError::GoOn;
    experiment
}

#[test]
fn every_fault_is_found() {
    let mut codes = BTreeSet::new();
    // Least squares do not show every delay of this size.
    let is_delay = |fault: &Checked| fault.kind.codes.contains(&"delayed-channel");
    for Checked { kind, report, .. } in faults().iter().filter(|fault| !is_delay(fault)) {
        let found =
            (report.findings.iter()).find(|finding| kind.codes.contains(&finding.code.as_str()));
        let Some(found) = found else {
            panic!(
                "{} of {} {}: {report:#?}",
                kind.name, kind.sizes[3], kind.unit
            );
        };
        assert!(found.evidence.is_some(), "{found:?}");
        assert!(!found.remedy.is_empty() && !found.text.is_empty());
        codes.insert(found.code.clone());
    }
    assert!(codes.len() >= 15, "{codes:?}");
}

#[test]
fn a_time_in_another_unit_is_refused_with_the_line_that_mends_it() {
    let demo = Demo::new();
    for (size, line) in [
        (1.0, "time_s"),
        (1e3, "time_ms"),
        (1e6, "time_us"),
        (1e9, "time_ns"),
    ] {
        let mut experiment = demo.experiment.clone();
        if line == "time_s" {
            // The column contains seconds and is declared as milliseconds.
            let log = experiment.log.as_mut().unwrap();
            log.time_ms = log.time_s.take();
        }
        let mut table = demo.table(1, 1.0);
        table.time.iter_mut().for_each(|time| *time *= size);
        let report = report(&experiment, &table);
        let found = named(&report.findings, "time-unit");
        assert_eq!(found.severity, Severity::Error);
        let setting = found.setting.as_deref();
        assert_eq!(setting, Some(&*format!("[log] {line} = \"t_s\"")));
        assert!(report.refused);
        let model = Model::new(&experiment).unwrap();
        let refused = identify_log(&experiment, &model, &table.csv());
        let text = refused.unwrap_err().to_string();
        contains(&text, &["(time-unit); in the experiment file"]);
    }
}

/// Checks that a log has one unknown, of one kind and column, which the results use, and returns its size.
fn the_only_unknown(report: &CheckReport, code: &str, kind: &str, column: &str) -> f64 {
    let [unknown] = &report.unknowns[..] else {
        panic!("{:#?}", report.unknowns)
    };
    assert_eq!((&*unknown.kind, &*unknown.place), (kind, column));
    assert_eq!(unknown.status, UnknownStatus::Applied, "{unknown:?}");
    let size = unknown.value.abs();
    assert!(size > 5.0 * unknown.standard_error, "{unknown:?}");
    // A correction needs no warning.
    let found = named(&report.findings, code);
    assert_eq!(found.severity, Severity::Info);
    let evidence = found.evidence.as_ref().unwrap();
    assert_eq!(evidence.column.as_deref(), Some(column));
    assert!(
        report.worst() <= Some(Severity::Info),
        "{:#?}",
        report.findings
    );
    unknown.value
}

#[test]
fn a_late_channel_is_found_and_used() {
    let demo = Demo::new();
    for (place, column) in [(1, "q2_rad"), (4, "tau1_nm"), (5, "tau2_nm")] {
        let late = demo.table(5, 1.0).delayed(place, 20);
        let report = report(&demo.experiment, &late);
        let delay = the_only_unknown(&report, "delayed-channel", "delay", column);
        // Least squares alone: the bias is up to two samples.
        assert!((delay - 0.02).abs() < 2e-3, "{column} {delay}");
    }
}

#[test]
fn an_encoder_offset_is_found_and_used() {
    let demo = Demo::new();
    for (place, column) in [(0, "q1_rad"), (1, "q2_rad")] {
        let mut table = demo.table(5, 1.0);
        table.columns[place].iter_mut().for_each(|q| *q += 0.02);
        let report = report(&demo.experiment, &table);
        let offset = the_only_unknown(&report, "encoder-offset", "offset", column);
        // A correction adds it; friction that is not symmetric leaves an offset of its own.
        assert!((offset + 0.02).abs() < 1e-3, "{column} {offset}");
    }
}

#[test]
fn identify_refuses_what_the_check_refuses() {
    let demo = Demo::new();
    let kind = KINDS
        .iter()
        .find(|kind| kind.name == "sign of a torque")
        .unwrap();
    let Fault { table, .. } = kind.inject(&demo, 1.0, 1);
    let mut experiment = demo.experiment.clone();
    experiment.identify.estimator = vec![Estimator::LeastSquares];
    let model = Model::new(&experiment).unwrap();
    let run = |experiment: &Experiment| identify_log(experiment, &model, &table.csv());
    let refused = run(&experiment).unwrap_err();
    assert!(matches!(refused, IdentifyError::Refused(_)), "{refused}");
    let text = refused.to_string();
    contains(&text, &["sign = { \"tau1_nm\" = -1 }"]);
    contains(&text, &["on_check_error = \"go-on\""]);
    experiment.identify.on_check_error = OnCheckError::GoOn;
    let gone_on = run(&experiment).unwrap().identification;
    let error = gone_on
        .findings
        .iter()
        .find(|f| f.severity == Severity::Error);
    assert_eq!(error.unwrap().code, "reversed-torque");
}
