//! Messages about wrong joints, columns and names: exit code 2, the line of the file, the remedy.

use crate::arm::{described, recorded, robot, urdf};
use crate::common::stderr;

#[test]
fn gear_ratios_and_numbers_of_joints() {
    for (assignment, words) in [
        (
            "elbow.gear_ratio=0",
            "elbow: gear_ratio = 0 must be finite and not zero",
        ),
        (
            "elbow.gear_ratio=nan",
            "elbow: gear_ratio = NaN must be finite",
        ),
        (
            "elbow.coulomb_sharpness_s_per_rad=-5",
            "elbow: coulomb_sharpness_s_per_rad = -5 must be positive",
        ),
        (
            "shoulder.stribeck_velocity_rad_per_s=0",
            "shoulder: stribeck_velocity_rad_per_s = 0 must be positive",
        ),
        (
            "elbow.position_offset_deg=inf",
            "elbow: position_offset_deg must be finite",
        ),
        (
            "elbow.nominal.rotor_inertia=nan",
            "elbow: the nominal rotor_inertia must be finite",
        ),
        (
            "elbow.spring=[\"linear\"]",
            "elbow is rigid, it has no spring",
        ),
        (
            "elbow.motor_friction=[\"coulomb\",\"load\"]",
            "elbow is rigid, so no deflection measures the load of its gear",
        ),
        (
            "shoulder.spring=[]",
            "shoulder: spring must contain \"linear\"",
        ),
        (
            "shoulder.spring=[\"linear\",\"cubik\"]",
            "did you mean \"cubic\"?",
        ),
        ("elbow.name=\"\"", "has no joint \"\""),
    ] {
        let assignment = format!("robot.joint.{assignment}");
        let output = described().identify(&["--set", &assignment]);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(
            message.contains("--set") && message.contains(words),
            "{message}"
        );
    }
}

#[test]
fn columns_and_joints_that_do_not_match() {
    for columns in ["[\"q1\", \"phi2\"]", "[\"q1\", \"q2\"]"] {
        described()
            .replace(
                "link_position_rad = [\"q1\"]",
                &format!("link_position_rad = {columns}"),
            )
            .fails(
                2,
                &[
                    "line 18 of",
                    "elbow is rigid, so motor and link have one position",
                    "gives it a second column. Leave it out of link_position_rad",
                ],
            );
    }
    described()
        .replace("link_friction = [\"viscous\"]", "transmission = \"rigid\"")
        .fails(
            2,
            &[
                "line 18 of",
                "link_position_rad names 1 columns, the robot has no flexible joints",
            ],
        );
    described()
        .replace("[\"phi1\", \"phi2\"]", "[\"phi1\"]")
        .fails(
            2,
            &[
                "line 19 of",
                "motor_position_rad names 1 columns, the robot has 2 joints (shoulder, elbow)",
            ],
        );
    described()
        .replace("link_position_rad = [\"q1\"]", "link_position_rad = []")
        .fails(
            2,
            &[
                "line 18 of",
                "names 0 columns, the robot has 1 flexible joints (shoulder)",
            ],
        );
    described()
        .replace("motor_torque_nm = [\"tau1\", \"tau2\"]\n", "")
        .fails(
            2,
            &["does not say which columns hold the motor torques; add motor_torque_nm"],
        );
    described()
        .replace("file = \"run.csv\"", "file = []")
        .fails(2, &["line 16 of", "the list of files is empty"]);
    described()
        .replace("file = \"run.csv\"", "file = [\"run.csv\", \"run.csv\"]")
        .fails(2, &["line 16 of", "run.csv is listed twice"]);
}

#[test]
fn joints_that_slide() {
    let sliding = || {
        urdf(
            "\"elbow\" type=\"revolute\"",
            "\"elbow\" type=\"prismatic\"",
        )
        .replace(
            "[\"phi1\", \"phi2\"]",
            "[\"phi1\"]\nmotor_position_m = [\"phi2\"]",
        )
        .replace(
            "[\"tau1\", \"tau2\"]",
            "[\"tau1\"]\nmotor_force_n = [\"tau2\"]",
        )
    };
    urdf(
        "\"elbow\" type=\"revolute\"",
        "\"elbow\" type=\"prismatic\"",
    )
    .fails(
        2,
        &[
            "line 19 of",
            "names 2 columns, the robot has 1 revolute joints (shoulder)",
        ],
    );
    sliding().fails(
        2,
        &[
            "line 34 of",
            "elbow is prismatic; give amplitude_m instead of amplitude_deg",
        ],
    );
    sliding()
        .replace(
            "name = \"elbow\"\n",
            "name = \"elbow\"\nposition_offset_deg = 90.0\n",
        )
        .fails(
            2,
            &[
                "line 13 of",
                "elbow is prismatic, and position_offset_deg is for revolute joints",
            ],
        );
    sliding()
        .replace("sines = [", "centre_deg = [0.0, 5.0]\nsines = [")
        .fails(
            2,
            &[
                "line 31 of",
                "elbow is prismatic; its number in centre_deg must be 0",
            ],
        );
}

#[test]
fn friction_laws_that_say_the_same() {
    let friction = |laws: &str| {
        described().replace(
            "motor_friction = [\"viscous\", \"coulomb\"]",
            &format!("motor_friction = [{laws}]"),
        )
    };
    for (laws, words) in [
        (
            "\"coulomb\", \"coulomb-asymmetric\"",
            "\"coulomb-asymmetric\" already includes \"coulomb\"",
        ),
        (
            "\"viscous-asymmetric\", \"viscous\"",
            "\"viscous-asymmetric\" already includes \"viscous\"",
        ),
        (
            "\"offset\", \"coulomb-asymmetric\"",
            "\"coulomb-asymmetric\" already includes \"offset\"",
        ),
        (
            "\"quadratic\", \"residual\"",
            "\"residual\" already includes \"quadratic\"",
        ),
        (
            "\"viscous\", \"viscous\"",
            "motor_friction lists \"viscous\" twice",
        ),
    ] {
        friction(laws).fails(2, &["line 9 of", "shoulder", words]);
    }
    friction("\"coloumb\"").fails(2, &["line 9 of", "did you mean \"coulomb\"?"]);
}

#[test]
fn names_of_parameters_that_there_are_not() {
    robot("assume_zero = [\"fore.my\", \"for.mz\"]").fails(
        2,
        &[
            "line 5 of",
            "no link has the inertial parameter \"for.mz\" to assume zero",
            "\"fore.mz\"?",
        ],
    );
    robot("assume_zero = [\"gripper_link.ixx\"]").fails(
        2,
        &[
            "line 5 of",
            "they are called upper.m, upper.mx, upper.my and so on",
        ],
    );
    robot("fixed = { \"fore.mz\" = 0.1 }\nassume_zero = [\"fore.mz\"]").fails(
        2,
        &[
            "line 5 of",
            "fore.mz is fixed to 0.1 and assumed zero; keep one",
        ],
    );
    robot("fixed = { \"elbow.stiffness\" = 3.0 }").fails(
        2,
        &["has no parameter \"elbow.stiffness\"; did you mean \"shoulder.stiffness\"?"],
    );
    robot("fixed = { \"shoulder.stiffness\" = nan }").fails(
        2,
        &["line 5 of", "the fixed shoulder.stiffness must be finite"],
    );
    robot("fixed = { \"shoulder.stiffness\" = -3.0 }")
        .fails(2, &["the fixed shoulder.stiffness", "must be positive"]);
    robot("nominal = { \"shoulder.stiffness\" = 3.0 }").fails(
        2,
        &[
            "shoulder.stiffness",
            "values of joints stand in [[robot.joint]]",
        ],
    );
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
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(3), "{more}: {message}");
        assert!(message.contains("numbers that are not finite"), "{message}");
    }
}
