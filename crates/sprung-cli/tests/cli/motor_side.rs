//! Springs of robots whose motors alone are measured.

use serde_json::Value;

use crate::common::{Case, finding, sprung, stderr, stdout};

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
    std::fs::write(case.path("experiment.toml"), MOTORS).unwrap();
    case
}

#[test]
fn friction_of_the_demo_hides_the_vibrations() {
    let case = motors();
    let (_, json) = case.results(&[]);
    assert!(finding(&json, "resonance-not-excited").is_some(), "{json}");
    for spring in json["springs_from_motor"].as_array().unwrap() {
        assert_eq!(spring["stiffness"], Value::Null);
    }
    let html = std::fs::read_to_string(case.path("sprung-out/report.html")).unwrap();
    assert!(html.contains("Springs seen from the motors"));
    // The check reports it before the fit.
    let experiment = case.path("experiment.toml");
    let output = sprung(&["check", experiment.to_str().unwrap()]);
    let text = stdout(&output);
    assert!(text.contains("resonance-not-excited"), "{text}");
}

#[test]
fn flexible_joints_are_refused_by_name() {
    let case = motors().replace(
        "name = \"joint2\"\ntransmission = \"rigid\"",
        "name = \"joint2\"",
    );
    let output = case.identify(&[]);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2));
    assert!(message.contains("line 16 of"), "{message}");
    assert!(message.contains("joint2 is flexible"), "{message}");
}
