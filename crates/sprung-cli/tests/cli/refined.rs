//! The default estimator: its output, and the cases in which the linear values stay.

use serde_json::Value;

use crate::arm;
use crate::common::{Case, assert_true, demo, finding, sprung, stderr, stdout};

/// Column of the first link's position.
const Q1: usize = 1;

/// Removes the choice of the estimator.
fn without_choice(case: Case) -> Case {
    case.replace("estimator = [\"least-squares\", \"lsff\"]\n", "")
}

#[test]
fn the_default_is_the_refinement() {
    let case = without_choice(Case::new());
    let output = case.identify(&[]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = stdout(&output);
    assert!(
        text.contains("prediction-error: good, 15 of 15 parameters"),
        "{text}"
    );
    assert!(
        text.contains("disturbances relative to the motor torque: joint1.link "),
        "{text}"
    );
    // Without a terminal there is no progress bar.
    assert!(
        !stderr(&output).contains("filter run"),
        "{}",
        stderr(&output)
    );
    let file = std::fs::read(case.path("sprung-out/identification.json")).unwrap();
    let json: Value = serde_json::from_slice(&file).unwrap();
    let [result] = &json["results"].as_array().unwrap()[..] else {
        panic!("one result")
    };
    assert_eq!(result["estimator"], "prediction-error");
    let refinement = &result["refinement"];
    assert_eq!(refinement["used"], true);
    assert_eq!(refinement["converged"], true);
    assert_eq!(refinement["disturbances"].as_array().unwrap().len(), 4);
    assert_eq!(refinement["delays"].as_array().unwrap().len(), 6);
    assert_true(&json, &[("joint1.stiffness", 9.358_73)]);
    let report = std::fs::read_to_string(case.path("sprung-out/report.html")).unwrap();
    for text in [
        "id=\"refinement\"",
        "class=\"bars\"",
        "Good: on a new experiment of this kind",
    ] {
        assert!(report.contains(text), "no {text}");
    }
}

#[test]
fn an_arm_with_gravity_and_a_rigid_joint_is_refined() {
    let (_, linear) = arm::recorded().results(&[]);
    let case = arm::recorded().replace("estimator = \"least-squares\"\n", "");
    let (_, json) = case.results(&[]);
    assert_eq!(json["results"][0]["refinement"]["used"], true, "{json:#}");
    for json in [&linear, &json] {
        let truth = [
            ("shoulder.stiffness", 400.0),
            ("shoulder.rotor_inertia", 0.3),
        ];
        assert_true(json, &truth);
    }
}

#[test]
fn the_demo_validates_the_refinement_first_and_it_predicts_better() {
    let file = std::fs::read(demo().join("sprung-out/validation.json")).unwrap();
    let json: Value = serde_json::from_slice(&file).unwrap();
    for run in json["runs"].as_array().unwrap() {
        let [refined, linear] = [0, 1].map(|i| &run["sets"][i]);
        assert_eq!(refined["parameters"], "prediction-error");
        assert_eq!(linear["parameters"], "least-squares");
        for signal in ["q_rad", "phi_rad", "tau_nm"] {
            for joint in ["joint1", "joint2"] {
                let error = |set: &Value| set["e_rms"][signal][joint].as_f64().unwrap();
                assert!(
                    error(refined) < error(linear),
                    "{signal} of {joint}: {run:#}"
                );
            }
        }
    }
}

/// Checks that the first result contains the values of the second and a finding with the reason.
fn stands_back(json: &Value, why: &str) {
    let [first, second] = [0, 1].map(|i| &json["results"][i]);
    assert_eq!(first["estimator"], "prediction-error");
    assert_eq!(second["estimator"], "least-squares");
    let text = finding(json, "refinement-failed").unwrap_or_else(|| panic!("{first:#}"));
    assert!(text.contains(why), "{text}");
    assert_ne!(first["verdict"], "good");
    for key in ["value", "ci95"] {
        for i in 0..15 {
            assert_eq!(first["parameters"][i][key], second["parameters"][i][key]);
        }
    }
    assert_ne!(first["refinement"]["used"], true);
}

const BOTH: [&str; 2] = [
    "--set",
    "identify.estimator=[\"prediction-error\",\"least-squares\"]",
];

#[test]
fn the_linear_values_stand_where_the_log_is_wrong() {
    let short = Case::new().log(|row, cells| {
        if row > 4000 {
            cells.clear();
        }
    });
    let case = [1, 2, 3, 4]
        .into_iter()
        .fold(short, |case, column| case.column(column, f64::to_degrees));
    let go_on = ["--set", "identify.on_check_error=go-on"];
    let (_, json) = case.results(&[&BOTH[..], &go_on].concat());
    stands_back(&json, "the log itself is wrong (looks-like-degrees)");
    // A validation takes the first result first.
    let output = sprung(&[
        "validate",
        case.path("experiment.toml").to_str().unwrap(),
        "--json",
        "--set",
        "validate=[{name=\"direct\"}]",
    ]);
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["runs"][0]["sets"][0]["parameters"], "prediction-error");
}

#[test]
fn a_model_that_lacks_something_is_doubted_on_every_rung() {
    // No disturbance explains a link position whose lateness varies between 0 and 0.2 s; no constant delay mends it.
    let mut past: Vec<String> = Vec::new();
    let case = Case::new().log(|row, cells| {
        if row > 0 {
            past.push(cells[Q1].clone());
            let late = 100.0 * (1.0 - (row as f64 / 160.0).cos());
            cells[Q1].clone_from(&past[past.len().saturating_sub(1 + late as usize)]);
        }
    });
    let (_, json) = case.results(&BOTH);
    let first = &json["results"][0];
    assert_ne!(first["verdict"], "good");
    assert!(finding(&json, "not-predicted").is_some(), "{first:#}");
    let refinement = &first["refinement"];
    let rungs = refinement["rungs"].as_array().unwrap();
    assert_eq!(rungs[0]["name"], "free");
    assert_eq!(rungs[0]["used"], false, "{rungs:#?}");
    // A rung is used only if it predicts about as well as least squares; the result contains its
    // values in any case.
    for rung in rungs.iter().filter(|rung| rung["used"] == true) {
        let held = |key: &str| rung["held_out_residual"][key].as_f64().unwrap();
        assert!(held("refined") <= 1.06 * held("linear"), "{rung:#}");
    }
    assert!(refinement["values"].as_array().unwrap().len() == 15);
}
