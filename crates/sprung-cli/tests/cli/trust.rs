//! Guarantees to users: inputs are not overwritten, tables can be read, and sprung reports doubtful loops and delays.

use serde_json::Value;

use crate::common::{
    COUNT, Case, Ran, contains, demo, f64_of, list_of, messages, program, sprung, str_of,
};

const TIME: usize = 0;
const Q1: usize = 1;
const PHI1: usize = 3;
const PHI2: usize = 4;
const TAU1: usize = 5;

/// How `sprung validate` ended, its run and its messages.
struct Validated {
    code: Option<i32>,
    run: Value,
    message: String,
}

/// Runs `sprung validate` on the case's own log.
fn validate(case: &Case, parameters: &str, more: &[&str]) -> Validated {
    let experiment = case.at("experiment.toml");
    let parameters = case.at(parameters);
    let mut args = vec![
        "validate",
        &experiment,
        "--parameters",
        &parameters,
        "--set",
        "validate=[{name=\"direct\"}]",
        "--json",
        "-v",
    ];
    args.extend(more);
    let output = sprung(&args);
    let json: Value = serde_json::from_str(&output.out).unwrap_or_default();
    Validated {
        code: output.code,
        run: json["runs"][0].clone(),
        message: output.err,
    }
}

#[test]
fn no_command_writes_over_what_it_reads() {
    let case = Case::new();
    std::fs::rename(case.path("identification.csv"), case.path("fit.csv")).unwrap();
    let before = std::fs::read(case.path("fit.csv")).unwrap();
    let folder = case.at("");
    let out = &folder;
    case.identify(&["--set", "log.file=fit.csv", "--out", out])
        .ends(2)
        .tells(&["fit.csv is an input and would be overwritten"]);
    sprung(&["simulate", out, "--out", out, "--set", "log.file=fit.csv"]).ends(2);
    assert_eq!(std::fs::read(case.path("fit.csv")).unwrap(), before);
    assert!(!case.path("identification.json").exists());
}

#[test]
fn demo_keeps_an_edited_experiment() {
    let case = Case::new().replace("position_cutoff_hz = \"auto\"", "position_cutoff_hz = 12.0");
    let out = case.path("");
    sprung(&["demo", "-q", "--out", out.to_str().unwrap()])
        .ends(2)
        .tells(&["holds another experiment.toml"]);
    contains(
        &case.read("experiment.toml"),
        &["position_cutoff_hz = 12.0"],
    );
    // The demo may overwrite its own files, also with another seed.
    let case = Case::as_shipped();
    let out = case.at("");
    sprung(&["demo", "-q", "--seed", "3", "--out", &out]).ends(0);
}

#[test]
fn every_table_has_as_many_cells_as_its_header() {
    let out = demo().join("sprung-out");
    for file in ["parameters.csv", "trace.csv", "fit.csv", "signals.csv"] {
        let text = std::fs::read_to_string(out.join(file)).unwrap();
        // Quoted labels contain commas; no cell of the demo contains a quote.
        let width = |line: &str| {
            let plain: String = line.split('"').step_by(2).collect();
            plain.split(',').count()
        };
        let header = width(text.lines().next().unwrap());
        assert!(text.lines().all(|line| width(line) == header), "{file}");
    }
    let signals = std::fs::read_to_string(out.join("signals.csv")).unwrap();
    assert!(signals.contains("set to 0)\""), "no label was quoted");
}

#[test]
fn lost_output_is_an_error() {
    let full = std::fs::File::options().write(true).open("/dev/full");
    let Ok(full) = full else {
        sprung_testing::skipped("full", "no /dev/full on this machine");
        return;
    };
    Ran::of(program().arg("schema").stdout(full))
        .ends(4)
        .tells(&["cannot write to stdout"]);
}

#[test]
fn a_saturated_loop_validates_with_its_true_parameters() {
    let case = Case::new().replace(
        "amplifier_gain_a_per_v = 0.5\n",
        "amplifier_gain_a_per_v = 0.5\namplifier_limit_v = 40.0\n",
    );
    case.run("simulate", &["-q", "--out", &case.at("twin")])
        .ends(0);
    let log = format!(
        "log.file={}",
        case.path("twin/identification.csv").display()
    );
    let Validated { code, run, message } = validate(&case, "truth.toml", &["--set", &log]);
    assert_eq!(code, Some(0), "{message}");
    let e = &run["sets"][0]["e_rms"];
    // The positions are rounded to counts. The logged torque has noise, and the loop multiplies the rounding by 50
    // N·m/rad; a root mean square of n samples has the relative standard error √(1/2n).
    assert!(f64_of(&e["q_rad"]["joint1"]) < COUNT, "{e}");
    let expected = f64::hypot(0.02, 50.0 * COUNT / 12_f64.sqrt());
    let limit = expected * (1.0 + 4.0 / 20_000_f64.sqrt());
    assert!(f64_of(&e["tau_nm"]["joint1"]) < limit, "{e}");
    // The limit has an effect: without it the same log does not fit.
    let off = [
        "--set",
        &log,
        "--set",
        "robot.joint.joint1.amplifier_limit_v=1000",
    ];
    let run = validate(&case, "truth.toml", &off).run;
    let e = &run["sets"][0]["e_rms"];
    assert!(f64_of(&e["q_rad"]["joint1"]) > 10.0 * COUNT, "{e}");
}

#[test]
fn columns_of_a_validation_log_are_checked() {
    let Validated { code, message, .. } =
        validate(&Case::new().column(Q1, |_| 0.1), "truth.toml", &[]);
    assert_eq!(code, Some(3), "{message}");
    contains(&message, &["column \\\"q1_rad\\\" never changes"]);
    let case = Case::new().columns(&[1, 2, 3, 4], f64::to_degrees);
    let run = validate(&case, "truth.toml", &[]).run;
    assert_eq!(run["findings"][0]["code"], "looks-like-degrees");
}

#[test]
fn a_loop_that_is_not_that_of_the_log_is_said() {
    let late = Case::new().column(TIME, |time| time + 2.5);
    let run = validate(&late, "truth.toml", &[]).run;
    let finding = &run["sets"][0]["findings"][0];
    assert_eq!(finding["code"], "loop-moves-otherwise", "{finding}");
    contains(
        str_of(&finding["text"]),
        &["its clock differs from the reference's"],
    );
    let run = validate(&Case::new(), "truth.toml", &[]).run;
    assert_eq!(list_of(&run["sets"][0]["findings"]).len(), 0);
}

#[test]
fn times_with_few_digits_do_not_bias() {
    // The sampling rate is 960 Hz, and the times have four decimals.
    let case = Case::new().replace("period_s   = 0.001", "period_s = 0.0010416666666666667");
    let out = case.path("twin");
    case.run("simulate", &["-q", "--out", out.to_str().unwrap()])
        .ends(0);
    std::fs::copy(
        out.join("identification.csv"),
        case.path("identification.csv"),
    )
    .unwrap();
    let inertia = |case: &Case| {
        let json = case.identify(&["--json"]).json();
        f64_of(&json["results"][0]["parameters"][0]["value"])
    };
    let exact = inertia(&case);
    let rounded = case.column(TIME, |time| (time * 1e4).round() / 1e4);
    let found = inertia(&rounded);
    // The period is the mean of 256 steps, and the first and the last stamp are rounded by up to 0.05 ms each. An
    // inertia is proportional to the square of the period.
    let period_error = 2.0 * 0.05e-3 / (256.0 / 960.0);
    let error = (found / exact - 1.0).abs();
    assert!(error < 2.0 * period_error, "{found} {exact}");
    let Validated { code, run, message } = validate(&rounded, "truth.toml", &[]);
    assert_eq!(code, Some(0), "{message}");
    let e = &run["sets"][0]["e_rms"]["q_rad"];
    // After 10 s the reference is late by this part, at velocities of up to 3° 2π (1 + 0.5 + 0.2) Hz.
    let velocity = 3_f64.to_radians() * std::f64::consts::TAU * 1.7;
    let limit = period_error * 10.0 * velocity;
    assert!(f64_of(&e["joint1"]) < limit, "{e}");
}

#[test]
fn delays_that_the_log_does_not_show_are_zero() {
    let estimate = ["--set", "log.delay_s.q1_rad=\"estimate\"", "-v"];
    // The robot rests for 40 s, so the excerpt contains no motion.
    let mut still = Vec::new();
    let case = Case::new().log(|row, cells| {
        if row == 1 {
            still.clone_from(cells);
        }
    });
    let text = case.read("identification.csv");
    let mut lines = text.lines();
    let mut padded = format!("{}\n", lines.next().unwrap());
    for k in 0..40_000 {
        still[TIME] = format!("{:.3}", f64::from(k) * 1e-3 - 40.0);
        padded.push_str(&still.join(","));
        padded.push('\n');
    }
    padded.extend(lines.map(|line| format!("{line}\n")));
    case.write("identification.csv", padded);
    let output = case.identify(&estimate);
    let zero = |case: &Case| {
        let json = case.json("sprung-out/identification.json");
        let delay = &json["log"]["delay_s"]["q1_rad"];
        assert_eq!(delay["value"], 0.0, "{delay}");
        assert!(delay["standard_error"].is_null(), "{delay}");
    };
    zero(&case);
    assert!(!output.err.contains("NaN"), "{}", output.err);
    // The torque has the wrong sign. No delay corrects this, and a finding names the cause.
    let go_on = ["--set", "identify.on_check_error=go-on"];
    let case = Case::new().column(TAU1, |x| -x);
    case.identify(&[&estimate[..], &go_on].concat())
        .ends(1)
        .tells(&["reversed-torque"]);
    zero(&case);
}

#[test]
fn the_late_channel_is_the_one_that_is_named() {
    // The dry friction of the first motor hides its delay: without a refinement it is known to 3 ms.
    for (column, name, late, within) in [
        (TAU1, "tau1_nm", 100, 1.5),
        (PHI2, "phi2_rad", 20, 1.5),
        (PHI1, "phi1_rad", 20, 3.0),
    ] {
        let case = Case::new().late(column, late);
        let message = case.identify(&["-v"]).err;
        let (_, rest) = message
            .split_once(&format!("\"{name}\" was recorded "))
            .unwrap_or_else(|| panic!("{message}"));
        let delay: f64 = rest.split(' ').next().unwrap().parse().unwrap();
        assert!((delay - late as f64).abs() < within, "{delay}");
    }
}

#[test]
fn damaged_curves_beside_an_identification_are_left_out() {
    let case = Case::new();
    case.identify(&["-q"]).ends(0);
    let fit = case.path("sprung-out/fit.csv");
    let text = std::fs::read_to_string(&fit).unwrap();
    let mut lines: Vec<&str> = text.lines().collect();
    lines.remove(7);
    for damaged in [
        lines.join("\n"),
        text.replacen(",0.001,", ",NaN,", 1),
        text[..text.len() / 2].to_owned(),
    ] {
        std::fs::write(&fit, damaged).unwrap();
        let Validated { code, message, .. } =
            validate(&case, "sprung-out/identification.json", &[]);
        assert_eq!(code, Some(0), "{message}");
    }
}

#[test]
fn settings_and_columns_that_cannot_be_meant() {
    let mut messages = messages("settings_and_columns_that_cannot_be_meant");
    let case = Case::new();
    for assignment in [
        "identify.filter_cutoff_rad_per_s=5000",
        "log.link_position_rad=[\"q1_rad\",\"q1_rad\"]",
        "validate=[{name=\"x\",log={sign={q11=-1}}}]",
    ] {
        messages.note(assignment, &case.refused(2, &["--set", assignment]));
    }
    let twice = Case::new()
        .cell(0, PHI1, "q1_rad")
        .replace("\"phi1_rad\"", "\"q2_rad\"")
        .replace("[\"q1_rad\", \"q2_rad\"]", "[\"q1_rad\", \"phi2_rad\"]")
        .replace("[\"q2_rad\", \"phi2_rad\"]", "[\"q2_rad\", \"tau2_nm\"]")
        .replace("[\"tau1_nm\", \"tau2_nm\"]", "[\"tau1_nm\", \"t_s\"]");
    messages.note("one name twice", &twice.refused(3, &[]));
    messages.compare();
}

#[test]
fn time_in_milliseconds() {
    let case = Case::new().column(TIME, |time| 1e3 * time);
    case.identify(&[])
        .tells(&["(time-unit); in the experiment file: [log] time_ms = \"t_s\""]);
    let case = case.replace("time_s             = \"t_s\"", "time_ms = \"t_s\"");
    let json = case.identify(&["--json"]).json();
    let period = f64_of(&json["log"]["period_s"]);
    assert!((period - 1e-3).abs() < 1e-12);
    assert_eq!(json["results"][0]["verdict"], "good");
}

#[test]
fn files_that_are_something_else() {
    let case = Case::new();
    sprung(&["identify", &case.at("identification.csv")])
        .ends(2)
        .tells(&["is a log, not an experiment file; give the experiment file"]);
    let text = case.read("identification.csv");
    let glued = text.replace(',', "/");
    case.write("identification.csv", glued);
    case.fails(3, &["has no column \"t_s\"; its columns are t_s/q1_rad"]);
    let fresh = Case::new();
    fresh
        .run("validate", &[])
        .ends(4)
        .tells(&["run sprung identify first"]);
}
