//! Messages about wrong joints, columns and names: exit code 2, the line of the file, the remedy.

use crate::arm::{described, recorded, robot, urdf};
use crate::common::{Case, contains, messages, one_line, replacement};

/// Assignments to keys of `[[robot.joint]]`.
const WRONG_KEYS: &[&str] = &[
    "elbow.gear_ratio=0",
    "elbow.gear_ratio=nan",
    "elbow.coulomb_sharpness_s_per_rad=-5",
    "shoulder.stribeck_velocity_rad_per_s=0",
    "elbow.position_offset_deg=inf",
    "elbow.nominal.rotor_inertia=nan",
    "elbow.spring=[\"linear\"]",
    "elbow.motor_friction=[\"coulomb\",\"load\"]",
    "shoulder.spring=[]",
    "shoulder.spring=[\"linear\",\"cubik\"]",
    "elbow.name=\"\"",
];

/// Text of the experiment, and what stands there instead.
const WRONG_TEXTS: &[(&str, &str)] = &[
    (LINKS, "link_position_rad = [\"q1\", \"phi2\"]"),
    (LINKS, "link_position_rad = [\"q1\", \"q2\"]"),
    (LINKS, "link_position_rad = []"),
    ("link_friction = [\"viscous\"]", "transmission = \"rigid\""),
    ("[\"phi1\", \"phi2\"]", "[\"phi1\"]"),
    ("motor_torque_nm = [\"tau1\", \"tau2\"]\n", ""),
    ("file = \"run.csv\"", "file = []"),
    ("file = \"run.csv\"", "file = [\"run.csv\", \"run.csv\"]"),
    (
        LAWS,
        "motor_friction = [\"coulomb\", \"coulomb-asymmetric\"]",
    ),
    (
        LAWS,
        "motor_friction = [\"viscous-asymmetric\", \"viscous\"]",
    ),
    (
        LAWS,
        "motor_friction = [\"offset\", \"coulomb-asymmetric\"]",
    ),
    (LAWS, "motor_friction = [\"quadratic\", \"residual\"]"),
    (LAWS, "motor_friction = [\"viscous\", \"viscous\"]"),
    (LAWS, "motor_friction = [\"coloumb\"]"),
];

const LINKS: &str = "link_position_rad = [\"q1\"]";
const LAWS: &str = "motor_friction = [\"viscous\", \"coulomb\"]";

/// Further keys of `[robot]`.
const WRONG_NAMES: &[&str] = &[
    "assume_zero = [\"fore.my\", \"for.mz\"]",
    "assume_zero = [\"gripper_link.ixx\"]",
    "fixed = { \"fore.mz\" = 0.1 }\nassume_zero = [\"fore.mz\"]",
    "fixed = { \"elbow.stiffness\" = 3.0 }",
    "fixed = { \"shoulder.stiffness\" = nan }",
    "fixed = { \"shoulder.stiffness\" = -3.0 }",
    "nominal = { \"shoulder.stiffness\" = 3.0 }",
];

#[test]
fn keys_of_joints() {
    let mut messages = messages("keys_of_joints");
    let case = described();
    for assignment in WRONG_KEYS {
        let text = format!("robot.joint.{assignment}");
        messages.note(assignment, &case.refused(2, &["--set", &text]));
    }
    messages.compare();
}

#[test]
fn columns_laws_and_names_that_do_not_match() {
    let mut messages = messages("columns_laws_and_names_that_do_not_match");
    for (text, wrong) in WRONG_TEXTS {
        let case = replacement(text, wrong);
        messages.note(&case, &described().replace(text, wrong).refused(2, &[]));
    }
    let hidden = (described().replace(LINKS, "joint_torque_nm = [\"q1\"]")).refused(
        2,
        &["--set", "robot.joint.shoulder.spring=[\"linear\",\"play\"]"],
    );
    messages.note("play of a joint with a torque sensor alone", &hidden);
    for keys in WRONG_NAMES {
        messages.note(&one_line(keys), &robot(keys).refused(2, &[]));
    }
    messages.compare();
}

/// The elbow slides, but its columns are those of a revolute joint.
fn prismatic() -> Case {
    let revolute = "\"elbow\" type=\"revolute\"";
    urdf(revolute, "\"elbow\" type=\"prismatic\"")
}

#[test]
fn joints_that_slide() {
    let mut messages = messages("joints_that_slide");
    let sliding = || {
        let positions = "[\"phi1\"]\nmotor_position_m = [\"phi2\"]";
        let torques = "[\"tau1\"]\nmotor_force_n = [\"tau2\"]";
        (prismatic().replace("[\"phi1\", \"phi2\"]", positions))
            .replace("[\"tau1\", \"tau2\"]", torques)
    };
    messages.note("columns in radians", &prismatic().refused(2, &[]));
    messages.note("an amplitude in degrees", &sliding().refused(2, &[]));
    for (text, wrong) in [
        (
            "name = \"elbow\"\n",
            "name = \"elbow\"\nposition_offset_deg = 90.0\n",
        ),
        ("sines = [", "centre_deg = [0.0, 5.0]\nsines = ["),
    ] {
        let message = sliding().replace(text, wrong).refused(2, &[]);
        messages.note(&one_line(wrong), &message);
    }
    messages.compare();
}

#[test]
fn numbers_beyond_reason() {
    // No such number may cause a panic; each run ends with an error of the log.
    let motor_side = [
        "--set",
        "log.motor_position_side=motor",
        "--set",
        "log.motor_torque_side=motor",
    ];
    let case = recorded();
    for more in [
        "robot.joint.elbow.gear_ratio=1e300",
        "robot.joint.elbow.gear_ratio=1e-300",
        "robot.transmission_matrix=[[1.0,0.0],[0.0,1e300]]",
        "robot.joint.elbow.position_offset_deg=1e300",
        "robot.fixed={\"shoulder.stiffness\"=1e300}",
    ] {
        let output = case.identify(&[&motor_side[..], &["--set", more]].concat());
        let message = &output.err;
        assert_eq!(output.code, Some(3), "{more}: {message}");
        contains(message, &["numbers that are not finite"]);
    }
}
