//! Estimated signs and gains.

use sprung_method::prepare::{FactorError, Factors, find_factors};
use sprung_model::Model;
use sprung_robot::{Delay, Experiment, Factor};
use sprung_testing::{contains, largest_of_normals};

use super::in_memory::with_source;
use super::logs::{identify_log, named};
use super::twin::{Demo, Table};

const COLUMNS: [&str; 6] = [
    "q1_rad", "q2_rad", "phi1_rad", "phi2_rad", "tau1_nm", "tau2_nm",
];

/// Largest standard error of a gain relative to its value with which a comparison with the truth says something.
const USEFUL: f64 = 0.05;

fn find(experiment: &Experiment, table: &Table) -> Result<Factors, FactorError> {
    let model = Model::new(experiment).unwrap();
    with_source(&table.csv(), |source| {
        find_factors(experiment, &model, &mut [source]).map(|(_, found)| found)
    })
}

fn times(table: &Table, column: usize, by: f64) -> Table {
    let mut table = table.clone();
    table.columns[column]
        .iter_mut()
        .for_each(|value| *value *= by);
    table
}

fn asked(experiment: &Experiment, signs: &[&str], gains: &[&str]) -> Experiment {
    let mut experiment = experiment.clone();
    let log = experiment.log.as_mut().unwrap();
    for name in signs {
        log.sign.insert((*name).to_owned(), Factor::Estimate);
    }
    for name in gains {
        log.gain.insert((*name).to_owned(), Factor::Estimate);
    }
    experiment
}

#[test]
fn signs_of_every_column_are_found() {
    let demo = Demo::new();
    let table = demo.table(1, 1.0);
    for (column, name) in COLUMNS.into_iter().enumerate() {
        let experiment = asked(&demo.experiment, &[name], &[]);
        for sign in [1.0, -1.0] {
            let found = find(&experiment, &times(&table, column, sign)).unwrap();
            let estimate = &found.signs[0];
            assert_eq!(
                (estimate.column.as_str(), estimate.value),
                (name, sign),
                "{estimate:?}"
            );
            // Odds of e²⁰ leave no doubt.
            assert!(estimate.log_likelihood > 20.0, "{estimate:?}");
        }
    }
    // A wrong link and its torque together, and one wrong link of two.
    let two = asked(&demo.experiment, &["q1_rad", "tau1_nm"], &[]);
    let found = find(&two, &times(&times(&table, 0, -1.0), 4, -1.0)).unwrap();
    let values: Vec<f64> = found.signs.iter().map(|sign| sign.value).collect();
    assert_eq!(values, [-1.0, -1.0]);
    let two = asked(&demo.experiment, &["q1_rad", "q2_rad"], &[]);
    let found = find(&two, &times(&table, 1, -1.0)).unwrap();
    let values: Vec<f64> = found.signs.iter().map(|sign| sign.value).collect();
    assert_eq!(values, [1.0, -1.0]);
}

#[test]
fn a_sign_is_found_together_with_a_delay() {
    let demo = Demo::new();
    let table = demo.table(1, 1.0);
    for (column, name) in COLUMNS.into_iter().enumerate() {
        let mut experiment = asked(&demo.experiment, &[name], &[]);
        let log = experiment.log.as_mut().unwrap();
        log.delay_s.insert(name.to_owned(), Delay::Estimate);
        let late = table.delayed(column, 40);
        for sign in [1.0, -1.0] {
            let found = find(&experiment, &times(&late, column, sign)).unwrap();
            let estimate = &found.signs[0];
            assert!((estimate.value - sign).abs() < f64::EPSILON, "{estimate:?}");
        }
    }
}

#[test]
fn signs_that_a_log_does_not_tell_are_refused() {
    let demo = Demo::new();
    let table = demo.table(1, 1.0);
    let all = asked(&demo.experiment, &["q1_rad", "phi1_rad", "tau1_nm"], &[]);
    let error = find(&all, &table).unwrap_err().to_string();
    contains(&error, &["reversing all of them"]);
    let mut still = table;
    for column in [0, 2, 4] {
        still.columns[column].fill(0.0);
    }
    let one = asked(&demo.experiment, &["tau1_nm"], &[]);
    let error = find(&one, &still).unwrap_err().to_string();
    contains(&error, &["\"tau1_nm\" cannot be determined"]);
}

#[test]
fn a_log_that_least_squares_leave_unexplained_is_not_refined_by_default() {
    let demo = Demo::new();
    let mut experiment = demo.experiment.clone();
    experiment.identify.estimator.clear();
    let model = Model::new(&experiment).unwrap();
    let mut table = demo.table(1, 1.0);
    let torque = &mut table.columns[4];
    let rms = (torque.iter().map(|tau| tau * tau).sum::<f64>() / torque.len() as f64).sqrt();
    // A third of the torque is no effect of this robot.
    for (k, tau) in torque.iter_mut().enumerate() {
        *tau += 0.5 * rms * (0.031 * k as f64).sin();
    }
    let found = identify_log(&experiment, &model, &table.csv());
    let results = found.unwrap().identification.results;
    let used: Vec<&str> = results.iter().map(|one| one.estimator.as_str()).collect();
    assert_eq!(used, ["least-squares"]);
    assert!(results[0].warnings.iter().any(|one| one.code == "poor-fit"));
}

/// Returns the gain of a column that an identification finds, with its standard error.
fn gain(experiment: &Experiment, table: &Table, column: &str) -> Result<[f64; 2], String> {
    let mut experiment = asked(experiment, &[], &[column]);
    experiment.identify.estimator = vec![sprung_robot::Estimator::LeastSquares];
    let model = Model::new(&experiment).unwrap();
    let found = identify_log(&experiment, &model, &table.csv());
    let found = found.map_err(|error| error.to_string())?.identification;
    let gain = found.log.gain[column];
    Ok([gain.value, gain.standard_error])
}

#[test]
fn gains_of_positions_are_found_within_their_errors() {
    let demo = Demo::new();
    let table = demo.table(1, 1.0);
    for (column, name) in COLUMNS.into_iter().enumerate().take(4) {
        for wrong in [1.0, 1.3, 0.4] {
            let [value, error] =
                gain(&demo.experiment, &times(&table, column, wrong), name).unwrap();
            let off = (value * wrong - 1.0) / (error * wrong);
            assert!(error < USEFUL * value, "{name} {wrong}: {value} {error}");
            assert!(
                off.abs() < largest_of_normals(12),
                "{name} {wrong}: {value} {error}"
            );
        }
    }
}

#[test]
fn the_gain_of_a_torque_is_told_by_a_known_parameter_or_by_the_other_torque() {
    let demo = Demo::new();
    let table = times(&demo.table(1, 1.0), 5, 0.5);
    let mut known = demo.experiment.clone();
    let fixed = &mut known.robot.fixed;
    fixed.insert("joint2.stiffness".to_owned(), 4.212_811);
    for experiment in [&known, &demo.experiment] {
        let [value, error] = gain(experiment, &table, "tau2_nm").unwrap();
        assert!((value - 2.0).abs() < 4.0 * error, "{value} {error}");
        assert!(error < USEFUL * value, "{value} {error}");
    }
}

#[test]
fn gains_of_all_torques_need_something_known() {
    let demo = Demo::new();
    let experiment = asked(&demo.experiment, &[], &["tau1_nm", "tau2_nm"]);
    let error = find(&experiment, &demo.table(1, 1.0))
        .unwrap_err()
        .to_string();
    contains(&error, &["all parameters of joint1 scale"]);
}

#[test]
fn a_gain_is_refused_without_link_encoders_and_with_other_meanings_of_columns() {
    let demo = Demo::new();
    let table = demo.table(1, 1.0);
    let text = sprung_base::demo::EXPERIMENT.replace("link_position_rad ", "joint_torque_nm ");
    let sensors =
        sprung_robot::read("experiment.toml", &text, &[], &mut sprung_robot::no_files).unwrap();
    let error = find(&asked(&sensors, &[], &["tau1_nm"]), &table).unwrap_err();
    assert!(
        error.to_string().contains("link position of each joint"),
        "{error}"
    );
    let mut exchanged = table;
    exchanged.columns.swap(4, 5);
    let error = gain(&demo.experiment, &exchanged, "q2_rad").unwrap_err();
    contains(&error, &["\"q2_rad\" cannot be estimated"]);
}

#[test]
fn two_gains_of_one_joint_are_refused() {
    let demo = Demo::new();
    let experiment = asked(&demo.experiment, &[], &["q1_rad", "phi1_rad"]);
    let error = find(&experiment, &demo.table(1, 1.0))
        .unwrap_err()
        .to_string();
    contains(&error, &["one of the two must be known"]);
}

#[test]
fn an_identification_says_what_it_found() {
    let demo = Demo::new();
    let mut experiment = asked(&demo.experiment, &["tau1_nm"], &["q2_rad"]);
    experiment.identify.estimator = vec![sprung_robot::Estimator::LeastSquares];
    let model = Model::new(&experiment).unwrap();
    let table = times(&times(&demo.table(1, 1.0), 4, -1.0), 1, 1.1);
    let found = identify_log(&experiment, &model, &table.csv());
    let found = found.unwrap().identification;
    assert_eq!(found.log.signs()["tau1_nm"].to_bits(), (-1.0_f64).to_bits());
    let gain = found.log.gain["q2_rad"];
    let off = 1.1 * gain.value - 1.0;
    assert!(off.abs() < 4.0 * 1.1 * gain.standard_error, "{gain:?}");
    for code in ["sign-estimated", "gain-estimated"] {
        let finding = named(&found.findings, code);
        let evidence = finding.evidence.as_ref().unwrap();
        assert_eq!(evidence.file, "log");
    }
    let stiffness = found.results[0].values()["joint1.stiffness"];
    assert!(stiffness > 0.0);
}
