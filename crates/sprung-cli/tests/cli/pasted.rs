//! Lines that findings print are pasted into the file of their log: it can be read, keeps what it says of other joints, and
//! the finding is gone.

use serde_json::Value;

use crate::common::{stderr, stdout};
use crate::new::Desk;
use crate::renamed_log::{Columns, csv, recorded};

/// The file of a log: the torque of the shoulder is reversed, and all keys have two joints.
const FILE: &str = r#"format = 1
[robot]
urdf = "arm.urdf"
[[robot.joint]]
name = "shoulder"
[[robot.joint]]
name = "elbow"
[log]
file = "log.csv"
time_s = "t"
link_position_rad = ["q1", "q2"]
motor_position_rad = ["phi1", "phi2"]
motor_torque_nm = ["tau1", "tau2"]
sign = { "tau1" = -1 }
"#;

const NAMES: [&str; 7] = ["t", "q1", "q2", "phi1", "phi2", "tau1", "tau2"];

/// Returns the text with a setting pasted into its tables; `joint` is that of the finding.
fn paste(text: &str, setting: &str, joint: &str) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let mut table = "";
    for line in setting.lines() {
        let mut line = line;
        if line.starts_with('[') {
            let (before, after) = line.split_at(line.find("] ").unwrap() + 1);
            (table, line) = (before, after.trim());
        }
        let key = line.split(" =").next().unwrap();
        let (line, instead) = line.split_once("  # in place of ").unwrap_or((line, key));
        let replaced: Vec<&str> = instead.split(" and ").chain([key]).collect();
        if !lines.iter().any(|known| known == table) {
            lines.push(table.to_owned());
        }
        let is_of_joint = |k: &usize| table != "[[robot.joint]]" || lines[k + 1].contains(joint);
        let begin = (0..lines.len())
            .filter(|&k| lines[k] == table)
            .find(is_of_joint)
            .unwrap();
        let length = lines[begin + 1..]
            .iter()
            .take_while(|line| !line.starts_with('['))
            .count();
        let block: Vec<String> = lines.splice(begin + 1..begin + 1 + length, []).collect();
        let kept = block.into_iter().filter(|known| {
            !replaced
                .iter()
                .any(|key| known.starts_with(&format!("{key} =")))
        });
        let new: Vec<String> = kept.chain([line.to_owned()]).collect();
        lines.splice(begin + 1..=begin, new);
    }
    lines.join("\n") + "\n"
}

/// Returns the findings of a check of a file.
fn findings(desk: &Desk, text: &str) -> Vec<Value> {
    desk.write("exp.toml", text);
    let output = desk.run(&["check", "exp.toml", "--out", "out"]);
    let code = output.status.code();
    assert!(
        matches!(code, Some(0 | 1 | 3)),
        "{text}{}{}",
        stdout(&output),
        stderr(&output)
    );
    let json: Value = serde_json::from_str(&desk.read("out/check.json")).unwrap();
    json["findings"].as_array().unwrap().clone()
}

fn is_same(one: &Value, two: &Value) -> bool {
    one["code"] == two["code"] && one["evidence"]["column"] == two["evidence"]["column"]
}

type Damage = fn(&mut Columns);

fn scale(columns: &mut Columns, name: &str, factor: f64) {
    let (_, values) = columns.iter_mut().find(|(known, _)| known == name).unwrap();
    for value in values {
        *value *= factor;
    }
}

fn late(columns: &mut Columns, name: &str, samples: usize) {
    let (_, values) = columns.iter_mut().find(|(known, _)| known == name).unwrap();
    let first = values[0];
    values.truncate(values.len() - samples);
    values.splice(0..0, vec![first; samples]);
}

fn wrapped(columns: &mut Columns, name: &str) {
    let (_, values) = columns.iter_mut().find(|(known, _)| known == name).unwrap();
    let turn = std::f64::consts::TAU;
    for value in values {
        *value = (*value + 3.1).rem_euclid(turn);
    }
}

#[test]
fn lines_of_findings_can_be_pasted_and_clear_them() {
    let (desk, log) = recorded();
    let as_recorded: Columns = NAMES
        .iter()
        .map(|name| (*name).to_owned())
        .zip(log)
        .collect();
    let mut tested = Vec::new();
    let all: [(&str, Damage, &str); 14] = [
        ("reversed", |log| scale(log, "tau2", -1.0), ""),
        ("reversed position", |log| scale(log, "phi2", -1.0), ""),
        (
            "degrees of one",
            |log| {
                scale(log, "phi2", 180.0 / std::f64::consts::PI);
            },
            "",
        ),
        (
            "degrees of both",
            |log| {
                for name in &NAMES[1..5] {
                    scale(log, name, 180.0 / std::f64::consts::PI);
                }
            },
            "",
        ),
        ("motor side", |log| scale(log, "phi2", 100.0), ""),
        ("late", |log| late(log, "q2", 4), ""),
        ("gain", |log| scale(log, "q2", 1.03), ""),
        ("milliseconds", |log| scale(log, "t", 1000.0), ""),
        ("wrapped", |log| wrapped(log, "phi2"), ""),
        (
            "exchanged",
            |log| {
                let (q, phi) = (log[2].1.clone(), log[4].1.clone());
                (log[2].1, log[4].1) = (phi, q);
            },
            "",
        ),
        (
            "swapped",
            |log| {
                let (one, two) = (log[5].1.clone(), log[6].1.clone());
                // The file reverses the first.
                (log[5].1, log[6].1) = (two, one);
            },
            "",
        ),
        (
            "offset",
            |log| log[2].1.iter_mut().for_each(|q| *q += 0.02),
            "encoder_offset = \"none\"",
        ),
        ("low cut-off", |_| (), "position_cutoff_hz = 1.5"),
        ("slow filter", |_| (), "filter_cutoff_rad_per_s = 0.2"),
    ];
    for (name, damage, settings) in all {
        let mut damaged = as_recorded.clone();
        scale(&mut damaged, "tau1", -1.0);
        damage(&mut damaged);
        desk.write("log.csv", &csv(&damaged));
        let file = format!("{FILE}[identify]\n{settings}\n");
        let before = findings(&desk, &file);
        for finding in before
            .iter()
            .filter(|finding| finding["setting"].is_string())
        {
            let setting = finding["setting"].as_str().unwrap();
            println!("{name}: {} {setting}", finding["code"]);
            let joint = finding["text"].as_str().unwrap().split(':').next().unwrap();
            let text = paste(&file, setting, joint);
            let after = findings(&desk, &text);
            assert!(
                !after.iter().any(|other| is_same(finding, other)),
                "{name}: {finding}: {text}: {after:#?}"
            );
            tested.push(finding["code"].as_str().unwrap().to_owned());
        }
    }
    tested.sort();
    tested.dedup();
    println!("{tested:?}");
    assert!(tested.len() >= 11, "{tested:?}");
}
