//! The estimator that simulates the closed loop.

use crate::common::{Case, assert_true, finding, stderr, stdout, value};

const SHORT: [&str; 2] = ["--set", "simulate.duration_s=3.0"];
const OUTPUT_ERROR: [&str; 2] = ["--set", "identify.estimator=output-error"];

/// The demo's experiment with a short log.
fn short() -> Case {
    let case = Case::new();
    case.record("identification.csv", &SHORT);
    case
}

#[test]
fn the_demo_is_identified_within_its_errors() {
    let case = short();
    let (code, json) = case.results(&OUTPUT_ERROR);
    assert_eq!(code, 0);
    let result = &json["results"][0];
    assert_eq!(result["estimator"], "output-error");
    let truth = [
        ("joint1.stiffness", 9.358_73),
        ("link1.inertia_total", 0.207_184),
    ];
    assert_true(&json, &truth);
    let fit = &result["simulation"];
    assert_eq!(fit["samples"], 3000);
    let cost = fit["cost_per_sample"].as_f64().unwrap();
    // A mean of squares: 3000 samples of four positions.
    let scatter = (2.0 / 12_000_f64).sqrt();
    assert!((cost - 1.0).abs() < 4.0 * scatter, "{cost}");
    assert_eq!(fit["offset_rad"].as_object().unwrap().len(), 4);
    let note = finding(&json, "output-error-samples").unwrap();
    assert!(note.contains("first 3000 samples"), "{note}");
    assert!(finding(&json, "controller-taken-as-exact").is_some());
}

#[test]
fn threads_change_no_bit() {
    let case = short();
    let run = |threads: &str| {
        let mut args = vec!["--threads", threads];
        args.extend(OUTPUT_ERROR);
        case.results(&args).1["results"][0]["parameters"].clone()
    };
    assert_eq!(run("1"), run("3"));
}

#[test]
fn it_needs_a_controller_that_ran() {
    let experiment = |from: &str, to: &str| Case::new().replace(from, to);
    let case = experiment("[\"least-squares\", \"lsff\"]", "\"output-error\"");
    let text = std::fs::read_to_string(case.path("experiment.toml")).unwrap();
    let (before, rest) = text.split_once("[controller]").unwrap();
    let (_, after) = rest.split_once("[[validate]]").unwrap();
    let without = format!("{before}[[validate]]{after}");
    std::fs::write(case.path("experiment.toml"), without).unwrap();
    case.fails(2, &["output-error", "no [controller]", "least-squares"]);

    let case = experiment("[\"least-squares\", \"lsff\"]", "\"output-error\"")
        .replace("kind = \"pd\"", "kind = \"state-feedback\"\nfeedforward = \"identified\"\ngain = [[50.0, 0.0, 300.0, 0.0, 5.0, 0.0, 0.1, 0.0], [0.0, 15.0, 0.0, 40.0, 0.0, 0.1, 0.0, 0.1]]")
        .replace("kp_nm_per_rad   = [50.0, 5.0]\nkd_nms_per_rad  = [0.05, 0.01]\n", "");
    case.fails(2, &["output-error", "feedforward = \"nominal\""]);
}

#[test]
fn another_controller_is_serious() {
    let case = short().replace("[50.0, 5.0]", "[50.0, 2.5]");
    let output = case.identify(&OUTPUT_ERROR);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(
        message.contains("controller-does-not-match): joint2: "),
        "{message}"
    );
    assert!(stdout(&output).contains("output-error: unusable"));
}

#[test]
fn a_torque_that_is_logged_late_is_said() {
    let case = short();
    let mut before = String::new();
    let case = case.log(|row, cells| {
        let torque = cells[5].clone();
        if row > 1 {
            cells[5].clone_from(&before);
        }
        before = torque;
    });
    let (_, json) = case.results(&OUTPUT_ERROR);
    let text = finding(&json, "controller-torque-late").unwrap();
    assert!(
        text.starts_with("joint1: ") && text.contains("1 sample(s) later"),
        "{text}"
    );
}

#[test]
fn a_gap_ends_what_is_simulated() {
    let case = short().log(|row, cells| {
        if (1500..1600).contains(&row) {
            cells.clear();
        }
    });
    let (_, json) = case.results(&OUTPUT_ERROR);
    let text = finding(&json, "output-error-samples").unwrap();
    assert!(
        text.contains("first 1499 samples") && text.contains("first gap"),
        "{text}"
    );
}

#[test]
fn where_it_cannot_begin_the_linear_values_stand() {
    // The rotor inertia is a millionth of the true value, so friction stops the rotor within a nanosecond.
    let case = short().replace(
        "[robot.nominal]",
        "[robot.fixed]\n\"joint1.rotor_inertia\" = 2e-7\n\n[robot.nominal]",
    );
    let (code, json) = case.results(&OUTPUT_ERROR);
    assert_eq!(code, 1);
    let text = finding(&json, "output-error-failed").unwrap();
    assert!(
        text.contains("runs away") && text.contains("those of least squares"),
        "{text}"
    );
    let (_, linear) = case.results(&["--set", "identify.estimator=least-squares"]);
    let name = "joint1.stiffness";
    assert_eq!(value(&json, name).to_bits(), value(&linear, name).to_bits());
}
