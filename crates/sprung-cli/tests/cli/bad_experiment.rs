//! Messages about a wrong experiment file: exit code 2, its line, the remedy.

use crate::common::{Case, sprung, stderr};

#[test]
fn missing_file() {
    let output = sprung(&["identify", "/nonexistent/experiment.toml"]);
    assert_eq!(output.status.code(), Some(4));
    let message = stderr(&output);
    assert!(
        message.contains("there is no experiment file /nonexistent/experiment.toml"),
        "{message}"
    );
}

#[test]
fn not_toml() {
    Case::new()
        .replace("format = 1", "format = ")
        .fails(2, &["line 3 of"]);
}

#[test]
fn unknown_key_names_the_nearest() {
    Case::new()
        .replace("position_cutoff_hz =", "position_cutof_hz =")
        .fails(
            2,
            &[
                "line 39",
                "\"position_cutof_hz\" in [identify]",
                "did you mean \"position_cutoff_hz\"?",
            ],
        );
    Case::new()
        .replace("stiffness = 9.0", "stifness = 9.0")
        .fails(2, &["[robot.joint.nominal]", "did you mean \"stiffness\"?"]);
}

#[test]
fn wrong_type() {
    Case::new()
        .replace("period_s   = 0.001", "period_s = \"fast\"")
        .fails(
            2,
            &["line", "invalid type: string \"fast\", expected a number"],
        );
    Case::new()
        .replace("[\"least-squares\", \"lsff\"]", "3")
        .fails(2, &["line", "the name of an estimator"]);
}

#[test]
fn unknown_word_names_the_nearest() {
    Case::new().replace("\"lsff\"]", "\"lsf\"]").fails(
        2,
        &["line", "unknown estimator \"lsf\"; did you mean \"lsff\"?"],
    );
}

#[test]
fn wrong_number_of_columns() {
    Case::new()
        .replace("[\"phi1_rad\", \"phi2_rad\"]", "[\"phi1_rad\"]")
        .fails(
            2,
            &[
                "line",
                "motor_position_rad names 1 columns, the robot has 2 joints",
            ],
        );
}

#[test]
fn references_speak_of_joints_that_exist() {
    Case::new()
        .replace(
            "{ joint = \"joint1\", amplitude_deg = 3.0, frequency_hz = 1.0",
            "{ joint = \"joint3\", amplitude_deg = 3.0, frequency_hz = 1.0",
        )
        .fails(2, &["line", "no joint \"joint3\"; did you mean"]);
}

#[test]
fn gains_have_the_right_shape() {
    Case::new()
        .replace("kp_nm_per_rad   = [50.0, 5.0]", "kp_nm_per_rad = [50.0]")
        .fails(2, &["line", "needs 2 numbers in kp_nm_per_rad"]);
}

#[test]
fn cut_off_above_nyquist() {
    Case::new()
        .replace(
            "position_cutoff_hz = \"auto\"",
            "position_cutoff_hz = 600.0",
        )
        .fails(
            2,
            &[
                "a cut-off of 600 Hz needs more than 1200 samples per second",
                "position_cutoff_hz below 500",
            ],
        );
}

#[test]
fn overrides_are_checked_too() {
    let case = Case::new();
    for (assignment, fragments) in [
        (
            "identify.position_cutoff",
            vec!["write it as key.path=value"],
        ),
        (
            "identify.position_cutof_hz=3",
            vec!["--set", "did you mean"],
        ),
        (
            "identify.position_cutoff_hz=-3",
            vec!["--set", "must be positive"],
        ),
        (
            "identify.estimator=prediction-eror",
            vec!["did you mean \"prediction-error\"?"],
        ),
    ] {
        let output = case.identify(&["--set", assignment]);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{message}");
        for fragment in fragments {
            assert!(message.contains(fragment), "{message}");
        }
    }
    let output = case.identify(&["--set", "identify.position_cutoff_hz=12", "--quiet"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
}

#[test]
fn current_needs_a_torque_constant() {
    Case::new()
        .replace("torque_constant_nm_per_a = 0.119\n", "")
        .replace("motor_torque_nm    =", "motor_current_a =")
        .fails(2, &["joint1: torque_constant_nm_per_a is needed"]);
}

#[test]
fn voltages_behind_a_gear_need_the_side_of_the_torque_constant() {
    let with = |keys: &str| {
        let constant = "torque_constant_nm_per_a = 0.119\n";
        let of_joint = format!("{constant}amplifier_gain_a_per_v = 0.5\n");
        Case::new().replace(&of_joint, &format!("{constant}gear_ratio = 50.0\n{keys}\n"))
    };
    let limit = "amplifier_gain_a_per_v = 0.5\namplifier_limit_v = 10.0";
    let drive = "winding_resistance_ohm = 2.6\nback_emf_vs_per_rad = 0.119";
    for (keys, needed_by) in [(limit, "a voltage limit"), (drive, "a voltage drive")] {
        let said = format!(
            "joint1: {needed_by} needs torque_constant_side, because the gear ratio 50 is not 1"
        );
        with(keys).fails(
            2,
            &[
                &said,
                "0.119 N·m/A at the output",
                "5.9500 N·m/A with \"motor\"",
            ],
        );
    }
}

#[test]
fn names_delays_and_nominal_values_are_checked() {
    Case::new()
        .replace("name = \"direct\"", "name = \"di,rect\"")
        .fails(2, &["line", "\"di,rect\" must consist of letters"]);
    Case::new()
        .replace("name = \"direct\"", "name = \"prediction\"")
        .fails(
            2,
            &["line", "two validation runs are called \"prediction\""],
        );
    Case::new()
        .replace("name = \"joint2\"\n", "name = \"joint1\"\n")
        .fails(2, &["line", "two joints are called \"joint1\""]);
    Case::new()
        .replace("[50.0, 5.0]", "[50.0, nan]")
        .fails(2, &["line", "every number of kp_nm_per_rad must be finite"]);
    Case::new()
        .replace(
            "\"link2.coupling\"      = 0.016474",
            "\"link2.coupling\" = inf",
        )
        .fails(2, &["line", "the nominal link2.coupling must be finite"]);
    Case::new()
        .replace("stiffness = 9.0", "stiffness = nan")
        .fails(2, &["line", "joint1: the nominal stiffness must be finite"]);
    Case::new()
        .replace(
            "time_s             = \"t_s\"",
            "time_s = \"t_s\"\ndelay_s = { q1_rad = 1e300 }",
        )
        .fails(2, &["line", "the delay of \"q1_rad\"", "within ±60 s"]);
    Case::new()
        .replace(
            "time_s             = \"t_s\"",
            "time_s = \"t_s\"\nsign = { q1 = -1 }",
        )
        .fails(
            2,
            &[
                "line",
                "\"q1\", which is not a column",
                "did you mean \"q1_rad\"?",
            ],
        );
}

#[test]
fn absurd_cut_offs_ask_for_a_longer_log() {
    let case = Case::new();
    for cutoff in ["1e-9", "1e-300"] {
        let output = case.identify(&["--set", &format!("identify.position_cutoff_hz={cutoff}")]);
        assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
        assert!(
            stderr(&output).contains("samples, at least"),
            "{}",
            stderr(&output)
        );
    }
}

#[test]
fn overrides_reach_into_lists_by_name_or_index() {
    let case = Case::new();
    let stiffness = |assignment: &str| {
        let output = case.identify(&["--json", "--set", assignment]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        json["results"][0]["parameters"][13]["value"]
            .as_f64()
            .unwrap()
    };
    let sharp = stiffness("robot.joint.joint1.coulomb_sharpness_s_per_rad=100");
    let blunt = stiffness("robot.joint.joint1.coulomb_sharpness_s_per_rad=20");
    assert_ne!(blunt.to_bits(), sharp.to_bits());
    let by_index = stiffness("robot.joint.0.coulomb_sharpness_s_per_rad=20");
    assert!((blunt - by_index).abs() < 1e-12);
    for (assignment, fragment) in [
        (
            "robot.joint.joint3.gear_ratio=2",
            "there is no element \"joint3\"; there are 2 (joint1, joint2)",
        ),
        (
            "robot.joint.joint1.gear_ration=2",
            "did you mean \"gear_ratio\"?",
        ),
        (
            "robot.joint.joint1.gear_ratio=0",
            "must be finite and not zero",
        ),
    ] {
        let output = case.identify(&["--set", assignment]);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(
            message.contains("--set") && message.contains(fragment),
            "{message}"
        );
    }
}

/// A line of `[log]` of the demo, whose period is 1 ms, and the message about it.
#[test]
fn a_wrong_timing_of_the_torques_is_refused() {
    let fails = |line: &str, fragments: &[&str]| {
        let time = "time_s             = \"t_s\"";
        Case::new()
            .replace(time, &format!("{time}\n{line}"))
            .fails(2, fragments);
    };
    fails(
        "torque = \"hold\"",
        &["line", "unknown torque \"hold\"; did you mean \"held\"?"],
    );
    fails(
        "torque = \"held\"\ncontroller_period_s = -0.001",
        &["line", "controller_period_s = -0.001 must be positive"],
    );
    fails(
        "controller_period_s = 0.001",
        &[
            "line",
            "add torque = \"held\", \"mean\" or \"instantaneous\"",
        ],
    );
}
