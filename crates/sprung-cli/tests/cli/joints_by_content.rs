//! `sprung new --log` finds the joints of columns whose names do not contain them.

use crate::common::contains;
use crate::renamed_log::{begun, column, is_identified, named, plain, recorded};

/// Returns the experiment of a log of the twin with other names: columns of q1, q2, phi1, phi2, tau1, tau2.
fn of(names: [&str; 6], places: [usize; 6]) -> String {
    let (desk, log) = recorded();
    let mut all = vec![column("t", 0, 1.0)];
    all.extend(
        names
            .into_iter()
            .zip(places)
            .map(|(name, place)| column(name, place, 1.0)),
    );
    desk.log(&named(&log, &all));
    let text = begun(&desk, "log.csv");
    is_identified(&desk);
    text
}

/// Checks the lines of the columns.
fn has(text: &str, lines: &[&str]) {
    for line in lines {
        assert!(text.contains(line), "no {line} in {text}");
    }
}

#[test]
fn names_share_letters() {
    let text = of(
        [
            "link_pos_b",
            "link_pos_a",
            "motor_pos_b",
            "motor_pos_a",
            "tau_b",
            "tau_a",
        ],
        [2, 1, 4, 3, 6, 5],
    );
    has(
        &text,
        &[
            "link_position_rad = [\"link_pos_a\", \"link_pos_b\"]",
            "motor_position_rad = [\"motor_pos_a\", \"motor_pos_b\"]",
            "motor_torque_nm = [\"tau_a\", \"tau_b\"]",
            "by the letters of the names",
            "by the words that the names share",
        ],
    );
}

#[test]
fn slopes_and_torques_tell_the_joints() {
    // The motors have numbers; the names of links and torques have no meaning.
    let text = of(
        [
            "encoder lower",
            "encoder upper",
            "motor_pos_1",
            "motor_pos_2",
            "torque left",
            "torque right",
        ],
        [2, 1, 3, 4, 6, 5],
    );
    has(
        &text,
        &[
            "link_position_rad = [\"encoder upper\", \"encoder lower\"]",
            "motor_position_rad = [\"motor_pos_1\", \"motor_pos_2\"]",
            "motor_torque_nm = [\"torque right\", \"torque left\"]",
            "by the slope between the positions",
            "by the torque that the motion of each joint explains",
        ],
    );
}

#[test]
fn words_that_mean_nothing_give_no_order() {
    let (desk, log) = recorded();
    let names = plain("t=0, pos red=3, pos blue=4, tau red=5, tau blue=6");
    desk.log(&named(&log, &names));
    desk.fails(
        &["new", "exp", "--urdf", "arm.urdf", "--log", "log.csv"],
        2,
        &["no column of log.csv belongs to a joint"],
    );
}

#[test]
fn units_of_headers_that_the_log_contradicts_are_named() {
    let (desk, log) = recorded();
    let degrees = 180.0 / std::f64::consts::PI;
    #[rustfmt::skip]
    let cases = [
        // Header, time, factor of the positions; what the file says.
        (("t_s", "rad"), 1.0, degrees, "link_position_deg", "the positions are degrees"),
        (("t_s", "deg"), 1.0, 1.0, "link_position_rad", "the positions are radians, not degrees"),
        (("t_ms", "rad"), 1.0, 1.0, "time_s = \"t_ms\"", "\"t_ms\", as declared, gives 500000 samples per second"),
    ];
    for (k, ((time, unit), seconds, factor, line, said)) in cases.into_iter().enumerate() {
        let names = ["q1", "q2", "phi1", "phi2"].map(|name| format!("{name}_{unit}"));
        let mut all = vec![
            column(time, 0, seconds),
            column("tau1_Nm", 5, 1.0),
            column("tau2_Nm", 6, 1.0),
        ];
        all.extend((names.iter().zip(1..)).map(|(name, place)| column(name, place, factor)));
        desk.log(&named(&log, &all));
        let folder = format!("units-{k}");
        let text = desk.succeeds(&["new", &folder, "--urdf", "arm.urdf", "--log", "log.csv"]);
        println!("{text}");
        for words in ["corrected: ", line, said] {
            assert!(text.contains(words), "no {words} in {text}");
        }
        contains(
            &desk.read(&format!("{folder}/experiment.toml")),
            &[&format!("\n{line}")],
        );
    }
}

#[test]
fn names_that_differ_in_case_are_those_of_the_joints() {
    let text = of(
        [
            "Shoulder.q",
            "ELBOW.q",
            "SHOULDER.phi",
            "Elbow.phi",
            "shoulder.tau",
            "elbow.tau",
        ],
        [1, 2, 3, 4, 5, 6],
    );
    has(
        &text,
        &[
            "link_position_rad = [\"Shoulder.q\", \"ELBOW.q\"]",
            "motor_position_rad = [\"SHOULDER.phi\", \"Elbow.phi\"]",
            "motor_torque_nm = [\"shoulder.tau\", \"elbow.tau\"]",
        ],
    );
}
