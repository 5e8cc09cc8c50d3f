//! The default estimator: its output, and the cases in which the linear values stay.

use serde_json::Value;

use crate::arm;
use crate::common::{Case, assert_true, contains, demo, f64_of, finding, list_of};

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
    output.ends(0);
    let text = &output.out;
    contains(text, &["prediction-error: good, 15 of 15 parameters"]);
    contains(
        text,
        &["disturbances relative to the motor torque: joint1.link "],
    );
    // Without a terminal there is no progress bar.
    assert!(!output.err.contains("filter run"), "{}", output.err);
    let json = case.json("sprung-out/identification.json");
    let [result] = list_of(&json["results"]) else {
        panic!("one result")
    };
    assert_eq!(result["estimator"], "prediction-error");
    let refinement = &result["refinement"];
    assert_eq!(refinement["used"], true);
    assert_eq!(refinement["converged"], true);
    assert_eq!(list_of(&refinement["disturbances"]).len(), 4);
    assert_eq!(list_of(&refinement["delays"]).len(), 6);
    assert_true(&json, &[("joint1.stiffness", 9.358_73)]);
    contains(
        &case.read("sprung-out/report.html"),
        &[
            "id=\"refinement\"",
            "class=\"bars\"",
            "Good: on a new experiment of this kind",
        ],
    );
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
    for run in list_of(&json["runs"]) {
        let [refined, linear] = [0, 1].map(|i| &run["sets"][i]);
        assert_eq!(refined["parameters"], "prediction-error");
        assert_eq!(linear["parameters"], "least-squares");
        for signal in ["q_rad", "phi_rad", "tau_nm"] {
            for joint in ["joint1", "joint2"] {
                let error = |set: &Value| f64_of(&set["e_rms"][signal][joint]);
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
    contains(text, &[why]);
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
    let short = Case::new().first_rows(4000);
    let case = short.columns(&[1, 2, 3, 4], f64::to_degrees);
    let go_on = ["--set", "identify.on_check_error=go-on"];
    let (_, json) = case.results(&[&BOTH[..], &go_on].concat());
    stands_back(&json, "the log itself is wrong (looks-like-degrees)");
    // A validation takes the first result first.
    let json = case
        .run(
            "validate",
            &["--json", "--set", "validate=[{name=\"direct\"}]"],
        )
        .json();
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
    let rungs = list_of(&refinement["rungs"]);
    assert_eq!(rungs[0]["name"], "free");
    assert_eq!(rungs[0]["used"], false, "{rungs:#?}");
    // A rung is used only if it predicts about as well as least squares; the result contains its
    // values in any case.
    for rung in rungs.iter().filter(|rung| rung["used"] == true) {
        let held = |key: &str| f64_of(&rung["held_out_residual"][key]);
        assert!(held("refined") <= 1.06 * held("linear"), "{rung:#}");
    }
    assert!(list_of(&refinement["values"]).len() == 15);
}
