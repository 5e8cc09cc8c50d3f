//! `sprung simulate --expected-errors`: the standard errors of an experiment.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::common::{Case, Ran, f64_of, list_of, sprung, str_of};

/// Simulates a case into its folder `twin`.
fn simulated(case: &Case, more: &[&str]) -> Ran {
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
    let json = simulated(case, &[&["--json"], more].concat())
        .ends(0)
        .json();
    let number = |object: &Value, key: &str| f64_of(&object[key]);
    (list_of(&json["expected_errors"]).iter())
        .map(|error| {
            let name = str_of(&error["name"]).to_owned();
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
        case.identify(&["-q", "--set", "identify.estimator=prediction-error"])
            .ends(0);
        let json = case.json("sprung-out/identification.json");
        for parameter in list_of(&json["results"][0]["parameters"]) {
            let expected = &expected[str_of(&parameter["name"])];
            squares +=
                ((f64_of(&parameter["value"]) - expected.value) / expected.standard_error).powi(2);
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
    simulated(&case, &["--set", still])
        .prints(&["not determined, because the standard error exceeds the value: "]);
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
        simulated(&case, &["--set", set])
            .ends(2)
            .tells(&["the twin measures exactly", missing]);
        assert!(!case.path("twin").exists(), "nothing is written");
    }
}
