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
const SHARPER: &str = "coulomb_sharpness_s_per_rad = 180.0";

const BOTH: [Estimator; 2] = [Estimator::PredictionError, Estimator::LeastSquares];

fn experiment(sharpness: &str) -> (Experiment, Model) {
    let text = demo::EXPERIMENT.replace(SHARPNESS, sharpness);
    let experiment = description::read("experiment.toml", &text, &[], &mut no_files).unwrap();
    let model = Model::new(&experiment).unwrap();
    (experiment, model)
}

/// Returns every n-th row of a log of the demo's arm with this sharpness, and the true parameters.
fn log(true_sharpness: &str, keeps: usize) -> (String, Vec<f64>) {
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
    let kept: Vec<&str> = std::iter::once(header)
        .chain(lines.step_by(keeps))
        .collect();
    (kept.join("\n") + "\n", twin.truth)
}

/// Returns the identification of a log by a description with this line for the sharpness.
fn identified(log: &str, sharpness: &str, estimators: &[Estimator]) -> Identification {
    let (mut experiment, model) = experiment(sharpness);
    experiment.identify.estimator = estimators.to_vec();
    with_sources(&[log.as_bytes()], |sources| {
        identify(&experiment, &model, sources, &mut Unheard)
            .unwrap()
            .identification
    })
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
    let (log, truth) = log(SHARPER, 2);
    let found = identified(&log, "", &BOTH);
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
    let (log, truth) = log(SHARPNESS, 1);
    let found = identified(&log, "", &BOTH);
    assert_true(&found.results[0], &truth);
    assert_eq!(found.applied, []);
}

/// The bias of Coulomb friction by a sharpness that the description does not give is the change of the friction, not of the
/// coefficient of one of two columns that share it.
#[test]
fn the_bias_by_an_unknown_sharpness_is_as_large_as_its_effect() {
    let (log, _) = log(SHARPER, 1);
    let least_squares = [Estimator::LeastSquares];
    let open = identified(&log, "", &least_squares);
    let declared = identified(&log, SHARPER, &least_squares);
    let (open, declared) = (&open.results[0].parameters, &declared.results[0].parameters);
    let pairs = open.iter().zip(declared);
    let coulomb: Vec<_> = pairs
        .filter(|(open, _)| open.name.ends_with("coulomb"))
        .collect();
    assert_eq!(coulomb.len(), 4);
    for (open, declared) in coulomb {
        let effect = (open.value.unwrap() - declared.value.unwrap()).abs();
        let [with, without] = [open, declared].map(|of| of.error_parts.unwrap());
        println!(
            "{}: effect {effect:.2e}, bias {:.2e}, with the sharpness {:.2e}, sampling {:.2e}",
            open.name, with.bias, without.bias, with.sampling
        );
        // The two columns have 100 and 200 s/rad: they are not exactly friction of 180 s/rad.
        let limit = (3.0 * effect)
            .hypot(without.bias)
            .hypot(FAR * with.sampling);
        assert!(with.bias < limit, "{}: {} {limit}", open.name, with.bias);
    }
}
