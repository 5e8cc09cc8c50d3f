//! Messages about a wrong experiment file: exit code 2, its line, the remedy.

use crate::common::{Case, f64_of, messages, one_line, sprung};

/// Text of the demo's experiment, and what stands there instead.
#[rustfmt::skip]
const WRONG_TEXTS: &[(&str, &str)] = &[
    ("format = 1", "format = "),
    ("position_cutoff_hz =", "position_cutof_hz ="),
    ("stiffness = 9.0", "stifness = 9.0"),
    ("period_s   = 0.001", "period_s = \"fast\""),
    ("[\"least-squares\", \"lsff\"]", "3"),
    ("\"lsff\"]", "\"lsf\"]"),
    ("\"lsff\"]", "\"output-error\"]"),
    ("[\"phi1_rad\", \"phi2_rad\"]", "[\"phi1_rad\"]"),
    (
        "{ joint = \"joint1\", amplitude_deg = 3.0, frequency_hz = 1.0",
        "{ joint = \"joint3\", amplitude_deg = 3.0, frequency_hz = 1.0",
    ),
    ("kp_nm_per_rad   = [50.0, 5.0]", "kp_nm_per_rad = [50.0]"),
    ("position_cutoff_hz = \"auto\"", "position_cutoff_hz = 600.0"),
    ("name = \"direct\"", "name = \"di,rect\""),
    ("name = \"direct\"", "name = \"prediction\""),
    ("name = \"joint2\"\n", "name = \"joint1\"\n"),
    ("[50.0, 5.0]", "[50.0, nan]"),
    ("\"link2.coupling\"      = 0.016474", "\"link2.coupling\" = inf"),
    ("stiffness = 9.0", "stiffness = nan"),
    ("time_s             = \"t_s\"", "time_s = \"t_s\"\ndelay_s = { q1_rad = 1e300 }"),
    ("time_s             = \"t_s\"", "time_s = \"t_s\"\nsign = { q1 = -1 }"),
    ("time_s             = \"t_s\"", "time_s = \"t_s\"\ntorque = \"hold\""),
    ("time_s             = \"t_s\"", "time_s = \"t_s\"\ntorque = \"held\"\ncontroller_period_s = -0.001"),
    ("time_s             = \"t_s\"", "time_s = \"t_s\"\ncontroller_period_s = 0.001"),
];

#[test]
fn wrong_texts_are_named_with_line_and_remedy() {
    let mut messages = messages("wrong_texts_are_named_with_line_and_remedy");
    for (text, wrong) in WRONG_TEXTS {
        let message = Case::new().replace(text, wrong).refused(2, &[]);
        messages.note(&one_line(wrong), &message);
    }
    let output = sprung(&["identify", "/nonexistent/experiment.toml"]);
    output.ends(4);
    messages.note("no file", &output.err);
    // Drives need constants that lie beside them.
    let constant = "torque_constant_nm_per_a = 0.119\n";
    let current =
        (Case::new().replace(constant, "")).replace("motor_torque_nm    =", "motor_current_a =");
    messages.note("currents without torque constant", &current.refused(2, &[]));
    let of_joint = format!("{constant}amplifier_gain_a_per_v = 0.5\n");
    let limit = "amplifier_gain_a_per_v = 0.5\namplifier_limit_v = 10.0";
    let drive = "winding_resistance_ohm = 2.6\nback_emf_vs_per_rad = 0.119";
    for keys in [limit, drive] {
        let behind_gear = format!("{constant}gear_ratio = 50.0\n{keys}\n");
        let message = Case::new().replace(&of_joint, &behind_gear).refused(2, &[]);
        messages.note(&one_line(&behind_gear), &message);
    }
    messages.compare();
}

#[test]
fn overrides_are_checked_too() {
    let mut messages = messages("overrides_are_checked_too");
    let case = Case::new();
    for assignment in [
        "identify.position_cutoff",
        "identify.position_cutof_hz=3",
        "identify.position_cutoff_hz=-3",
        "identify.estimator=prediction-eror",
        "robot.joint.joint3.gear_ratio=2",
        "robot.joint.joint1.gear_ration=2",
        "robot.joint.joint1.gear_ratio=0",
    ] {
        messages.note(assignment, &case.refused(2, &["--set", assignment]));
    }
    // Absurd cut-offs ask for a longer log.
    for cutoff in ["1e-9", "1e-300"] {
        let assignment = format!("identify.position_cutoff_hz={cutoff}");
        messages.note(&assignment, &case.refused(3, &["--set", &assignment]));
    }
    messages.compare();
    case.identify(&["--set", "identify.position_cutoff_hz=12", "--quiet"])
        .ends(0);
}

#[test]
fn overrides_reach_into_lists_by_name_or_index() {
    let case = Case::new();
    let stiffness = |assignment: &str| {
        let json = case
            .identify(&["--json", "--set", assignment])
            .ends(0)
            .json();
        f64_of(&json["results"][0]["parameters"][13]["value"])
    };
    let sharp = stiffness("robot.joint.joint1.coulomb_sharpness_s_per_rad=100");
    let blunt = stiffness("robot.joint.joint1.coulomb_sharpness_s_per_rad=20");
    assert_ne!(blunt.to_bits(), sharp.to_bits());
    let by_index = stiffness("robot.joint.0.coulomb_sharpness_s_per_rad=20");
    assert!((blunt - by_index).abs() < 1e-12);
}
