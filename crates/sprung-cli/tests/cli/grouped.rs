//! Parameters of which a robot or a log shows only a combination: the combination has a value.

use std::fmt::Write as _;

use serde_json::Value;

use crate::common::{Case, f64_of, finding, is_known, list_of};

const GRAVITY: f64 = 9.81;

/// Motor torque of one rigid joint: inertia, viscous and Coulomb friction, constant torque.
const TRUE: [f64; 4] = [4.0, 20.0, 5.0, 0.7];

/// Writes the log of one rigid joint, and a second one of another motion.
///
/// - `motion`: position, velocity and acceleration at a time; `weight`: constant torque of gravity.
fn write_logs(case: &Case, motion: impl Fn(f64, f64) -> [f64; 3], weight: f64) {
    for (file, pace) in [("first.csv", 1.0), ("second.csv", 0.8)] {
        let mut text = "t,x,f\n".to_owned();
        for k in 0..6000 {
            let t = 0.002 * f64::from(k);
            let [x, v, a] = motion(t, pace);
            let noise = 0.03 * ((12.9898 * f64::from(k)).sin() * 43_758.545_3).fract();
            let torque =
                TRUE[0] * a + TRUE[1] * v + TRUE[2] * (100.0 * v).tanh() + TRUE[3] + weight;
            writeln!(text, "{t},{x},{}", torque + noise).unwrap();
        }
        case.write(file, text);
    }
}

fn described(case: &Case, robot: &str) {
    let text = format!(
        "format = 1\n[robot]\n{robot}\n[[robot.joint]]\nname = \"lift\"\ntransmission = \"rigid\"\n\
         motor_friction = [\"viscous\", \"coulomb\", \"offset\"]\n[log]\nfile = \"first.csv\"\ntime_s = \"t\"\n\
         motor_position_rad = [\"x\"]\nmotor_torque_nm = [\"f\"]\n[[validate]]\nname = \"second\"\nlog = {{ file = \"second.csv\" }}\n"
    );
    let text = if robot.contains("prismatic") {
        text.replace("_rad = [", "_m = [")
            .replace("_torque_nm", "_force_n")
    } else {
        text
    };
    case.write("experiment.toml", text);
}

/// Asserts that the result is good and its promise is kept on the second log.
fn is_good_and_proved(case: &Case) -> Value {
    let (_, json) = case.results(&[]);
    assert_eq!(json["results"][0]["verdict"], "good", "{json}");
    let output = case.run("validate", &[]);
    assert!(
        output.out.contains("The promise is kept"),
        "{}{}",
        output.out,
        output.err
    );
    json
}

#[test]
fn the_rotor_of_a_lift_is_part_of_its_mass_and_of_its_constant_force() {
    let case = Case::new();
    let mass = 3.0;
    let motion = |t: f64, pace: f64| {
        let (w, w2) = (3.0 * pace, 7.1 * pace);
        [
            0.2 * (w * t).sin() + 0.05 * (w2 * t).sin(),
            0.2 * w * (w * t).cos() + 0.05 * w2 * (w2 * t).cos(),
            -0.2 * w * w * (w * t).sin() - 0.05 * w2 * w2 * (w2 * t).sin(),
        ]
    };
    // The inertia of 4 kg is a mass of 3 kg and a rotor of 1 kg.
    write_logs(&case, motion, mass * GRAVITY);
    described(
        &case,
        "dh_modified = [{ prismatic = true }]\ngravity_m_per_s2 = [0.0, 0.0, -9.81]",
    );
    let json = is_good_and_proved(&case);
    is_known(&json, "link1.m + lift.rotor_inertia", TRUE[0], 0.05);
    is_known(
        &json,
        "lift.motor_offset - 9.81*lift.rotor_inertia",
        TRUE[3] - GRAVITY * (TRUE[0] - mass),
        0.05,
    );
    // A rotor that the file gives leaves mass and constant force with values of their own.
    let given = case.replace(
        "[robot]\n",
        "[robot]\nfixed = { \"lift.rotor_inertia\" = 1.0 }\n",
    );
    let (_, json) = given.results(&[]);
    is_known(&json, "link1.m", mass, 0.05);
    is_known(&json, "lift.motor_offset", TRUE[3], 0.05);
}

#[test]
fn friction_of_one_direction_is_one_value_with_the_constant_torque() {
    for direction in [1.0, -1.0] {
        let case = Case::new();
        let motion = |t: f64, pace: f64| {
            let mut motion = [0.8 * direction * t, 0.8 * direction, 0.0];
            for (size, w) in [(0.05, 3.0 * pace), (0.02, 7.1 * pace), (0.01, 17.3 * pace)] {
                motion[0] += size * (w * t).sin();
                motion[1] += size * w * (w * t).cos();
                motion[2] -= size * w * w * (w * t).sin();
            }
            motion
        };
        write_logs(&case, motion, 0.0);
        described(&case, "dh_modified = [{}]");
        let json = is_good_and_proved(&case);
        is_known(
            &json,
            "lift.motor_coulomb",
            TRUE[2] + direction * TRUE[3],
            0.05,
        );
        let parameters = list_of(&json["results"][0]["parameters"]);
        let of = |name: &str| parameters.iter().find(|one| one["name"] == name).unwrap();
        let sum = if direction > 0.0 {
            "+ lift.motor_offset"
        } else {
            "- lift.motor_offset"
        };
        assert_eq!(of("lift.motor_coulomb")["sum_with"], sum);
        assert_eq!(of("lift.motor_offset")["value"], 0.0);
        assert_eq!(of("lift.motor_offset")["fixed"], true);
        assert!(finding(&json, "sum-only").is_some(), "{json}");
    }
}

#[test]
fn a_robot_with_one_open_parameter_gets_its_value() {
    let case = Case::new();
    let (_, json) = case.results(&["--set", "identify.estimator=\"least-squares\""]);
    let parameters = list_of(&json["results"][0]["parameters"]);
    let (open, given) = parameters.split_last().unwrap();
    let given: Vec<String> = (given.iter())
        .map(|one| format!("{} = {}", one["name"], one["value"]))
        .collect();
    let fixed = format!("robot.fixed={{ {} }}", given.join(", "));
    let (_, again) = case.results(&[
        "--set",
        "identify.estimator=\"least-squares\"",
        "--set",
        &fixed,
    ]);
    let found = list_of(&again["results"][0]["parameters"]).last().unwrap();
    let number = |of: &Value, key: &str| f64_of(&of[key]);
    assert!(
        (number(found, "value") - number(open, "value")).abs()
            < 3.0 * number(open, "standard_error")
    );
    assert!(number(found, "standard_error") < number(open, "standard_error"));
}
