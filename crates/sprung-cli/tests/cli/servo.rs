//! A position servo that logs targets and positions, as in `examples/servo-pendulum`.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::common::{Case, f64_of, list_of};

const EXPERIMENT: &str = include_str!("../../../../examples/servo-pendulum/experiment.toml");
const TRUTH: &str = include_str!("../../../../examples/servo-pendulum/truth.toml");

/// The example without its logs.
fn example() -> Case {
    Case::of(&[("experiment.toml", EXPERIMENT), ("truth.toml", TRUTH)])
}

/// The example with simulated logs.
fn recorded(case: Case, more: &[&str]) -> Case {
    case.run("simulate", &[&["--quiet"][..], more].concat())
        .ends(0);
    case
}

/// Runs a verb on the example; returns the exit code, and its JSON or its error.
fn run(case: &Case, verb: &str, more: &[&str]) -> (i32, Value) {
    let output = case.run(verb, &[&["--json"][..], more].concat());
    let text = if output.out.is_empty() {
        output.err
    } else {
        output.out
    };
    let json = serde_json::from_str(&text).unwrap_or(Value::String(text));
    (output.code.unwrap(), json)
}

fn parameter<'a>(json: &'a Value, name: &str) -> &'a Value {
    let all = list_of(&json["parameters"]);
    all.iter()
        .find(|parameter| parameter["name"] == name)
        .unwrap()
}

#[test]
fn friction_under_load_is_identified_from_two_known_masses() {
    let case = recorded(example(), &[]);
    let (code, expected) = run(&case, "check", &[]);
    assert_eq!(code, 0, "{expected}");
    let least = parameter(&expected, "servo.armature")["least_error"].as_f64();
    // The true value is 0.026.
    assert!(least.unwrap() < 0.001, "{least:?}");

    let (code, found) = run(&case, "identify", &[]);
    assert_eq!(code, 0, "{found}");
    let truth: BTreeMap<String, f64> = toml::from_str(TRUTH).unwrap();
    for name in [
        "torque_per_volt",
        "back_emf",
        "armature",
        "viscous",
        "coulomb",
        "load_motor",
        "load_external",
    ] {
        let name = format!("servo.{name}");
        let parameter = parameter(&found, &name);
        let (value, error) = (
            f64_of(&parameter["value"]),
            f64_of(&parameter["standard_error"]),
        );
        let difference = value - truth[&name];
        // Six seeds have errors of at most 3.4 %.
        assert!(difference.abs() < 0.05 * truth[&name], "{name}: {value}");
        assert!(difference.abs() < 4.0 * error, "{name}: {value} ± {error}");
    }
    let ratio = f64_of(&found["fit"]["position_rms_over_noise"]);
    assert!((0.8..1.2).contains(&ratio), "{ratio}");
    for file in ["servo.json", "parameters.csv", "report.html"] {
        assert!(case.path("sprung-out").join(file).exists(), "{file}");
    }
    // Another number of threads gives the same bits.
    let (_, again) = run(&case, "identify", &["--threads", "1"]);
    assert_eq!(found["parameters"], again["parameters"]);

    case.run("validate", &[])
        .ends(2)
        .tells(&["servo is a position servo, and validate does not work with it"]);
}

#[test]
fn without_a_known_load_only_ratios_are_told() {
    let short = ["--set", "simulate.duration_s=12.0"];
    let case = example()
        .replace("nominal = {", "# nominal = {")
        .replace(", payload = { mass_kg = 1.0, com_m = [0.2, 0, 0] }", "")
        .replace(", payload = { mass_kg = 3.0, com_m = [0.2, 0, 0] }", "");
    let (code, found) = run(&recorded(case, &short), "check", &[]);
    assert_eq!(code, 0, "{found}");
    assert_eq!(found["findings"][0]["code"], "servo-without-scale");
    assert_eq!(parameter(&found, "servo.torque_per_volt")["fixed"], true);
    assert_eq!(parameter(&found, "servo.coulomb")["unit"], "V");
}

#[test]
fn faulty_logs_are_refused_with_the_cause() {
    let short = ["--set", "simulate.duration_s=12.0"];
    let case = recorded(example(), &short);
    let light = case.path("light.csv");
    let text = std::fs::read_to_string(&light).unwrap();
    let with = |change: fn(usize, &mut Vec<String>)| {
        let lines = text.lines().enumerate().map(|(line, row)| {
            let mut cells: Vec<String> = row.split(',').map(str::to_owned).collect();
            if line > 0 {
                change(line, &mut cells);
            }
            cells.join(",")
        });
        std::fs::write(&light, lines.collect::<Vec<_>>().join("\n")).unwrap();
        run(&case, "identify", &[])
    };
    let says = |(code, error): (i32, Value), expected_code: i32, fragment: &str| {
        assert_eq!(code, expected_code, "{error}");
        assert!(error.to_string().contains(fragment), "{error}");
    };
    // Columns: time, position, target, switch.
    says(
        with(|line, cells| {
            if line == 100 {
                "0.5".clone_into(&mut cells[3]);
            }
        }),
        3,
        "it must be 1 while the drive is on",
    );
    says(
        with(|_, cells| "0.1".clone_into(&mut cells[1])),
        3,
        "stays within a few steps of its sensor",
    );
}

#[test]
fn a_wrong_drive_law_is_told() {
    let short = ["--set", "simulate.duration_s=15.0"];
    let case = recorded(example(), &short);
    let supply = ["--set", "robot.joint.servo.servo.duty_limit=0.05"];
    let (code, found) = run(&case, "identify", &supply);
    assert!(code == 1 || code == 3, "{code}: {found}");
}
