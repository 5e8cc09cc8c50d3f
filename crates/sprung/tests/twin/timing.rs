//! Torques that do not act when they are recorded, and Coulomb friction of unknown sharpness.

use sprung_base::demo;
use sprung_base::progress::Unheard;
use sprung_method::estimate::{EstimateResult, Identification, identify};
use sprung_model::Model;
use sprung_robot::{self as description, Estimator, Experiment, no_files};

use crate::support::{Twin, with_sources};

/// Length of the logs, s.
const DURATION_S: f64 = 8.0;

/// A normal variable exceeds this number of standard errors once in 16 000.
const FAR: f64 = 4.0;

const SHARPNESS: &str = "coulomb_sharpness_s_per_rad = 100.0";

fn experiment(sharpness: &str) -> (Experiment, Model) {
    let text = demo::EXPERIMENT.replace(SHARPNESS, sharpness);
    let mut experiment = description::read("experiment.toml", &text, &[], &mut no_files).unwrap();
    experiment.identify.estimator = vec![Estimator::PredictionError, Estimator::LeastSquares];
    let model = Model::new(&experiment).unwrap();
    (experiment, model)
}

/// Returns the result for every second row of a log, by a description without a sharpness.
fn identified(true_sharpness: &str, keeps: usize) -> (Identification, Vec<f64>) {
    let twin = Twin::new();
    let (truth, model) = experiment(true_sharpness);
    let mut settings = truth.simulate.clone().unwrap();
    settings.duration_s = DURATION_S;
    let twin = Twin {
        experiment: truth,
        model,
        truth: twin.truth,
    };
    let log = String::from_utf8(twin.log(&settings)).unwrap();
    let mut lines = log.lines();
    let header = lines.next().unwrap();
    let kept = lines.step_by(keeps);
    let kept: Vec<&str> = std::iter::once(header).chain(kept).collect();
    let log = kept.join("\n") + "\n";
    let (unknown, model) = experiment("");
    let found = with_sources(&[log.as_bytes()], |sources| {
        identify(&unknown, &model, sources, &mut Unheard).unwrap()
    });
    (found.identification, twin.truth)
}

fn assert_true(result: &EstimateResult, truth: &[f64]) {
    for (parameter, truth) in result.parameters.iter().zip(truth) {
        let away = (parameter.value.unwrap() - truth).abs() / parameter.standard_error.unwrap();
        assert!(
            away < FAR,
            "{} is {away:.1} standard errors away",
            parameter.name
        );
    }
}

fn codes(found: &Identification) -> Vec<&str> {
    (found.findings.iter().map(|finding| finding.code.as_str())).collect()
}

#[test]
fn a_torque_between_the_rows_of_a_log_and_a_sharp_transition_are_found() {
    let (found, truth) = identified("coulomb_sharpness_s_per_rad = 180.0", 2);
    let result = &found.results[0];
    let refined = result.refined().unwrap();
    // A torque of the log acts for the first half of the two milliseconds between its rows.
    let (delay, error) = refined.torques_delay_s.unwrap();
    println!("delay {:.4} ± {:.4} ms", 1e3 * delay, 1e3 * error);
    assert!(
        (delay - 0.5e-3).abs() < FAR * error && error < 1.5e-4,
        "{delay} {error}"
    );
    for sharpness in &refined.sharpnesses {
        println!(
            "{} {:.1} ± {:.1}",
            sharpness.joint, sharpness.sharpness, sharpness.standard_error
        );
        let away = (sharpness.sharpness - 180.0).abs() / sharpness.standard_error;
        assert!(away < FAR, "{} {away}", sharpness.joint);
    }
    // Later commands read the values of least squares with the sharpness that they belong to.
    assert_eq!(found.results[1].coulomb_sharpness.iter().count(), 2);
    assert_true(result, &truth);
    let applied: Vec<&str> = found
        .applied
        .iter()
        .map(|applied| applied.kind.as_str())
        .collect();
    assert_eq!(applied, ["timing", "sharpness"]);
    assert!(!codes(&found).contains(&"laws-missing"));
}

#[test]
fn a_log_that_fits_the_model_has_no_timing_of_its_own() {
    let (found, truth) = identified(SHARPNESS, 1);
    assert_true(&found.results[0], &truth);
    assert_eq!(found.applied, []);
}
