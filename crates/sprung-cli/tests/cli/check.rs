//! `sprung check`: its output, its files and its exit code.

use serde_json::Value;

use crate::common::{Case, Ran, sprung, stderr};

const Q1: usize = 1;
const TAU2: usize = 6;

fn check(case: &Case, more: &[&str]) -> Ran {
    let experiment = case.path("experiment.toml");
    let mut args = vec!["check", experiment.to_str().unwrap()];
    args.extend(more);
    Ran::of(&sprung(&args))
}

#[test]
fn a_whole_log_is_one_screen() {
    let case = Case::new();
    let Ran { code, out, err } = check(&case, &[]);
    assert_eq!(code, Some(0), "{err}");
    assert!(err.is_empty(), "{err}");
    assert!(
        out.contains("errors 0, serious 0, warnings 0, notes 0"),
        "{out}"
    );
    // A small terminal has 25 lines.
    assert!(out.lines().count() < 25, "{out}");
    let json = std::fs::read_to_string(case.path("sprung-out/check.json")).unwrap();
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["format"], 1);
    assert_eq!(json["logs"][0]["samples"], 10_000);
    assert_eq!(json["refused"], false);
    assert!(json["findings"].as_array().unwrap().is_empty());
    let html = std::fs::read_to_string(case.path("sprung-out/check.html")).unwrap();
    assert!(html.contains("nothing wrong was found"));
    // A check writes no identification and keeps that of an earlier run.
    assert!(!case.path("sprung-out/identification.json").exists());
}

#[test]
fn all_errors_are_said_at_once_with_their_lines() {
    let case = Case::new()
        .column(Q1, f64::to_degrees)
        .column(TAU2, |torque| -torque);
    let Ran { code, out, .. } = check(&case, &["--json"]);
    assert_eq!(code, Some(3));
    let json: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(json["refused"], true);
    let codes: Vec<&str> = (json["findings"].as_array().unwrap().iter())
        .filter(|finding| finding["severity"] == "error")
        .map(|finding| finding["code"].as_str().unwrap())
        .collect();
    assert_eq!(codes, ["units-disagree", "reversed-torque"]);
    assert_eq!(
        json["findings"][1]["setting"],
        "[log] sign = { \"tau2_nm\" = -1 }"
    );
    let Ran { code, out, .. } = check(&case, &[]);
    assert_eq!(code, Some(3));
    for part in [
        "error (units-disagree)",
        "line: [log] link_position = [{ column = \"q1_rad\", unit = \"deg\" }, { column",
        "remedy:",
    ] {
        assert!(out.contains(part), "no {part:?} in {out}");
    }
    // `identify` refuses the log with the same words, and continues if the setting requests it.
    let output = case.identify(&[]);
    assert_eq!(output.status.code(), Some(3));
    assert!(
        stderr(&output).contains("reversed-torque"),
        "{}",
        stderr(&output)
    );
    assert!(!case.path("sprung-out/identification.json").exists());
    let output = case.identify(&["--set", "identify.on_check_error=go-on", "-q"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
}

#[test]
fn a_joint_that_stands_still_is_unusable_and_short_logs_are_said() {
    let case = [2, 4]
        .into_iter()
        .fold(Case::new(), |case, column| case.column(column, |_| 0.25));
    let Ran { code, out, .. } = check(&case, &[]);
    assert_eq!(code, Some(1), "{out}");
    assert!(
        out.contains("serious (unexcited-joint): joint2 stands still"),
        "{out}"
    );
    let short = Case::new().log(|row, cells| {
        if row > 60 {
            cells.clear();
        }
    });
    let Ran { code, out, .. } = check(&short, &[]);
    assert_eq!(code, Some(0), "{out}");
    assert!(out.contains("too-short-to-examine"), "{out}");
    let Ran { code, err, .. } = check(&Case::new(), &["--set", "log.file=nothing.csv"]);
    assert_eq!(code, Some(4), "{err}");
    let Ran { code, err, .. } = check(&Case::new(), &["--set", "identify.on_check_error=perhaps"]);
    assert_eq!(code, Some(2), "{err}");
    assert!(err.contains("go-on"), "{err}");
}

#[test]
fn what_the_log_shows_beyond_its_description_is_a_table() {
    let mut past = std::collections::VecDeque::new();
    let case = Case::new().log(|row, cells| {
        if row > 0 {
            past.push_back(cells[TAU2].clone());
            if past.len() > 21 {
                past.pop_front();
            }
            cells[TAU2].clone_from(&past[0]);
        }
    });
    let Ran { code, out, err } = check(&case, &[]);
    assert_eq!(code, Some(0), "{err}");
    let (_, table) = out
        .split_once("what the log shows beyond its description")
        .unwrap();
    let row = table.lines().find(|line| line.contains("tau2_nm")).unwrap();
    for cell in ["delay", "ms", "±", "applied"] {
        assert!(row.contains(cell), "no {cell:?} in {row:?}");
    }
    assert!(
        table.lines().take(5).all(|line| line.chars().count() <= 80),
        "{table}"
    );
    let json = std::fs::read_to_string(case.path("sprung-out/check.json")).unwrap();
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["unknowns"][0]["id"], "delay tau2_nm");
    assert!(json["joints"][0].get("delay").is_none());
    let html = std::fs::read_to_string(case.path("sprung-out/check.html")).unwrap();
    assert!(html.contains("What the log shows beyond its description"));
    // An identification uses the delay, and says so in the same words.
    let output = case.identify(&[]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let (_, table) = said
        .split_once("what the log shows beyond its description")
        .unwrap();
    assert!(table.contains(row.trim_end()), "{said}");
    let html = std::fs::read_to_string(case.path("sprung-out/report.html")).unwrap();
    assert!(html.contains("What the log shows beyond its description"));
    // A whole log has no table.
    assert!(
        !check(&Case::new(), &[])
            .out
            .contains("beyond its description")
    );
}
