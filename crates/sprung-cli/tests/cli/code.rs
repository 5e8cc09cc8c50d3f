//! The code of robots, compiled and run.

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use crate::arm::read;
use crate::common::Case;
use crate::export::{known, with_values};

/// Turning and sliding joints, flexible and rigid, in a tilted world, with a name that C forbids.
const MIXED: &str = r#"format = 1
[robot]
name = "2 mixed -- odd"
dh_modified = [
  { alpha_deg = 0.0, d_m = 0.3, theta_deg = 20.0 },
  { alpha_deg = -90.0, a_m = 0.1, prismatic = true },
  { alpha_deg = 90.0, a_m = 0.2, d_m = 0.1 },
]
gravity_m_per_s2 = [1.0, -2.0, -9.0]
[[robot.joint]]
name = "a"
spring = ["linear", "damping", "cubic"]
gear_ratio = 50.0
motor_friction = ["viscous", "coulomb", "load", "presliding"]
[[robot.joint]]
name = "int"
spring = ["linear", "hysteresis"]
[[robot.joint]]
name = "c 1.x"
transmission = "rigid"
motor_friction = ["viscous-asymmetric", "coulomb-asymmetric", "stribeck"]
"#;

const DRIVES: &str = r#"
"a.rotor_inertia" = 0.8
"a.stiffness" = 900.0
"a.spring_damping" = 0.7
"a.cubic_stiffness" = 40.0
"a.link_viscous" = 0.4
"a.motor_viscous" = 3.0
"a.motor_coulomb" = 1.5
"a.motor_load" = 2.5
"a.motor_presliding_2" = 0.3
"a.motor_presliding_5" = 0.1
"int.rotor_inertia" = 4.0
"int.stiffness" = 9000.0
"int.motor_viscous" = 30.0
"int.spring_hysteresis_3" = 0.4
"c 1.x.rotor_inertia" = 0.02
"c 1.x.motor_viscous_positive" = 0.3
"c 1.x.motor_viscous_negative" = 0.1
"c 1.x.motor_coulomb_positive" = 0.25
"c 1.x.motor_coulomb_negative" = 0.2
"c 1.x.motor_stribeck" = 0.1
"#;

fn mixed() -> Case {
    let mut values = DRIVES.to_owned();
    for (link, by) in [("link1", 1.0), ("link2", 0.6), ("link3", 0.3)] {
        for (name, value) in [
            ("m", 4.0),
            ("mx", 0.4),
            ("my", -0.2),
            ("mz", 0.3),
            ("ixx", 0.12),
            ("ixy", 0.03),
            ("iyy", 0.15),
            ("ixz", -0.02),
            ("iyz", 0.025),
            ("izz", 0.2),
        ] {
            let _ = writeln!(values, "\"{link}.{name}\" = {:?}", by * value);
        }
    }
    Case::of(&[("experiment.toml", MIXED), ("values.toml", &values)])
}

/// Writes the code of a robot; returns its folder.
fn exported(case: &Case, format: &str) -> std::path::PathBuf {
    with_values(case, format, &[]).ends(0);
    case.path("sprung-out")
}

/// Runs a program in a folder; returns whether it succeeded, and its output.
fn run(folder: &Path, program: &str, args: &[&str]) -> (bool, String) {
    let output = Command::new(program)
        .args(args)
        .current_dir(folder)
        .output()
        .unwrap_or_else(|error| panic!("{program}: {error}"));
    let text = [output.stdout, output.stderr].concat();
    let text = String::from_utf8_lossy(&text).into_owned();
    (output.status.success(), text)
}

const STRICT: &str = "-std=c99 -O1 -Wall -Wextra -Werror -Wconversion -pedantic -o robot_test";

fn compile(folder: &Path, more: &str) {
    let line = format!("{STRICT} {more} robot.c robot_test.c -lm");
    let (ok, text) = run(folder, "cc", &line.split_whitespace().collect::<Vec<_>>());
    assert!(ok, "{text}");
}

#[test]
fn c_has_the_numbers_of_the_model() {
    if Command::new("cc").arg("--version").output().is_err() {
        sprung_testing::skipped("cc", "there is no compiler cc");
        return;
    }
    for case in [known(), mixed()] {
        let folder = exported(&case, "c");
        for more in ["", "-DSPRUNG_FLOAT", "-DSPRUNG_NO_CLOCK"] {
            compile(&folder, more);
            let (ok, text) = run(&folder, "./robot_test", &[]);
            assert!(ok && text.contains("PASS"), "{more}: {text}");
        }
        // Wrong numbers are seen.
        let code = read(&folder.join("robot.c"));
        for (right, wrong) in [
            (" = R(0.", " = R(1."),
            (" regressor[0] = ", " regressor[0] = R(1.0) + "),
            ("+ travel /", "- travel /"),
        ] {
            let wrong = code.replacen(right, wrong, 1);
            let has_no_memory = right.contains("travel") && !code.contains("_remember(");
            assert!(wrong != code || has_no_memory, "there is no {right}");
            if has_no_memory {
                continue;
            }
            std::fs::write(folder.join("robot.c"), wrong).unwrap();
            compile(&folder, "");
            let (ok, text) = run(&folder, "./robot_test", &[]);
            assert!(!ok && text.contains("FAIL"), "{text}");
        }
        // An edited file is not replaced.
        with_values(&case, "c", &[]).tells(&["robot.c was edited"]);
        with_values(&case, "c", &["--force"]).ends(0);
    }
}

#[test]
fn rust_has_the_numbers_of_the_model_and_needs_no_standard_library() {
    for case in [known(), mixed()] {
        let folder = exported(&case, "rust");
        let rustc = |line: &str| {
            let line = format!("--edition 2021 -D warnings {line}");
            let (ok, text) = run(&folder, "rustc", &line.split(' ').collect::<Vec<_>>());
            assert!(ok, "{text}");
        };
        rustc("--test robot.rs");
        let (ok, text) = run(&folder, "./robot", &["--nocapture"]);
        assert!(ok && text.contains("PASS"), "{text}");
        std::fs::write(folder.join("lib.rs"), "#![no_std]\npub mod robot;\n").unwrap();
        rustc("--crate-type lib lib.rs");
        let single = read(&folder.join("robot.rs")).replace("Real = f64;", "Real = f32;");
        std::fs::write(folder.join("robot.rs"), single).unwrap();
        rustc("--test robot.rs");
        let (ok, text) = run(&folder, "./robot", &[]);
        assert!(ok, "{text}");
    }
}
