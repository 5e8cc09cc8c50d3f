//! `sprung watch`: contacts, changes and blind sensors of the demo.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::Value;

use crate::common::{Case, sprung, stderr, stdout};

/// The demo, identified by least squares.
fn identified() -> Case {
    identified_as(Case::new())
}

fn identified_as(case: Case) -> Case {
    record(
        &case,
        "healthy.csv",
        &["simulate.duration_s=20.0", "simulate.seed=3"],
    );
    let case = case.replace("identification.csv", "healthy.csv");
    let output = case.identify(&["-q"]);
    assert!(output.status.success(), "{}", stderr(&output));
    case
}

/// Records a log of the twin with some settings.
fn record(case: &Case, log: &str, settings: &[&str]) {
    let words = settings.iter().flat_map(|setting| ["--set", setting]);
    case.record(log, &words.collect::<Vec<_>>());
}

/// Watches logs; returns the output and `watch.json`.
fn watched(case: &Case, logs: &[&str], more: &[&str]) -> (Output, Value) {
    let mut args = vec![
        "watch".to_owned(),
        case.path("experiment.toml").display().to_string(),
    ];
    for log in logs {
        args.extend(["--log".to_owned(), case.path(log).display().to_string()]);
    }
    args.extend(more.iter().map(|word| (*word).to_owned()));
    let output = sprung(&args.iter().map(String::as_str).collect::<Vec<_>>());
    let text = std::fs::read_to_string(case.path("sprung-out/watch.json"));
    let json = text.map_or(Value::Null, |text| serde_json::from_str(&text).unwrap());
    (output, json)
}

fn codes(watch: &Value) -> Vec<&str> {
    let events = watch["events"].as_array().unwrap();
    events
        .iter()
        .map(|event| event["finding"]["code"].as_str().unwrap())
        .collect()
}

const LONG: &str = "simulate.duration_s=20.0";

#[test]
fn contacts_have_time_joint_and_torque_and_a_healthy_log_has_none() {
    let case = identified();
    record(&case, "quiet.csv", &[LONG, "simulate.seed=4"]);
    let touched = [
        LONG,
        "simulate.seed=5",
        "simulate.contact_torque_nm=[0.0,-0.06]",
        "simulate.contact_s=[[5.0,5.4],[12.0,12.4]]",
    ];
    record(&case, "touched.csv", &touched);
    let (output, watch) = watched(&case, &["quiet.csv"], &[]);
    assert_eq!(output.status.code(), Some(0), "{}", stdout(&output));
    assert_eq!(codes(&watch), <[&str; 0]>::default());
    let (output, watch) = watched(&case, &["touched.csv"], &[]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert_eq!(codes(&watch), ["contact"; 2]);
    for (event, begin) in watch["events"].as_array().unwrap().iter().zip([5.0, 12.0]) {
        let number = |key: &str| event[key].as_f64().unwrap();
        assert_eq!(event["joint"], "joint2");
        assert!(
            (0.0..0.08).contains(&(number("begins_s") - begin)),
            "{event}"
        );
        assert!((-0.07..-0.05).contains(&number("torque_nm")), "{event}");
    }
    let text = stdout(&output);
    assert!(
        text.contains("joint2: from 5.0") && text.contains("(contact)"),
        "{text}"
    );
    let html = std::fs::read_to_string(case.path("sprung-out/watch.html")).unwrap();
    assert!(html.contains("something happened"));
}

#[test]
fn changes_of_friction_and_stiffness_are_named_with_their_size() {
    let case = identified();
    let truth = std::fs::read_to_string(case.path("truth.toml")).unwrap();
    let changed = |from: &str, to: &str| truth.replace(from, to);
    let friction = changed("8.435283", "9.278811").replace("1.360210", "1.496231");
    for (text, code, parameter) in [
        (friction, "friction-changed", "joint1.motor_viscous"),
        (changed("4.212811", "4.0022"), "stiffness-changed", "→ 4.0"),
    ] {
        std::fs::write(case.path("worn.toml"), text).unwrap();
        let log = format!("{code}.csv");
        let words = [
            LONG,
            "simulate.seed=6",
            "simulate.parameters=\"worn.toml\"",
            // Incremental encoders have another zero after each start.
            "simulate.motor_encoder_offset_rad=[0.0,0.001]",
        ];
        record(&case, &log, &words);
        let (_, watch) = watched(&case, &[&log], &[]);
        assert_eq!(codes(&watch), [code], "{watch:#}");
        let finding = &watch["events"][0]["finding"];
        assert!(
            finding["text"].as_str().unwrap().contains(parameter),
            "{finding}"
        );
    }
}

#[test]
fn a_frozen_encoder_is_blind_and_no_contact() {
    let case = identified();
    record(&case, "frozen.csv", &[LONG, "simulate.seed=4"]);
    let text = std::fs::read_to_string(case.path("frozen.csv")).unwrap();
    let mut kept = String::new();
    let lines: Vec<String> = (text.lines().enumerate())
        .map(|(k, line)| {
            let mut fields: Vec<&str> = line.split(',').collect();
            if (8000..10_000).contains(&k) {
                fields[1] = &kept;
                return fields.join(",");
            }
            if k == 7999 {
                kept = fields[1].to_owned();
            }
            line.to_owned()
        })
        .collect();
    std::fs::write(case.path("frozen.csv"), lines.join("\n")).unwrap();
    let (_, watch) = watched(&case, &["frozen.csv"], &[]);
    assert_eq!(codes(&watch), ["sensor-shows-nothing"], "{watch:#}");
    let event = &watch["events"][0];
    assert!(
        event["finding"]["text"]
            .as_str()
            .unwrap()
            .contains("q1_rad"),
        "{event}"
    );
    assert!(
        (event["begins_s"].as_f64().unwrap() - 8.0).abs() < 0.05,
        "{event}"
    );
    assert!(watch["logs"][0]["blind_s"].as_f64().unwrap() > 1.9);
}

#[test]
fn a_saturated_torque_and_a_gap_are_blind() {
    let case = identified();
    record(&case, "whole.csv", &[LONG, "simulate.seed=4"]);
    let text = std::fs::read_to_string(case.path("whole.csv")).unwrap();
    let torque = |line: &str| line.split(',').nth(5).unwrap().parse::<f64>().ok();
    let largest = text.lines().filter_map(torque).fold(0.0, f64::max);
    let clipped = |line: &str| match torque(line) {
        Some(value) => {
            let fields: Vec<&str> = line.split(',').collect();
            let limited = value.clamp(-0.35 * largest, 0.35 * largest).to_string();
            [&fields[..5], &[&limited], &fields[6..]].concat().join(",")
        }
        None => line.to_owned(),
    };
    let saturated: Vec<String> = text.lines().map(clipped).collect();
    let (before, after) = (text.lines().take(8000), text.lines().skip(9000));
    let broken: Vec<String> = before.chain(after).map(str::to_owned).collect();
    for (log, lines, part) in [
        ("saturated.csv", saturated, "tau1_nm"),
        ("broken.csv", broken, "no samples from 8.00 to 9.00 s"),
    ] {
        std::fs::write(case.path(log), lines.join("\n")).unwrap();
        let (_, watch) = watched(&case, &[log], &[]);
        let codes = codes(&watch);
        assert!(!codes.is_empty(), "{log}");
        assert!(
            codes.iter().all(|code| *code == "sensor-shows-nothing"),
            "{watch:#}"
        );
        let text = watch["events"][0]["finding"]["text"].as_str().unwrap();
        assert!(text.contains(part), "{text}");
    }
}

#[test]
fn unusable_values_are_refused_unless_they_are_accepted_and_the_code_says_so() {
    let case = identified();
    let file = case.path("sprung-out/identification.json");
    let text = std::fs::read_to_string(&file).unwrap();
    let found: Value = serde_json::from_str(&text).unwrap();
    let verdict = found["results"][0]["verdict"].as_str().unwrap();
    let [from, to] = [verdict, "unusable"].map(|verdict| format!("\"verdict\": \"{verdict}\""));
    std::fs::write(&file, text.replacen(&from, &to, 1)).unwrap();
    let (output, _) = watched(&case, &["healthy.csv"], &[]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    let told = "the verdict on the result of least-squares is unusable";
    assert!(stderr(&output).contains(told), "{}", stderr(&output));
    let (output, watch) = watched(&case, &["healthy.csv"], &["--accept-unusable"]);
    assert_eq!(watch["accepted_unusable"], true, "{}", stderr(&output));
    let output = exported(&case, "c", &case.path("sprung-out/watch.json"));
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let header = std::fs::read_to_string(case.path("code/robot.h")).unwrap();
    assert!(header.contains("unusable"), "{header}");
}

/// Returns the first block of a language in the page about watching.
fn block_of_the_page(language: &str) -> String {
    let page = include_str!("../../../../docs/how-to/watch.md");
    let begin = format!("```{language}\n");
    let (_, block) = page.split_once(&begin).unwrap();
    block.split_once("```").unwrap().0.to_owned()
}

#[test]
fn the_examples_of_the_page_compile_with_the_code() {
    let case = identified();
    watched(&case, &[], &[]);
    let experiment = case.path("experiment.toml").display().to_string();
    let (watch, out) = (case.path("sprung-out/watch.json"), case.path("code"));
    let (watch, out) = (watch.display().to_string(), out.display().to_string());
    let words = [
        "export",
        &experiment,
        "--format",
        "c",
        "--watch",
        &watch,
        "--out",
        &out,
    ];
    let output = sprung(&words);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let header = std::fs::read_to_string(case.path("code/robot.h")).unwrap();
    let prefix = header
        .split("struct ")
        .nth(1)
        .unwrap()
        .split("_chain")
        .next()
        .unwrap()
        .to_owned();
    for (language, compiler, file) in [("c", "cc", "example.c"), ("cpp", "c++", "example.cpp")] {
        let text = block_of_the_page(language)
            .replace("my_arm", &prefix)
            .replace("MY_ARM", &prefix.to_uppercase());
        std::fs::write(case.path("code").join(file), text).unwrap();
        let built = Command::new(compiler)
            .args(["-Wall", "-Wextra", "-Werror", "-c", file, "-o", "example.o"])
            .current_dir(case.path("code"))
            .output()
            .unwrap();
        assert!(built.status.success(), "{}", stderr(&built));
    }
}

/// Watches bytes on standard input.
fn piped(case: &Case, bytes: &[u8]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_sprung"))
        .args(["watch", "--log", "-"])
        .arg(case.path("experiment.toml"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    // A program that refuses its input closes it.
    let _ = input.write_all(bytes);
    drop(input);
    child.wait_with_output().unwrap()
}

#[test]
fn standard_input_folders_and_growing_files_have_the_events_of_the_file() {
    let case = identified();
    let touched = [
        LONG,
        "simulate.seed=5",
        "simulate.contact_torque_nm=[0.6,0.0]",
        "simulate.contact_s=[[5.0,5.4]]",
    ];
    record(&case, "touched.csv", &touched);
    let bytes = std::fs::read(case.path("touched.csv")).unwrap();
    let (output, watch) = watched(&case, &["touched.csv"], &[]);
    assert_eq!(codes(&watch), ["contact"], "{}", stderr(&output));
    let line = stdout(&output).lines().next().unwrap().to_owned();
    let event = line.split_once("joint1").unwrap().1.to_owned();
    let piped_output = piped(&case, &bytes);
    assert_eq!(
        piped_output.status.code(),
        Some(1),
        "{}",
        stderr(&piped_output)
    );
    assert!(
        stdout(&piped_output).contains(&event),
        "{}",
        stdout(&piped_output)
    );

    std::fs::create_dir(case.path("logs")).unwrap();
    std::fs::copy(case.path("touched.csv"), case.path("logs/b.csv")).unwrap();
    std::fs::copy(case.path("healthy.csv"), case.path("logs/a.csv")).unwrap();
    let (_, watch) = watched(&case, &["logs"], &[]);
    assert_eq!(codes(&watch), ["contact"]);
    let logs = watch["logs"].as_array().unwrap();
    assert!(logs[0]["log"].as_str().unwrap().ends_with("a.csv"));

    let growing = case.path("growing.csv");
    let (first, second) = bytes.split_at(bytes.len() / 3);
    std::fs::write(&growing, first).unwrap();
    let (second, path) = (second.to_vec(), growing.clone());
    let writer = std::thread::spawn(move || {
        std::thread::sleep(std::time::Duration::from_millis(500));
        let mut file = std::fs::OpenOptions::new().append(true).open(path).unwrap();
        file.write_all(&second).unwrap();
    });
    let (_, watch) = watched(&case, &["growing.csv"], &["--follow", "3"]);
    writer.join().unwrap();
    assert_eq!(codes(&watch), ["contact"]);
}

#[test]
fn what_cannot_be_watched_is_refused() {
    let case = identified();
    let refused = |logs: &[&str], more: &[&str], code: i32, part: &str| {
        let (output, _) = watched(&case, logs, more);
        assert_eq!(output.status.code(), Some(code), "{}", stderr(&output));
        assert!(stderr(&output).contains(part), "{}", stderr(&output));
    };
    refused(&["missing.csv"], &[], 4, "missing.csv");
    refused(
        &["healthy.csv"],
        &["--false-alarms-per-h", "0"],
        2,
        "positive",
    );
    record(&case, "slow.csv", &[LONG, "simulate.period_s=0.002"]);
    refused(&["slow.csv"], &[], 3, "500 samples per second");
    std::fs::create_dir(case.path("empty")).unwrap();
    refused(&["empty"], &[], 4, "has no files");
    let output = piped(&case, b"PK\x03\x04 no stream");
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
}

/// Exports code with a watch.
fn exported(case: &Case, format: &str, watch: &Path) -> Output {
    let [experiment, watch, out] = [&case.path("experiment.toml"), watch, &case.path("code")]
        .map(|path| path.display().to_string());
    let words = ["export", &experiment, "--format", format, "--watch", &watch];
    sprung(&[&words[..], &["--out", &out, "--force"]].concat())
}

/// Compiles exported Rust and runs its test.
#[track_caller]
fn assert_self_test(case: &Case) {
    let built = Command::new("rustc")
        .args(["--edition", "2024", "--test", "robot.rs", "-o", "robot"])
        .args(["-D", "warnings"])
        .current_dir(case.path("code"))
        .output()
        .unwrap();
    assert!(built.status.success(), "{}", stderr(&built));
    let run = Command::new(case.path("code/robot")).output().unwrap();
    assert!(run.status.success(), "{}", stdout(&run));
}

#[test]
fn torque_sensors_show_contacts_and_the_code_reads_them() {
    let torques = "motor_torque_nm    = [\"tau1_nm\", \"tau2_nm\"]";
    let sensors = format!("{torques}\njoint_torque_nm = [\"s1_nm\", \"s2_nm\"]");
    let case = Case::new().replace(torques, &sensors);
    let noise = "torque_noise_nm = [0.02, 0.005]";
    let of_sensors = format!("{noise}\njoint_torque_noise_nm = [0.01, 0.002]");
    let case = identified_as(case.replace(noise, &of_sensors));
    let touched = [
        LONG,
        "simulate.seed=5",
        "simulate.contact_torque_nm=[0.0,-0.06]",
        "simulate.contact_s=[[5.0,5.4]]",
    ];
    record(&case, "touched.csv", &touched);
    let (output, watch) = watched(&case, &["touched.csv"], &[]);
    assert_eq!(codes(&watch), ["contact"], "{}", stderr(&output));
    assert_eq!(watch["events"][0]["joint"], "joint2");
    let watch = case.path("sprung-out/watch.json");
    let output = exported(&case, "rust", &watch);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let code = std::fs::read_to_string(case.path("code/robot.rs")).unwrap();
    assert!(code.contains("sensor_nm: &Vector"));
    assert_self_test(&case);
}

#[test]
fn the_observer_of_the_code_has_the_torques_of_the_library() {
    let case = identified();
    let (output, _) = watched(&case, &[], &[]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(
        stdout(&output).contains("No log was watched"),
        "{}",
        stdout(&output)
    );
    let export = |format: &str, watch: &Path| exported(&case, format, watch);
    let watch = case.path("sprung-out/watch.json");
    let output = export("rust", &watch);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stdout(&output).contains("observer"), "{}", stdout(&output));
    assert_self_test(&case);
    let refused = export("urdf", &watch);
    assert_eq!(refused.status.code(), Some(2), "{}", stderr(&refused));
    assert!(stderr(&refused).contains("no code"), "{}", stderr(&refused));
    let text = std::fs::read_to_string(&watch).unwrap();
    for (from, to, part) in [
        (
            "\"period_s\": 0.001",
            "\"period_s\": 1e-300",
            "settle in more than",
        ),
        (
            "\"period_s\": 0.001",
            "\"period_s\": -1.0",
            "not a positive number",
        ),
        (
            "\"robot\": \"Quanser",
            "\"robot\": \"Other",
            "the watch is of",
        ),
    ] {
        assert!(text.contains(from), "{text}");
        let wrong = case.path("wrong.json");
        std::fs::write(&wrong, text.replace(from, to)).unwrap();
        let refused = export("c", &wrong);
        assert_eq!(refused.status.code(), Some(2), "{}", stderr(&refused));
        assert!(stderr(&refused).contains(part), "{}", stderr(&refused));
    }
    let refused = export("c", &case.path("truth.toml"));
    assert_eq!(refused.status.code(), Some(2), "{}", stderr(&refused));
    assert!(
        stderr(&refused).contains("no watch.json"),
        "{}",
        stderr(&refused)
    );
}
