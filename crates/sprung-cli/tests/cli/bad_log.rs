//! Messages about a wrong log: exit code 3, line and column, the remedy. The corpus contains single cells and
//! complete files.

use crate::common::{Case, sprung, stderr, value};

const TIME: usize = 0;
const Q1: usize = 1;
const Q2: usize = 2;
const PHI1: usize = 3;
const PHI2: usize = 4;
const TAU1: usize = 5;
const TAU2: usize = 6;

#[test]
fn missing_log() {
    let case = Case::new();
    std::fs::remove_file(case.path("identification.csv")).unwrap();
    case.fails(4, &["cannot read", "identification.csv", "No such file"]);
}

#[test]
fn time_that_runs_back_or_repeats() {
    for (row, value) in [(50, "0.01"), (5000, "4.998")] {
        Case::new()
            .log(|i, cells| {
                if i == row {
                    value.clone_into(&mut cells[TIME]);
                }
            })
            .fails(
                3,
                &[
                    &format!("line {} of", row + 1),
                    "time goes from",
                    "must be in order",
                ],
            );
    }
}

#[test]
fn late_time_stamps() {
    // The samples are even; every third stamp is late by a third of the period.
    let case = Case::new().log(|row, cells| {
        if row > 0 && row % 3 == 0 {
            let time: f64 = cells[TIME].parse().unwrap();
            cells[TIME] = (time + 0.0003).to_string();
        }
    });
    let output = case.identify(&["--json", "--verbose"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["log"]["sampling"], "even");
    assert_eq!(json["log"]["interpolated"], 0);
    assert!(stderr(&output).contains("Samples are even, and stamps are late"));
    assert!(stderr(&output).contains("sampling = \"even\" in [log]"));
}

#[test]
fn gaps_restart_the_filters_and_are_told() {
    let case = Case::new().log(|row, cells| {
        if row == 3000 || (6000..6500).contains(&row) {
            cells.clear();
        }
    });
    let output = case.identify(&["--json", "--verbose"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["log"]["gaps"], 1);
    assert_eq!(json["log"]["dropped"], 1);
    assert!(stderr(&output).contains("has 1 gap, 0.500 s together"));
    assert!(stderr(&output).contains("lacks 1 sample, at most three in a row, first at line 3001"));
    // Without a restart the filters would see a jump of half a second. The limit of 2 % is ten times the error of a
    // log without gap.
    let stiffness = value(&json, "joint1.stiffness");
    assert!((stiffness / 9.358_73 - 1.0).abs() < 0.02, "{stiffness}");
}

#[test]
fn small_jitter_is_tolerated() {
    let case = Case::new().log(|row, cells| {
        if row > 0 && row % 3 == 0 {
            let time: f64 = cells[TIME].parse().unwrap();
            cells[TIME] = (time + 0.00003).to_string();
        }
    });
    let output = case.identify(&["--quiet"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
}

#[test]
fn constant_columns() {
    Case::new().column(PHI2, |_| 0.0131).fails(
        3,
        &[
            "joint2: column \"phi2_rad\" never changes (0.0131 rad in all 10000 samples)",
            "is the motor encoder connected",
        ],
    );
    Case::new()
        .column(TAU1, |_| 0.0)
        .fails(3, &["joint1: column \"tau1_nm\" never changes (0.0000 N·m"]);
}

#[test]
fn one_encoder_in_another_unit_or_direction() {
    Case::new().column(PHI1, f64::to_degrees).fails(
        3,
        &["it holds degrees", "gain = { \"phi1_rad\" = 0.01745 }"],
    );
    Case::new()
        .column(Q1, f64::to_degrees)
        .fails(3, &["\"q1_rad\" looks like degrees", "link_position_deg"]);
    Case::new()
        .column(PHI1, |x| 101.0 * x)
        .fails(3, &["motor side of the gearbox", "motor_position_side"]);
    // An encoder counts in the other direction, so the joint seems to work against itself.
    let case = Case::new().column(PHI2, |x| -x);
    case.fails(
        3,
        &[
            "opposite-signs",
            "\"phi2_rad\" and \"q2_rad\" have opposite directions",
            "sign = { \"phi2_rad\" = -1 }",
        ],
    );
}

#[test]
fn both_encoders_in_degrees() {
    let case = [Q1, Q2, PHI1, PHI2]
        .into_iter()
        .fold(Case::new(), |case, column| {
            case.column(column, f64::to_degrees)
        });
    let (out, message) = {
        let output = case.identify(&[]);
        (output.status.code(), stderr(&output))
    };
    assert_eq!(out, Some(3), "{message}");
    for part in [
        "looks-like-degrees",
        "joint1 and joint2: the positions are degrees, not radians",
        "motor_position_deg = [\"phi1_rad\", \"phi2_rad\"]",
    ] {
        assert!(message.contains(part), "no {part:?} in {message}");
    }
    // With the remedy, the values are those of the log in radians.
    let value = |case: &Case, more: &[&str]| {
        let mut args = vec!["--json"];
        args.extend(more);
        let output = case.identify(&args);
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        json["results"][0]["parameters"][9]["value"]
            .as_f64()
            .unwrap()
    };
    let radians = value(&Case::new(), &[]);
    let degrees = value(
        &case
            .replace("link_position_rad  =", "link_position_deg =")
            .replace("motor_position_rad =", "motor_position_deg ="),
        &[],
    );
    assert!(
        (degrees / radians - 1.0).abs() < 1e-9,
        "{degrees} {radians}"
    );
}

#[test]
fn swapped_motor_and_link_columns() {
    Case::new()
        .replace("[\"q1_rad\", \"q2_rad\"]", "[\"phi1_rad\", \"q2_rad\"]")
        .replace(
            "motor_position_rad = [\"phi1_rad\", \"phi2_rad\"]",
            "motor_position_rad = [\"q1_rad\", \"phi2_rad\"]",
        )
        .fails(
            3,
            &["exchanged-columns", "joint1", "the columns look swapped"],
        );
}

#[test]
fn reversed_torque() {
    let case = Case::new().column(TAU2, |x| -x);
    case.fails(
        3,
        &[
            "reversed-torque",
            "joint2",
            "the sign of the torque is reversed",
            "sign = { \"tau2_nm\" = -1 }",
        ],
    );
    let output = case.identify(&["--set", "log.sign.tau2_nm=-1", "--quiet"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
}

#[test]
fn late_link_channel() {
    // The link position is 150 samples late.
    let mut past = std::collections::VecDeque::new();
    let case = Case::new().log(|row, cells| {
        if row > 0 {
            past.push_back(cells[Q1].clone());
            if past.len() > 151 {
                past.pop_front();
            }
            cells[Q1] = past[0].clone();
        }
    });
    // The deflections are not predicted.
    case.warns(
        1,
        &[
            "delayed-channel",
            "if \"q1_rad\" was recorded 0.149 s late",
            "q1_rad\" = 0.149",
        ],
    );
    let output = case.identify(&["--quiet", "--set", "log.delay_s.q1_rad=estimate"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
}

#[test]
fn too_short_for_the_filter() {
    Case::new()
        .replace("position_cutoff_hz = \"auto\"", "position_cutoff_hz = 10.0")
        .log(|row, cells| {
            if row > 200 {
                cells.clear();
            }
        })
        .fails(
            3,
            &[
                "has 200 samples, at least 303 are needed",
                "position_cutoff_hz = 10",
            ],
        );
}

#[test]
fn joint_that_stands_still() {
    let case = [Q2, PHI2]
        .into_iter()
        .fold(Case::new(), |case, column| case.column(column, |_| 0.25));
    case.warns(
        1,
        &[
            "unexcited-joint",
            "joint2 stands still",
            "not-identifiable",
            "joint2.stiffness",
            "rank",
        ],
    );
}

#[test]
fn motion_that_does_not_tell_parameters_apart() {
    // At a constant velocity the inertia has no effect.
    let case = Case::new().log(|row, cells| {
        if row > 0 {
            let time: f64 = cells[TIME].parse().unwrap();
            for column in [Q1, Q2, PHI1, PHI2] {
                cells[column] = (0.2 * time + if column < PHI1 { -0.01 } else { 0.01 }).to_string();
            }
        }
    });
    case.warns(1, &["not-identifiable", "the log does not determine"]);
}

#[test]
fn numbers_beyond_reason() {
    let case = Case::new()
        .column(TAU1, |x| 1e300 * x)
        .column(Q1, |x| 1e200 * x);
    let output = case.identify(&[]);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(3), "{message}");
    assert!(message.starts_with("error: "), "{message}");
    // If both encoders have the same factor, the check finds no fault and the regression reports the numbers.
    let case = [Q1, PHI1].into_iter().fold(Case::new(), |case, column| {
        case.column(column, |x| 1e200 * x)
    });
    case.fails(
        3,
        &["holds numbers that are not finite; are the units of its columns right?"],
    );
}

#[test]
fn results_of_a_joint_that_stands_still_can_be_validated() {
    // Without motion and torque there are no relative residuals.
    let case = [Q2, PHI2, TAU2]
        .into_iter()
        .fold(Case::new(), |case, column| case.column(column, |_| 0.0));
    let output = case.identify(&["--quiet"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let experiment = case.path("experiment.toml");
    let log = case.path("identification.csv");
    let set = format!(
        "validate=[{{name=\"own\",log={{file=\"{}\"}}}}]",
        log.display()
    );
    let output = sprung(&["validate", experiment.to_str().unwrap(), "--set", &set]);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(
        message.contains("parameters-missing") && message.contains("joint2.stiffness"),
        "{message}"
    );
}

/// The log of the demo has a period of 1 ms.
#[test]
fn a_period_of_the_controller_that_does_not_suit_the_log_is_refused() {
    Case::new()
        .replace(
            "time_s             = \"t_s\"",
            "time_s = \"t_s\"\ntorque = \"held\"\ncontroller_period_s = 0.0007",
        )
        .fails(
            3,
            &[
                "identification.csv",
                "controller_period_s is 0.7000 ms",
                "the period of the log, 1.0000 ms",
                "correct controller_period_s in [log]",
            ],
        );
}
