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

/// Replaces the values of keys, each on a line of its own.
fn with_values(text: &str, values: &[[&str; 2]]) -> String {
    let of = |line: &str| {
        let key = line.split('=').next().unwrap_or_default().trim();
        match values.iter().find(|[of, _]| *of == key) {
            Some([_, value]) => format!("{key} = {value}\n"),
            None => format!("{line}\n"),
        }
    };
    text.lines().map(of).collect()
}

/// A deflection that is late is viscous friction of the motor less that of the link, which the error of the delay must not hide.
#[test]
fn a_late_link_of_a_stiff_joint_leaves_its_friction_open() {
    const LATE_SAMPLES: usize = 3;
    let text = with_values(
        demo::EXPERIMENT,
        &[
            ["link_encoder_counts_per_turn", "[524288, 524288]"],
            ["motor_encoder_counts_per_turn", "[819200, 819200]"],
            ["kp_nm_per_rad", "[200.0, 20.0]"],
        ],
    )
    .replace("stiffness = 9.0", "stiffness = 2500.0")
    .replace("stiffness = 4.0", "stiffness = 1200.0")
    .replace("amplitude_deg = 3.0", "amplitude_deg = 12.0");
    let truth = with_values(
        demo::TRUTH,
        &[
            ["\"joint1.stiffness\"", "3000.0"],
            ["\"joint2.stiffness\"", "1500.0"],
            ["\"joint1.link_viscous\"", "0.3"],
            ["\"joint2.link_viscous\"", "0.05"],
        ],
    );
    let mut experiment = description::read("experiment.toml", &text, &[], &mut no_files).unwrap();
    let model = Model::new(&experiment).unwrap();
    let truth = model.theta(&toml::from_str(&truth).unwrap()).unwrap();
    let mut settings = experiment.simulate.clone().unwrap();
    settings.seed = 3;
    let twin = Twin {
        experiment: experiment.clone(),
        model: model.clone(),
        truth,
    };
    let log = String::from_utf8(twin.log(&settings)).unwrap();
    let mut rows: Vec<Vec<&str>> = log.lines().map(|line| line.split(',').collect()).collect();
    let late = rows[0].iter().position(|name| *name == "q2_rad").unwrap();
    for row in (1 + LATE_SAMPLES..rows.len()).rev() {
        rows[row][late] = rows[row - LATE_SAMPLES][late];
    }
    let lines: Vec<String> = rows.iter().map(|row| row.join(",")).collect();
    experiment.identify.estimator = vec![Estimator::LeastSquares];
    let found = with_sources(&[(lines.join("\n") + "\n").as_bytes()], |sources| {
        let outcome = identify(&experiment, &model, sources, &mut Unheard);
        outcome.unwrap().identification
    });
    let [delay] = &found.unknowns[..] else {
        panic!("{:#?}", found.unknowns);
    };
    assert_eq!(delay.id, "delay q2_rad");
    let away = (delay.value - 1e-3 * LATE_SAMPLES as f64).abs();
    assert!(
        away < FAR * delay.standard_error && away < 1e-4,
        "{delay:?}"
    );
    assert_true(&found.results[0], &twin.truth);
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
