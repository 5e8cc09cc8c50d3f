//! `sprung check`: its output, its files and its exit code.

use serde_json::Value;

use crate::common::{Case, Ran, contains, list_of, str_of};

const Q1: usize = 1;
const TAU2: usize = 6;

fn check(case: &Case, more: &[&str]) -> Ran {
    case.run("check", more)
}

#[test]
fn a_whole_log_is_one_screen() {
    let case = Case::new();
    let Ran { code, out, err } = check(&case, &[]);
    assert_eq!(code, Some(0), "{err}");
    assert!(err.is_empty(), "{err}");
    contains(&out, &["errors 0, serious 0, warnings 0, notes 0"]);
    // A small terminal has 25 lines.
    assert!(out.lines().count() < 25, "{out}");
    let json = case.json("sprung-out/check.json");
    assert_eq!(json["format"], 1);
    assert_eq!(json["logs"][0]["samples"], 10_000);
    assert_eq!(json["refused"], false);
    assert!(list_of(&json["findings"]).is_empty());
    contains(
        &case.read("sprung-out/check.html"),
        &["nothing wrong was found"],
    );
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
    let codes: Vec<&str> = (list_of(&json["findings"]).iter())
        .filter(|finding| finding["severity"] == "error")
        .map(|finding| str_of(&finding["code"]))
        .collect();
    assert_eq!(codes, ["units-disagree", "reversed-torque"]);
    assert_eq!(
        json["findings"][1]["setting"],
        "[log] sign = { \"tau2_nm\" = -1 }"
    );
    let Ran { code, out, .. } = check(&case, &[]);
    assert_eq!(code, Some(3));
    contains(
        &out,
        &[
            "error (units-disagree)",
            "line: [log] link_position = [{ column = \"q1_rad\", unit = \"deg\" }, { column",
            "remedy:",
        ],
    );
    // `identify` refuses the log with the same words, and continues if the setting requests it.
    case.identify(&[]).ends(3).tells(&["reversed-torque"]);
    assert!(!case.path("sprung-out/identification.json").exists());
    case.identify(&["--set", "identify.on_check_error=go-on", "-q"])
        .ends(1);
}

#[test]
fn a_joint_that_stands_still_is_unusable_and_short_logs_are_said() {
    let case = Case::new().columns(&[2, 4], |_| 0.25);
    let Ran { code, out, .. } = check(&case, &[]);
    assert_eq!(code, Some(1), "{out}");
    contains(&out, &["serious (unexcited-joint): joint2 stands still"]);
    let short = Case::new().first_rows(60);
    let Ran { code, out, .. } = check(&short, &[]);
    assert_eq!(code, Some(0), "{out}");
    contains(&out, &["too-short-to-examine"]);
    let Ran { code, err, .. } = check(&Case::new(), &["--set", "log.file=nothing.csv"]);
    assert_eq!(code, Some(4), "{err}");
    let Ran { code, err, .. } = check(&Case::new(), &["--set", "identify.on_check_error=perhaps"]);
    assert_eq!(code, Some(2), "{err}");
    contains(&err, &["go-on"]);
}

#[test]
fn what_the_log_shows_beyond_its_description_is_a_table() {
    let case = Case::new().late(TAU2, 20);
    let Ran { code, out, err } = check(&case, &[]);
    assert_eq!(code, Some(0), "{err}");
    let (_, table) = out
        .split_once("what the log shows beyond its description")
        .unwrap();
    let row = table.lines().find(|line| line.contains("tau2_nm")).unwrap();
    contains(row, &["delay", "ms", "±", "applied"]);
    assert!(
        table.lines().take(5).all(|line| line.chars().count() <= 80),
        "{table}"
    );
    let json = case.json("sprung-out/check.json");
    assert_eq!(json["unknowns"][0]["id"], "delay tau2_nm");
    assert!(json["joints"][0].get("delay").is_none());
    contains(
        &case.read("sprung-out/check.html"),
        &["What the log shows beyond its description"],
    );
    // An identification uses the delay, and says so in the same words.
    let output = case.identify(&[]);
    let said = output.out.clone();
    output.ends(0);
    let (_, table) = said
        .split_once("what the log shows beyond its description")
        .unwrap();
    assert!(table.contains(row.trim_end()), "{said}");
    contains(
        &case.read("sprung-out/report.html"),
        &["What the log shows beyond its description"],
    );
    // A whole log has no table.
    assert!(
        !check(&Case::new(), &[])
            .out
            .contains("beyond its description")
    );
}
