//! Springs of robots whose motors alone are measured.

use serde_json::Value;

use crate::common::{Case, contains, finding, list_of};

const MOTORS: &str = r#"format = 1
[robot]
kinematics = "planar-2r"
[[robot.joint]]
name = "joint1"
transmission = "rigid"
[[robot.joint]]
name = "joint2"
transmission = "rigid"
[log]
file = "identification.csv"
time_s = "t_s"
motor_position_rad = ["phi1_rad", "phi2_rad"]
motor_torque_nm = ["tau1_nm", "tau2_nm"]
[identify]
estimator = "least-squares"
springs_from_motor = true
"#;

fn motors() -> Case {
    let case = Case::new();
    case.write("experiment.toml", MOTORS);
    case
}

#[test]
fn friction_of_the_demo_hides_the_vibrations() {
    let case = motors();
    let (_, json) = case.results(&[]);
    assert!(finding(&json, "resonance-not-excited").is_some(), "{json}");
    for spring in list_of(&json["springs_from_motor"]) {
        assert_eq!(spring["stiffness"], Value::Null);
    }
    contains(
        &case.read("sprung-out/report.html"),
        &["Springs seen from the motors"],
    );
    // The check reports it before the fit.
    case.run("check", &[]).prints(&["resonance-not-excited"]);
}

#[test]
fn flexible_joints_are_refused_by_name() {
    let case = motors().replace(
        "name = \"joint2\"\ntransmission = \"rigid\"",
        "name = \"joint2\"",
    );
    case.identify(&[])
        .ends(2)
        .tells(&["line 16 of", "joint2 is flexible"]);
}
