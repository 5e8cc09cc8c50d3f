//! Logs with joint torques and without motor torques.

use std::fmt::Write as _;

use crate::common::{Case, f64_of, finding, has_lines, is_known, list_of};
use crate::new::Desk;

const INERTIA: f64 = 1.5;
const WEIGHT: f64 = 12.0;
const VISCOUS: f64 = 0.3;
const STIFFNESS: f64 = 1400.0;

/// The log of an elastic pendulum: link, motor, joint torque, with the names of a Franka robot.
fn log(pace: f64) -> String {
    let mut text = "time,q[0],theta[0],tau_J[0]\n".to_owned();
    for k in 0..8000 {
        let t = 0.002 * f64::from(k);
        let (mut q, mut v, mut a) = (0.0, 0.0, 0.0);
        for (size, w) in [(0.6, 2.5), (0.3, 5.8), (0.08, 17.6)] {
            let w = w * pace;
            q += size * (w * t).sin();
            v += size * w * (w * t).cos();
            a -= size * w * w * (w * t).sin();
        }
        let noise = |of: f64| ((of * f64::from(k)).sin() * 43_758.545_3).fract();
        let torque = INERTIA * a + WEIGHT * q.cos() + VISCOUS * v;
        let motor = q + torque / STIFFNESS;
        writeln!(
            text,
            "{t},{},{},{}",
            q + 3e-6 * noise(12.9898),
            motor + 3e-6 * noise(78.233),
            torque + 0.03 * noise(39.425)
        )
        .unwrap();
    }
    text
}

#[test]
fn links_and_springs_are_identified_without_motor_torques() {
    let desk = Desk::new();
    desk.write("first.csv", log(1.0));
    desk.write("second.csv", log(0.8));
    desk.run(&["new", "exp", "--log", "first.csv"]).ends(0);
    let text = desk.read("exp/experiment.toml");
    has_lines(
        &text,
        &[
            "link_position_rad = [\"q[0]\"]",
            "motor_position_rad = [\"theta[0]\"]",
            "joint_torque_nm = [\"tau_J[0]\"]",
        ],
    );
    assert!(!text.contains("motor_torque_nm = \"FILL IN\""), "{text}");
    let text = text
        .replace("dh_modified = \"FILL IN\"", "dh_modified = [{}]")
        .replace("[0.0, 0.0, -9.81]", "[0.0, -9.81, 0.0]")
        .replace(
            "name = \"same log\"",
            "name = \"second\"\nlog = { file = \"../second.csv\" }",
        );
    desk.write("exp/experiment.toml", &text);
    let json = desk.run(&["identify", "exp", "--json"]).json();
    assert_eq!(json["results"][0]["verdict"], "good", "{json}");
    assert!(finding(&json, "links-alone").is_some(), "{json}");
    let parameters = list_of(&json["results"][0]["parameters"]);
    for (name, truth) in [
        ("link1.izz", INERTIA),
        ("link1.mx", WEIGHT / 9.81),
        ("joint1.link_viscous", VISCOUS),
    ] {
        is_known(&json, name, truth, 0.02);
    }
    assert!(
        !parameters
            .iter()
            .any(|one| one["name"] == "joint1.rotor_inertia")
    );
    let spring = &json["sensed_springs"][0];
    let (value, error) = (
        f64_of(&spring["stiffness_nm_per_rad"]),
        f64_of(&spring["standard_error_nm_per_rad"]),
    );
    assert!((value - STIFFNESS).abs() < 4.0 * error, "{spring}");
    assert!(error < 0.01 * STIFFNESS, "{spring}");
    let output = desk.run(&["validate", "exp"]);
    assert!(
        output.out.contains("The promise is kept"),
        "{}{}",
        output.out,
        output.err
    );
}

#[test]
fn without_link_positions_the_motor_torques_are_still_asked_for() {
    let case = Case::new()
        .replace(
            "motor_torque_nm    = [\"tau1_nm\", \"tau2_nm\"]",
            "joint_torque_nm = [\"tau1_nm\", \"tau2_nm\"]",
        )
        .replace("link_position_rad  = [\"q1_rad\", \"q2_rad\"]\n", "");
    case.identify(&[]).ends(2).tells(&["motor_torque_nm"]);
}
