//! Estimated delays, accurate to a fraction of a sample.

use sprung_method::estimate::Identification;
use sprung_method::unknowns::UnknownStatus;
use sprung_model::Model;
use sprung_robot::{Delay, Estimator};

use super::logs::identify_log;
use super::twin::Demo;

/// A column that is late by a number of samples.
struct Late<'n> {
    column: usize,
    name: &'n str,
    samples: usize,
}

/// Identifies a log of the twin in which columns are late.
fn late(late: &[Late<'_>]) -> Identification {
    let demo = Demo::new();
    let mut experiment = demo.experiment.clone();
    experiment.identify.estimator = vec![Estimator::PredictionError];
    let log = experiment.log.as_mut().unwrap();
    let mut table = demo.table(2000, 1.0);
    for late in late {
        log.delay_s.insert(late.name.to_owned(), Delay::Estimate);
        table = table.delayed(late.column, late.samples);
    }
    let model = Model::new(&experiment).unwrap();
    // Half of the log: a search takes several seconds of processor time. The benchmark `delays` has whole logs.
    table.time.truncate(5000);
    for column in &mut table.columns {
        column.truncate(5000);
    }
    let found = identify_log(&experiment, &model, &table.csv());
    found.unwrap().identification
}

#[test]
fn delays_of_a_link_are_found() {
    for (column, name, samples) in [(1, "q2_rad", 20), (0, "q1_rad", 0)] {
        let found = late(&[Late {
            column,
            name,
            samples,
        }]);
        let used = found.log.delay_s[name];
        let off = used.value - 1e-3 * samples as f64;
        // The promise is a fifth of a sample, so a standard error of a twentieth.
        let error = used.standard_error.unwrap();
        assert!(off.abs() < 4.0 * error, "{name} {samples}: {used:?}");
        assert!(error < 0.05 * 1e-3, "{used:?}");
        let refined = found.results[0].refined();
        let refined = refined.unwrap_or_else(|| panic!("{:#?}", found.results[0].warnings));
        let delay = refined.delays.iter().find(|delay| delay.column == name);
        let delay = delay.unwrap();
        assert_eq!(delay.delay_s.to_bits(), used.value.to_bits());
        // The delay that the parameters assume is within a tenth of a standard error of it, where the refinement settles.
        assert!((delay.used_s - used.value).abs() < 0.1 * error, "{delay:?}");
        let warnings = found.results[0].warnings.iter();
        let codes: Vec<&str> = warnings.map(|finding| finding.code.as_str()).collect();
        assert!(codes.contains(&"delay-estimated"), "{codes:?}");
        let id = format!("delay {name}");
        let asked = found.unknowns.iter().find(|unknown| unknown.id == id);
        assert!(
            asked.is_none_or(|asked| asked.status == UnknownStatus::Estimated),
            "{asked:?}"
        );
        assert!(asked.is_some() || samples == 0, "{:#?}", found.unknowns);
    }
}

#[test]
fn two_delays_of_one_joint_are_found() {
    let found = late(&[
        Late {
            column: 0,
            name: "q1_rad",
            samples: 12,
        },
        Late {
            column: 4,
            name: "tau1_nm",
            samples: 7,
        },
    ]);
    for (name, delay) in [("q1_rad", 12e-3), ("tau1_nm", 7e-3)] {
        let used = found.log.delay_s[name];
        let error = used.standard_error.unwrap();
        assert!(
            (used.value - delay).abs() < 5.0 * error.max(1e-5),
            "{name} {used:?}"
        );
        assert!(error < 1e-3, "{name} {used:?}");
    }
}
