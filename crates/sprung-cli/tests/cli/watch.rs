//! `sprung watch`: contacts, changes and blind sensors of the demo.

use std::io::Write;
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::common::{Case, Ran, contains, each, f64_of, list_of, program, str_of};

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
    case.identify(&["-q"]).ends(0);
    case
}

/// Records a log of the twin with some settings.
fn record(case: &Case, log: &str, settings: &[&str]) {
    let words = settings.iter().flat_map(|setting| ["--set", setting]);
    case.record(log, &words.collect::<Vec<_>>());
}

/// Watches logs; returns the output and `watch.json`.
fn watched(case: &Case, logs: &[&str], more: &[&str]) -> (Ran, Value) {
    let logs: Vec<String> = logs.iter().map(|log| case.at(log)).collect();
    let mut args: Vec<&str> = logs.iter().flat_map(|log| ["--log", log]).collect();
    args.extend(more);
    let output = case.run("watch", &args);
    let text = std::fs::read_to_string(case.path("sprung-out/watch.json"));
    let json = text.map_or(Value::Null, |text| serde_json::from_str(&text).unwrap());
    (output, json)
}

fn codes(watch: &Value) -> Vec<&str> {
    let events = list_of(&watch["events"]);
    events
        .iter()
        .map(|event| str_of(&event["finding"]["code"]))
        .collect()
}

const WATCH: &str = "sprung-out/watch.json";

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
    output.ends(0);
    assert_eq!(codes(&watch), <[&str; 0]>::default());
    let (output, watch) = watched(&case, &["touched.csv"], &[]);
    output.ends(1);
    assert_eq!(codes(&watch), ["contact"; 2]);
    for (event, begin) in list_of(&watch["events"]).iter().zip([5.0, 12.0]) {
        let number = |key: &str| f64_of(&event[key]);
        assert_eq!(event["joint"], "joint2");
        assert!(
            (0.0..0.08).contains(&(number("begins_s") - begin)),
            "{event}"
        );
        assert!((-0.07..-0.05).contains(&number("torque_nm")), "{event}");
    }
    let text = &output.out;
    contains(text, &["joint2: from 5.0", "(contact)"]);
    contains(&case.read("sprung-out/watch.html"), &["something happened"]);
}

#[test]
fn changes_of_friction_and_stiffness_are_named_with_their_size() {
    let case = identified();
    let truth = case.read("truth.toml");
    let changed = |from: &str, to: &str| truth.replace(from, to);
    let friction = changed("8.435283", "9.278811").replace("1.360210", "1.496231");
    for (text, code, parameter) in [
        (friction, "friction-changed", "joint1.motor_viscous"),
        (changed("4.212811", "4.0022"), "stiffness-changed", "→ 4.0"),
    ] {
        case.write("worn.toml", text);
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
        contains(str_of(&finding["text"]), &[parameter]);
    }
}

#[test]
fn a_frozen_encoder_is_blind_and_no_contact() {
    let case = identified();
    record(&case, "frozen.csv", &[LONG, "simulate.seed=4"]);
    let text = case.read("frozen.csv");
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
    case.write("frozen.csv", lines.join("\n"));
    let (_, watch) = watched(&case, &["frozen.csv"], &[]);
    assert_eq!(codes(&watch), ["sensor-shows-nothing"], "{watch:#}");
    let event = &watch["events"][0];
    contains(str_of(&event["finding"]["text"]), &["q1_rad"]);
    assert!((f64_of(&event["begins_s"]) - 8.0).abs() < 0.05, "{event}");
    assert!(f64_of(&watch["logs"][0]["blind_s"]) > 1.9);
}

#[test]
fn a_saturated_torque_and_a_gap_are_blind() {
    let case = identified();
    record(&case, "whole.csv", &[LONG, "simulate.seed=4"]);
    let text = case.read("whole.csv");
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
        case.write(log, lines.join("\n"));
        let (_, watch) = watched(&case, &[log], &[]);
        let codes = codes(&watch);
        assert!(!codes.is_empty(), "{log}");
        assert!(
            codes.iter().all(|code| *code == "sensor-shows-nothing"),
            "{watch:#}"
        );
        contains(str_of(&watch["events"][0]["finding"]["text"]), &[part]);
    }
}

#[test]
fn unusable_values_are_refused_unless_they_are_accepted_and_the_code_says_so() {
    let case = identified();
    let file = "sprung-out/identification.json";
    let (text, found) = (case.read(file), case.json(file));
    let verdict = str_of(&found["results"][0]["verdict"]);
    let [from, to] = [verdict, "unusable"].map(|verdict| format!("\"verdict\": \"{verdict}\""));
    case.write(file, text.replacen(&from, &to, 1));
    let (output, _) = watched(&case, &["healthy.csv"], &[]);
    let told = "the verdict on the result of least-squares is unusable";
    output.ends(2).tells(&[told]);
    let (output, watch) = watched(&case, &["healthy.csv"], &["--accept-unusable"]);
    assert_eq!(watch["accepted_unusable"], true, "{}", output.err);
    exported(&case, "c", WATCH).ends(1);
    contains(&case.read("code/robot.h"), &["unusable"]);
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
    exported(&case, "c", WATCH).ends(0);
    let header = case.read("code/robot.h");
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
        case.write(&format!("code/{file}"), text);
        let built = Command::new(compiler)
            .args(["-Wall", "-Wextra", "-Werror", "-c", file, "-o", "example.o"])
            .current_dir(case.path("code"))
            .output();
        Ran::from(&built.unwrap()).ends(0);
    }
}

/// Watches bytes on standard input.
fn piped(case: &Case, bytes: &[u8]) -> Ran {
    let mut child = program()
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
    Ran::from(&child.wait_with_output().unwrap())
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
    assert_eq!(codes(&watch), ["contact"], "{}", output.err);
    let line = output.out.lines().next().unwrap().to_owned();
    let event = line.split_once("joint1").unwrap().1.to_owned();
    piped(&case, &bytes).ends(1).prints(&[&event]);

    std::fs::create_dir(case.path("logs")).unwrap();
    std::fs::copy(case.path("touched.csv"), case.path("logs/b.csv")).unwrap();
    std::fs::copy(case.path("healthy.csv"), case.path("logs/a.csv")).unwrap();
    let (_, watch) = watched(&case, &["logs"], &[]);
    assert_eq!(codes(&watch), ["contact"]);
    let logs = list_of(&watch["logs"]);
    assert!(str_of(&logs[0]["log"]).ends_with("a.csv"));

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
        output.ends(code).tells(&[part]);
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
    piped(&case, b"PK\x03\x04 no stream").ends(3);
}

/// Exports code with a watch.
fn exported(case: &Case, format: &str, watch: &str) -> Ran {
    let (watch, out) = (case.at(watch), case.at("code"));
    let words = ["--format", format, "--watch", &watch, "--out", &out];
    case.run("export", &[&words[..], &["--force"]].concat())
}

/// Compiles exported Rust and runs its test.
#[track_caller]
fn assert_self_test(case: &Case) {
    let built = Ran::of(
        Command::new("rustc")
            .args(["--edition", "2024", "--test", "robot.rs", "-o", "robot"])
            .args(["-D", "warnings"])
            .current_dir(case.path("code")),
    );
    built.ends(0);
    let run = Ran::of(&mut Command::new(case.path("code/robot")));
    run.ends(0);
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
    assert_eq!(codes(&watch), ["contact"], "{}", output.err);
    assert_eq!(watch["events"][0]["joint"], "joint2");
    exported(&case, "rust", WATCH).ends(0);
    contains(&case.read("code/robot.rs"), &["sensor_nm: &Vector"]);
    assert_self_test(&case);
}

#[test]
fn the_observer_of_the_code_has_the_torques_of_the_library() {
    let case = identified();
    let (output, _) = watched(&case, &[], &[]);
    output.ends(0).prints(&["No log was watched"]);
    let export = |format: &str, watch: &str| exported(&case, format, watch);
    export("rust", WATCH).ends(0).prints(&["observer"]);
    assert_self_test(&case);
    export("urdf", WATCH).ends(2).tells(&["no code"]);
    let text = case.read(WATCH);
    #[rustfmt::skip]
    let rows = [
        ("\"period_s\": 0.001", "\"period_s\": 1e-300", "settle in more than"),
        ("\"period_s\": 0.001", "\"period_s\": -1.0", "not a positive number"),
        ("\"robot\": \"Quanser", "\"robot\": \"Other", "the watch is of"),
    ];
    each(rows, |(from, to, part)| {
        contains(&text, &[from]);
        case.write("wrong.json", text.replace(from, to));
        export("c", "wrong.json").ends(2).tells(&[part]);
    });
    export("c", "truth.toml").ends(2).tells(&["no watch.json"]);
}
