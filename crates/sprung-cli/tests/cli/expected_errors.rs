//! `sprung simulate --expected-errors`: the standard errors of an experiment.

use std::collections::BTreeMap;
use std::process::Output;

use serde_json::Value;

use crate::common::{Case, sprung, stderr, stdout};

/// Simulates a case into its folder `twin`.
fn simulated(case: &Case, more: &[&str]) -> Output {
    let (experiment, out) = (case.path("experiment.toml"), case.path("twin"));
    let mut args = vec![
        "simulate",
        "--expected-errors",
        experiment.to_str().unwrap(),
    ];
    args.extend(["--out", out.to_str().unwrap()]);
    args.extend(more);
    sprung(&args)
}

/// The expected error of a parameter.
#[derive(Debug)]
struct Expected {
    value: f64,
    standard_error: f64,
    is_determined: bool,
}

/// Returns the expected errors of a case.
fn expected(case: &Case, more: &[&str]) -> BTreeMap<String, Expected> {
    let output = simulated(case, &[&["--json"], more].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    let json: Value = serde_json::from_str(&stdout(&output)).unwrap();
    let number = |object: &Value, key: &str| object[key].as_f64().unwrap();
    (json["expected_errors"].as_array().unwrap().iter())
        .map(|error| {
            let name = error["name"].as_str().unwrap().to_owned();
            let expected = Expected {
                value: number(error, "value"),
                standard_error: number(error, "standard_error"),
                is_determined: error["is_determined"].as_bool().unwrap(),
            };
            (name, expected)
        })
        .collect()
}

/// Returns the geometric mean of the ratios of standard errors.
fn ratio(of: &BTreeMap<String, Expected>, over: &BTreeMap<String, Expected>) -> f64 {
    let logs: f64 = of
        .iter()
        .map(|(name, estimate)| (estimate.standard_error / over[name].standard_error).ln())
        .sum();
    (logs / of.len() as f64).exp()
}

#[test]
fn a_log_of_four_times_the_length_halves_the_errors() {
    let case = Case::new();
    let short = expected(&case, &["--set", "simulate.duration_s=10"]);
    let long = expected(&case, &["--set", "simulate.duration_s=40"]);
    assert_eq!(short.len(), 15);
    assert!(
        short.values().all(|estimate| estimate.is_determined),
        "{short:?}"
    );
    // Information adds up over time.
    let measured = ratio(&short, &long);
    assert!((measured - 2.0).abs() < 0.2, "{measured}");
}

#[test]
fn observed_errors_are_those_that_were_expected() {
    let case = Case::new();
    let expected = expected(&case, &[]);
    let (mut squares, mut count) = (0.0, 0.0);
    for seed in 1..=4 {
        case.record(
            "identification.csv",
            &["--set", &format!("simulate.seed={seed}")],
        );
        let output = case.identify(&["-q", "--set", "identify.estimator=prediction-error"]);
        assert!(output.status.success(), "{}", stderr(&output));
        let text = std::fs::read_to_string(case.path("sprung-out/identification.json")).unwrap();
        let json: Value = serde_json::from_str(&text).unwrap();
        for parameter in json["results"][0]["parameters"].as_array().unwrap() {
            let expected = &expected[parameter["name"].as_str().unwrap()];
            squares += ((parameter["value"].as_f64().unwrap() - expected.value)
                / expected.standard_error)
                .powi(2);
            count += 1.0;
        }
    }
    let ratio = f64::sqrt(squares / count);
    // 60 values of about 25 independent ones: a ratio of 1 within 0.14 (one standard deviation).
    assert!((0.6..1.5).contains(&ratio), "{ratio}");
}

#[test]
fn a_robot_that_stands_still_has_parameters_that_no_log_determines() {
    let case = Case::new();
    let still = "controller.reference.sines=[{ joint = \"joint1\", amplitude_deg = 0.0, frequency_hz = 0.7 }]";
    let found = expected(&case, &["--set", still]);
    let open: Vec<&str> = (found.iter().filter(|entry| !entry.1.is_determined))
        .map(|entry| &**entry.0)
        .collect();
    for name in [
        "link1.inertia_total",
        "joint1.stiffness",
        "joint2.motor_viscous",
    ] {
        assert!(open.contains(&name), "{open:?}");
    }
    let output = simulated(&case, &["--set", still]);
    let text = stdout(&output);
    assert!(
        text.contains("not determined, because the standard error exceeds the value: "),
        "{text}"
    );
}

#[test]
fn a_twin_without_errors_has_no_expected_errors() {
    let case = Case::new();
    for (set, missing) in [
        ("simulate.torque_noise_nm=[]", "torque_noise_nm"),
        (
            "simulate.link_encoder_counts_per_turn=[]",
            "link_encoder_counts_per_turn",
        ),
    ] {
        let output = simulated(&case, &["--set", set]);
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        let text = stderr(&output);
        assert!(
            text.contains("the twin measures exactly") && text.contains(missing),
            "{text}"
        );
        assert!(!case.path("twin").exists(), "nothing is written");
    }
}
