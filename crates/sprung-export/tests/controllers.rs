//! Code of controllers, compiled and run.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use sprung_core::shaper::Tap;
use sprung_export::{ControlCode, ExportError, Form, Format, Origin, Request, export};
use sprung_model::Model;
use sprung_robot::{
    Controller, ControllerKind, Experiment, Feedforward, Reference, no_files, read,
};

/// A turning and a sliding joint with springs, and a rigid joint.
const MIXED: &str = r#"format = 1
[robot]
name = "robot"
dh_modified = [
  { alpha_deg = 0.0, d_m = 0.3, theta_deg = 20.0 },
  { alpha_deg = -90.0, a_m = 0.1, prismatic = true },
  { alpha_deg = 90.0, a_m = 0.2, d_m = 0.1 },
]
gravity_m_per_s2 = [1.0, -2.0, -9.0]
[[robot.joint]]
name = "a"
spring = ["linear", "damping", "cubic"]
motor_friction = ["viscous", "coulomb", "presliding"]
presliding_width_rad = 0.2
[[robot.joint]]
name = "b"
[[robot.joint]]
name = "c"
transmission = "rigid"
motor_friction = ["viscous-asymmetric", "coulomb", "stribeck"]
"#;

const MIXED_TRUTH: &str = r#"
"a.rotor_inertia" = 0.8
"a.stiffness" = 900.0
"a.spring_damping" = 0.7
"a.cubic_stiffness" = 40.0
"a.spring_preload" = 2.0
"a.link_viscous" = 0.4
"a.motor_viscous" = 3.0
"a.link_coulomb" = 0.2
"a.motor_coulomb" = 1.5
"a.motor_presliding_5" = 0.8
"b.rotor_inertia" = 4.0
"b.stiffness" = 9000.0
"b.motor_viscous" = 30.0
"c.rotor_inertia" = 0.02
"c.motor_viscous_positive" = 0.3
"c.motor_viscous_negative" = 0.1
"c.motor_coulomb" = 0.25
"c.motor_stribeck" = 0.1
"#;

struct Case {
    experiment: Experiment,
    model: Model,
    values: BTreeMap<String, f64>,
}

fn request(case: &Case, format: Format) -> Request<'_> {
    Request {
        format,
        form: Form::Flexible,
        experiment: &case.experiment,
        model: &case.model,
        values: &case.values,
        urdf: None,
        is_there: &|_| false,
        evidence: &[],
        origin: Origin {
            experiment: "experiment.toml".to_owned(),
            parameters: "truth.toml".to_owned(),
            estimator: None,
            verdict: None,
            draw: None,
            logs: Vec::new(),
            values: Vec::new(),
        },
        control: None,
        observer: None,
    }
}

/// Reads the parameters of a twin.
fn twin(experiment: &str, truth: &str) -> Case {
    let experiment = read("test", experiment, &[], &mut no_files).unwrap();
    let values = truth.lines().filter_map(|line| {
        let (name, value) = line.strip_prefix('"')?.split_once('"')?;
        let value = value.trim_start_matches([' ', '=']).parse().unwrap();
        Some((name.to_owned(), value))
    });
    Case {
        model: Model::new(&experiment).unwrap(),
        values: values.collect(),
        experiment,
    }
}

fn mixed() -> Case {
    let mut case = twin(MIXED, MIXED_TRUTH);
    let names = [
        "m", "mx", "my", "mz", "ixx", "ixy", "iyy", "ixz", "iyz", "izz",
    ];
    for (link, by) in [("link1", 1.0), ("link2", 0.6), ("link3", 0.3)] {
        let body = [4.0, 0.4, -0.2, 0.3, 0.12, 0.03, 0.15, -0.02, 0.025, 0.2];
        for (name, value) in names.iter().zip(body) {
            case.values.insert(format!("{link}.{name}"), by * value);
        }
    }
    case
}

fn seven() -> Case {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/seven-joint-twin");
    let [experiment, truth] = ["experiment.toml", "truth.toml"]
        .map(|file| std::fs::read_to_string(folder.join(file)).unwrap());
    twin(&experiment, &truth)
}

fn control(kind: ControllerKind, n: usize) -> ControlCode {
    let entry = |i: usize, k: usize| 5.0 * ((3 * i + k) as f64).sin();
    let is_pd = kind == ControllerKind::Pd;
    let of_pd = |gain: f64| if is_pd { vec![gain; n] } else { Vec::new() };
    ControlCode {
        controller: Controller {
            kp_nm_per_rad: of_pd(50.0),
            kd_nms_per_rad: of_pd(0.5),
            gain: (0..if is_pd { 0 } else { n })
                .map(|i| (0..4 * n).map(|k| entry(i, k)).collect())
                .collect(),
            feedforward: Feedforward::Identified,
            friction_compensation_speed_rad_per_s: None,
            velocity_window: [4, 3],
            shaper: Vec::new(),
            reference: Reference::default(),
            kind,
        },
        period_s: 1e-3,
        torque_limits: (0..n).map(|i| 20.0 / (i + 1) as f64).collect(),
        taps: [(0, 0.5), (7, 0.3), (31, 0.2)]
            .map(|(delay, weight)| Tap { delay, weight })
            .to_vec(),
        header: vec!["Margins of 10 dB @ 45° */ %THETA%".to_owned()],
    }
}

fn state_feedback(n: usize, speed: Option<f64>) -> ControlCode {
    let mut control = control(ControllerKind::StateFeedback, n);
    control.controller.friction_compensation_speed_rad_per_s = speed;
    control
}

/// PD without shaper and limits.
fn pd(n: usize) -> ControlCode {
    let mut control = control(ControllerKind::Pd, n);
    control.controller.velocity_window = [0, 0];
    control.torque_limits.fill(f64::INFINITY);
    control.taps.clear();
    control.header.clear();
    control
}

/// Runs a program in a folder; returns what it printed.
fn run(folder: &Path, program: &str, line: &str) -> (bool, String) {
    let output = Command::new(program)
        .args(line.split_whitespace())
        .current_dir(folder)
        .output()
        .unwrap_or_else(|error| panic!("{program}: {error}"));
    let text = [output.stdout, output.stderr].concat();
    (
        output.status.success(),
        String::from_utf8_lossy(&text).into_owned(),
    )
}

fn write(folder: &Path, case: &Case, format: Format, control: &ControlCode) {
    let exported = export(&Request {
        control: Some(control.clone()),
        ..request(case, format)
    });
    for (file, text) in format.files().iter().zip(exported.unwrap().texts) {
        std::fs::write(folder.join(file), text).unwrap();
    }
}

fn two() -> Case {
    twin(sprung_base::demo::EXPERIMENT, sprung_base::demo::TRUTH)
}

fn for_controllers(mut judge: impl FnMut(&Path, &Case, &ControlCode)) {
    let folder = tempfile::tempdir().unwrap();
    let all: [(fn() -> Case, ControlCode); 5] = [
        (two, state_feedback(2, None)),
        (seven, state_feedback(7, Some(0.05))),
        (mixed, state_feedback(3, Some(0.1))),
        (mixed, control(ControllerKind::Pd, 3)),
        (two, pd(2)),
    ];
    for (case, control) in all {
        judge(folder.path(), &case(), &control);
    }
}

#[test]
fn c_has_the_controller_of_the_library() {
    if Command::new("cc").arg("--version").output().is_err() {
        sprung_testing::skipped("cc", "there is no compiler cc");
        return;
    }
    let strict = "-std=c99 -O2 -Wall -Wextra -Werror -Wconversion -pedantic -o robot_test";
    let mut unseen = vec![
        ("sum += gain[i][k]", "sum += R(1.001) * gain[i][k]"),
        ("tau_nm[i] = kp[i]", "tau_nm[i] = R(1.001) * kp[i]"),
        ("velocities[i] *= ", "velocities[i] *= R(1.001) * "),
        ("shaped[i] += ", "shaped[i] += R(1.001) * "),
        ("= own->is_running ? tau_nm[i] : R(0.0)", "= tau_nm[i]"),
        ("own->is_running && are_finite", "are_finite"),
        (" > limit ? limit", " > limit ? R(1.001) * limit"),
    ];
    for_controllers(|folder, case, control| {
        write(folder, case, Format::C, control);
        let passes = |more: &str| {
            let (ok, text) = run(
                folder,
                "cc",
                &format!("{strict} {more} robot.c robot_test.c -lm"),
            );
            assert!(ok, "{text}");
            let (ok, text) = run(folder, "./robot_test", "");
            (ok && text.contains("PASS"), text)
        };
        for more in ["", "-DSPRUNG_FLOAT", "-DSPRUNG_NO_CLOCK"] {
            let (ok, text) = passes(more);
            assert!(ok, "{more} {text}");
        }
        // Wrong numbers are seen, each in the first case that uses them.
        let code = std::fs::read_to_string(folder.join("robot.c")).unwrap();
        unseen.retain(|(right, wrong)| {
            let is_used = match *right {
                " > limit ? limit" => control.torque_limits.iter().all(|limit| limit.is_finite()),
                "shaped[i] += " => !control.taps.is_empty(),
                _ => code.contains(right),
            };
            if is_used {
                std::fs::write(folder.join("robot.c"), code.replacen(right, wrong, 1)).unwrap();
                assert!(!passes("").0, "{right}");
            }
            !is_used
        });
    });
    assert_eq!(unseen, [], "no case uses these");
}

#[test]
fn rust_has_the_controller_of_the_library_and_needs_no_standard_library() {
    for_controllers(|folder, case, control| {
        write(folder, case, Format::Rust, control);
        let rustc = |line: &str| {
            let (ok, text) = run(
                folder,
                "rustc",
                &format!("--edition 2021 -D warnings {line}"),
            );
            assert!(ok, "{text}");
        };
        let passes = || {
            rustc("--test robot.rs");
            let (ok, text) = run(folder, "./robot", "--nocapture");
            assert!(ok && text.contains("samples of the controller"), "{text}");
            assert!(!text.contains(" 0 passed"), "{text}");
        };
        passes();
        std::fs::write(folder.join("lib.rs"), "#![no_std]\npub mod robot;\n").unwrap();
        rustc("--crate-type lib lib.rs");
        let single = std::fs::read_to_string(folder.join("robot.rs")).unwrap();
        let single = single.replace("Real = f64;", "Real = f32;");
        std::fs::write(folder.join("robot.rs"), single).unwrap();
        passes();
    });
}

#[test]
fn code_without_controller_is_that_of_before() {
    let case = mixed();
    for format in [Format::C, Format::Rust] {
        let texts = export(&request(&case, format)).unwrap().texts;
        for text in texts {
            for word in ["control_", "feedforward", "Status", "%C", "%H"] {
                assert!(!text.contains(word), "{word}");
            }
        }
    }
}

#[test]
fn lines_about_the_controller_are_comments() {
    for (format, line) in [
        (Format::C, " * Margins of 10 dB @ 45° * / %THETA%\n"),
        (Format::Rust, "/// Margins of 10 dB @ 45° * / %THETA%\n"),
    ] {
        let case = mixed();
        let texts = export(&Request {
            control: Some(state_feedback(3, None)),
            ..request(&case, format)
        });
        assert!(texts.unwrap().texts[0].contains(line), "{line}");
    }
}

type Change = fn(&mut ControlCode);

#[test]
fn controllers_that_do_not_fit_are_refused() {
    let case = mixed();
    let change = |change: Change| {
        let mut control = state_feedback(3, Some(0.1));
        change(&mut control);
        export(&Request {
            control: Some(control),
            ..request(&case, Format::C)
        })
    };
    assert!(change(|_| {}).is_ok());
    let wrong: [(Change, &str); 13] = [
        (|control| control.period_s = 0.0, "period"),
        (|control| control.period_s = f64::NAN, "period"),
        (
            |control| control.controller.velocity_window = [1, 32],
            "window",
        ),
        (|control| control.torque_limits[1] = 0.0, "limit"),
        (|control| control.torque_limits[1] = f64::NAN, "limit"),
        (|control| control.torque_limits.truncate(2), "limits"),
        (|control| control.taps[0].weight = f64::NAN, "sum 1"),
        (|control| control.taps.truncate(1), "sum 1"),
        (|control| control.controller.gain.truncate(2), "rows"),
        (|control| control.controller.gain[1].truncate(11), "gains"),
        (
            |control| control.controller.gain[1][2] = f64::INFINITY,
            "gains",
        ),
        (
            |control| control.controller.friction_compensation_speed_rad_per_s = Some(-0.1),
            "speed",
        ),
        (
            |control| control.controller.kind = ControllerKind::Pd,
            "positions",
        ),
    ];
    for (mistake, word) in wrong {
        match change(mistake) {
            Err(ExportError::Controller { what }) => assert!(what.contains(word), "{what}"),
            other => panic!("{word}: {other:?}"),
        }
    }
    let long = change(|control| control.taps[0].delay = usize::MAX);
    assert!(
        matches!(long, Err(ExportError::TooLarge { .. })),
        "{long:?}"
    );
}
