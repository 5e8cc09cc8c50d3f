//! Messages about a wrong log: exit code 3, line and column, the remedy. The corpus contains single cells and
//! complete files.

use crate::common::{Case, assert_true, contains, f64_of, messages, value};

const TIME: usize = 0;
const Q1: usize = 1;
const Q2: usize = 2;
const PHI1: usize = 3;
const PHI2: usize = 4;
const TAU1: usize = 5;
const TAU2: usize = 6;

const MOTORS_AND_LINKS: [usize; 4] = [Q1, Q2, PHI1, PHI2];

/// A log with a time at one row that does not follow the time before it.
fn time_at(row: usize, time: &str) -> Case {
    Case::new().cell(row, TIME, time)
}

/// The demo's log with all positions in degrees.
fn in_degrees() -> Case {
    Case::new().columns(&MOTORS_AND_LINKS, f64::to_degrees)
}

/// Logs that are refused, by their names.
fn wrong_logs() -> Vec<(&'static str, Case)> {
    let short = (Case::new())
        .replace("position_cutoff_hz = \"auto\"", "position_cutoff_hz = 10.0")
        .first_rows(200);
    let swapped = (Case::new())
        .replace("[\"q1_rad\", \"q2_rad\"]", "[\"phi1_rad\", \"q2_rad\"]")
        .replace(
            "motor_position_rad = [\"phi1_rad\", \"phi2_rad\"]",
            "motor_position_rad = [\"q1_rad\", \"phi2_rad\"]",
        );
    // The log has a period of 1 ms.
    let held = Case::new().replace(
        "time_s             = \"t_s\"",
        "time_s = \"t_s\"\ntorque = \"held\"\ncontroller_period_s = 0.0007",
    );
    // If both encoders have the same factor, the check sees nothing and the regression reports the numbers.
    let huge = Case::new().columns(&[Q1, PHI1], |x| 1e200 * x);
    let column = |column: usize, change: fn(f64) -> f64| Case::new().column(column, change);
    vec![
        ("a time before the last one", time_at(50, "0.01")),
        ("a time that repeats", time_at(5000, "4.998")),
        ("a motor that never moves", column(PHI2, |_| 0.0131)),
        ("a torque of zero", column(TAU1, |_| 0.0)),
        ("a constant of 1e308", column(PHI2, |_| 1e308)),
        ("a motor in degrees", column(PHI1, f64::to_degrees)),
        ("a link in degrees", column(Q1, f64::to_degrees)),
        ("all positions in degrees", in_degrees()),
        ("a motor before its gear", column(PHI1, |x| 101.0 * x)),
        // The joint seems to work against itself.
        ("a motor that counts back", column(PHI2, |x| -x)),
        ("a reversed torque", column(TAU2, |x| -x)),
        ("motor and link exchanged", swapped),
        ("too short for the filter", short),
        ("a period that does not suit the log", held),
        ("numbers that overflow", huge),
    ]
}

#[test]
fn wrong_logs_are_named_with_column_and_remedy() {
    let mut messages = messages("wrong_logs_are_named_with_column_and_remedy");
    for (name, case) in wrong_logs() {
        messages.note(name, &case.refused(3, &[]));
    }
    let missing = Case::new();
    missing.remove("identification.csv");
    messages.note("no log", &missing.refused(4, &[]));
    messages.compare();
}

#[test]
fn numbers_beyond_reason_are_an_error() {
    let case = (Case::new().column(TAU1, |x| 1e300 * x)).column(Q1, |x| 1e200 * x);
    let message = case.identify(&[]).err;
    assert!(message.starts_with("error: "), "{message}");
}

#[test]
fn with_the_remedies_the_logs_are_right() {
    let reversed = Case::new().column(TAU2, |x| -x);
    reversed
        .identify(&["--set", "log.sign.tau2_nm=-1", "--quiet"])
        .ends(0);
    let value = |case: &Case| {
        let (_, json) = case.results(&[]);
        value(&json, "joint1.stiffness")
    };
    let degrees = in_degrees()
        .replace("link_position_rad  =", "link_position_deg =")
        .replace("motor_position_rad =", "motor_position_deg =");
    let (radians, degrees) = (value(&Case::new()), value(&degrees));
    // Rounding times the condition number.
    assert!(
        (degrees / radians - 1.0).abs() < 1e-9,
        "{degrees} {radians}"
    );
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
    output.ends(0);
    let json = output.json();
    assert_eq!(json["log"]["sampling"], "even");
    assert_eq!(json["log"]["interpolated"], 0);
    output.tells(&[
        "Samples are even, and stamps are late",
        "sampling = \"even\" in [log]",
    ]);
}

#[test]
fn gaps_restart_the_filters_and_are_told() {
    let case = Case::new().log(|row, cells| {
        if row == 3000 || (6000..6500).contains(&row) {
            cells.clear();
        }
    });
    let output = case.identify(&["--json", "--verbose"]);
    output.ends(0);
    let json = output.json();
    assert_eq!(json["log"]["gaps"], 1);
    assert_eq!(json["log"]["dropped"], 1);
    output.tells(&[
        "has 1 gap, 0.500 s together",
        "lacks 1 sample, at most three in a row, first at line 3001",
    ]);
    // Without a restart the filters would see a jump of half a second.
    assert_true(&json, &[("joint1.stiffness", 9.358_73)]);
}

#[test]
fn small_jitter_is_tolerated() {
    let case = Case::new().log(|row, cells| {
        if row > 0 && row % 3 == 0 {
            let time: f64 = cells[TIME].parse().unwrap();
            cells[TIME] = (time + 0.00003).to_string();
        }
    });
    case.identify(&["--quiet"]).ends(0);
}

#[test]
fn late_link_channel() {
    // The link position is 150 samples late.
    let case = Case::new().late(Q1, 150);
    // The delay is used, so a note says it.
    let output = case.identify(&["--json", "--verbose"]);
    output.ends(0);
    let json = output.json();
    assert_eq!(json["unknowns"][0]["id"], "delay q1_rad");
    assert_eq!(json["unknowns"][0]["status"], "applied");
    let delay = f64_of(&json["unknowns"][0]["value"]);
    assert!((delay - 0.149).abs() < 1e-3, "{delay}");
    let message = &output.err;
    contains(
        message,
        &[
            "delayed-channel",
            "\"q1_rad\" was recorded 14",
            "q1_rad\" = 0.14",
        ],
    );
    case.identify(&["--quiet", "--set", "log.delay_s.q1_rad=estimate"])
        .ends(0);
}

#[test]
fn joint_that_stands_still() {
    let case = Case::new().columns(&[Q2, PHI2], |_| 0.25);
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
fn results_of_a_joint_that_stands_still_can_be_validated() {
    // Without motion and torque there are no relative residuals.
    let case = Case::new().columns(&[Q2, PHI2, TAU2], |_| 0.0);
    case.identify(&["--quiet"]).ends(1);
    let log = case.path("identification.csv");
    let set = format!(
        "validate=[{{name=\"own\",log={{file=\"{}\"}}}}]",
        log.display()
    );
    case.run("validate", &["--set", &set])
        .ends(1)
        .tells(&["parameters-missing", "joint2.stiffness"]);
}
