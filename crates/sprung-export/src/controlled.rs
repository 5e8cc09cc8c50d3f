//! Code of controllers, compiled and run.

use std::path::Path;
use std::process::Command;

use super::tests::{Case, case, mixed, request};
use super::write::{Request, export};
use super::{ControllerCode, ExportError, FeedbackCode, FeedforwardCode, Form, Format, ShaperTap};

/// Reads the parameters of a twin.
fn twin(experiment: &str, truth: &str) -> Case {
    let values: Vec<(&str, f64)> = (truth.lines())
        .filter_map(|line| {
            let (name, value) = line.strip_prefix('"')?.split_once("\"")?;
            Some((name, value.trim_start_matches([' ', '=']).parse().unwrap()))
        })
        .collect();
    case(experiment, &values)
}

fn seven() -> Case {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/seven-joint-twin");
    let [experiment, truth] = ["experiment.toml", "truth.toml"]
        .map(|file| std::fs::read_to_string(folder.join(file)).unwrap());
    twin(&experiment, &truth)
}

fn state_feedback(n: usize) -> ControllerCode {
    let entry = |i: usize, k: usize| 5.0 * ((3 * i + k) as f64).sin();
    ControllerCode {
        period: 1e-3,
        velocity_window: [4, 3],
        torque_limits: (0..n).map(|i| 20.0 / (i + 1) as f64).collect(),
        feedforward: FeedforwardCode::WithFriction {
            velocity_scales: (0..n).map(|i| 0.05 * (i + 1) as f64).collect(),
        },
        feedback: FeedbackCode::State {
            gain: (0..n)
                .map(|i| (0..4 * n).map(|k| entry(i, k)).collect())
                .collect(),
        },
        shaper: [(0, 0.5), (7, 0.3), (31, 0.2)]
            .map(|(delay, weight)| ShaperTap { delay, weight })
            .to_vec(),
    }
}

fn pd(n: usize, feedforward: FeedforwardCode) -> ControllerCode {
    ControllerCode {
        period: 2e-3,
        velocity_window: [0, 0],
        torque_limits: vec![f64::INFINITY; n],
        feedforward,
        feedback: FeedbackCode::Motors {
            kp: vec![50.0; n],
            kd: vec![0.5; n],
        },
        shaper: Vec::new(),
    }
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

fn write(folder: &Path, case: &Case, format: Format, controller: &ControllerCode) {
    let exported = export(&Request {
        controller: Some(controller),
        ..request(case, format, Form::Flexible)
    });
    for (file, text) in format.files().iter().zip(exported.unwrap().texts) {
        std::fs::write(folder.join(file), text).unwrap();
    }
}

fn for_controllers(mut judge: impl FnMut(&Path, &Case, &ControllerCode)) {
    let two = || twin(sprung_base::demo::EXPERIMENT, sprung_base::demo::TRUTH);
    let folder = tempfile::tempdir().unwrap();
    for (case, controller) in [
        (two(), state_feedback(2)),
        (seven(), state_feedback(7)),
        (mixed(), state_feedback(3)),
        (mixed(), pd(3, FeedforwardCode::WithoutFriction)),
        (two(), pd(2, FeedforwardCode::None)),
    ] {
        judge(folder.path(), &case, &controller);
    }
}

#[test]
fn c_has_the_controller_of_the_library() {
    if Command::new("cc").arg("--version").output().is_err() {
        sprung_testing::skipped("cc", "there is no compiler cc");
        return;
    }
    let strict = "-std=c99 -O2 -Wall -Wextra -Werror -Wconversion -pedantic -o robot_test";
    for_controllers(|folder, case, controller| {
        write(folder, case, Format::C, controller);
        let passes = |more: &str| {
            let (ok, text) = run(
                folder,
                "cc",
                &format!("{strict} {more} robot.c robot_test.c -lm"),
            );
            assert!(ok, "{text}");
            let (ok, text) = run(folder, "./robot_test", "");
            println!("{more} {text}");
            ok && text.contains("PASS")
        };
        for more in ["", "-DSPRUNG_FLOAT", "-DSPRUNG_NO_CLOCK"] {
            assert!(passes(more), "{more}");
        }
        // Wrong numbers are seen.
        let code = std::fs::read_to_string(folder.join("robot.c")).unwrap();
        for (right, wrong) in [
            ("sum += gain[i][k]", "sum += R(1.001) * gain[i][k]"),
            ("tau_nm[i] += kp[i]", "tau_nm[i] += R(1.001) * kp[i]"),
            ("velocities[i] *= ", "velocities[i] *= R(1.001) * "),
            ("shaped[i] += ", "shaped[i] += R(1.001) * "),
            (" > limit ? limit", " > limit ? R(1.001) * limit"),
        ] {
            let has_limits = controller
                .torque_limits
                .iter()
                .all(|limit| limit.is_finite());
            if code.contains(right) && (has_limits || !right.contains("limit")) {
                std::fs::write(folder.join("robot.c"), code.replacen(right, wrong, 1)).unwrap();
                assert!(!passes(""), "{right}");
            }
        }
    });
}

#[test]
fn rust_has_the_controller_of_the_library_and_needs_no_standard_library() {
    for_controllers(|folder, case, controller| {
        write(folder, case, Format::Rust, controller);
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
fn controllers_that_do_not_fit_are_refused() {
    let case = mixed();
    let good = state_feedback(3);
    let change = |change: fn(&mut ControllerCode)| {
        let mut controller = good.clone();
        change(&mut controller);
        let request = Request {
            controller: Some(&controller),
            ..request(&case, Format::C, Form::Flexible)
        };
        export(&request)
    };
    assert!(change(|_| {}).is_ok());
    for (wrong, word) in [
        (change(|own| own.period = 0.0), "period"),
        (change(|own| own.period = f64::NAN), "period"),
        (change(|own| own.velocity_window = [1, 32]), "window"),
        (change(|own| own.torque_limits[1] = 0.0), "limit"),
        (change(|own| own.torque_limits[1] = f64::NAN), "limit"),
        (change(|own| own.torque_limits.truncate(2)), "limits"),
        (change(|own| own.shaper[0].weight = f64::NAN), "shaper"),
        (
            change(|own| {
                own.feedback = FeedbackCode::State {
                    gain: vec![vec![0.0; 12]; 2],
                }
            }),
            "rows",
        ),
        (
            change(|own| {
                own.feedback = FeedbackCode::State {
                    gain: vec![vec![0.0; 11]; 3],
                }
            }),
            "gains",
        ),
        (
            change(|own| {
                own.feedforward = FeedforwardCode::WithFriction {
                    velocity_scales: vec![0.1, -0.1, 0.1],
                };
            }),
            "scale",
        ),
    ] {
        match wrong {
            Err(ExportError::Controller { what }) => assert!(what.contains(word), "{what}"),
            other => panic!("{word}: {other:?}"),
        }
    }
    let long = change(|own| own.shaper[0].delay = usize::MAX);
    assert!(
        matches!(long, Err(ExportError::TooLarge { .. })),
        "{long:?}"
    );
}
