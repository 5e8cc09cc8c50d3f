//! Lines that findings print are pasted into the file of their log: it can be read, keeps what it says of other joints, and
//! the finding is gone.

use crate::common::{list_of, str_of};
use serde_json::Value;

use crate::new::Desk;
use crate::renamed_log::{Columns, recorded};

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
    let code = output.code;
    assert!(
        matches!(code, Some(0 | 1 | 3)),
        "{text}{}{}",
        output.out,
        output.err
    );
    let json = desk.json("out/check.json");
    list_of(&json["findings"]).to_vec()
}

fn is_same(one: &Value, two: &Value) -> bool {
    one["code"] == two["code"] && one["evidence"]["column"] == two["evidence"]["column"]
}

type Damage = fn(&mut Columns);

fn values(columns: &Columns, name: &str) -> Vec<f64> {
    let (_, values) = columns.iter().find(|(known, _)| known == name).unwrap();
    values.clone()
}

fn of<'c>(columns: &'c mut Columns, name: &str) -> &'c mut Vec<f64> {
    let (_, values) = columns.iter_mut().find(|(known, _)| known == name).unwrap();
    values
}

/// Adds the torques of sensors in the springs.
fn with_torque_sensors(columns: &mut Columns, factors: [f64; 2]) {
    for (joint, stiffness) in [900.0, 250.0].into_iter().enumerate() {
        let of = |name: &str| values(columns, &format!("{name}{}", joint + 1));
        let deflections = of("phi").into_iter().zip(of("q"));
        let torques = deflections.map(|(phi, q)| factors[joint] * stiffness * (phi - q));
        let torques = torques.collect();
        columns.push((format!("s{}", joint + 1), torques));
    }
}

/// Adds the angular velocities of the links about the axes of their joints.
fn with_gyroscopes(columns: &mut Columns, factors: [f64; 2]) {
    let [times, q1, q2] = ["t", "q1", "q2"].map(|name| values(columns, name));
    let elbow: Vec<f64> = q1.iter().zip(&q2).map(|(one, two)| one + two).collect();
    for (name, angles, factor) in [("g1", q1, factors[0]), ("g2", elbow, factors[1])] {
        let last = angles.len() - 1;
        let rate = |k: usize| {
            let (from, to) = (k.saturating_sub(1), (k + 1).min(last));
            factor * (angles[to] - angles[from]) / (times[to] - times[from])
        };
        let rates = (0..=last).map(rate).collect();
        columns.push((name.to_owned(), rates));
    }
}

fn scale(columns: &mut Columns, names: &[&str], factor: f64) {
    for (_, values) in (columns.iter_mut()).filter(|(name, _)| names.contains(&name.as_str())) {
        for value in values {
            *value *= factor;
        }
    }
}

fn late(columns: &mut Columns, name: &str, samples: usize) {
    let values = of(columns, name);
    let first = values[0];
    values.truncate(values.len() - samples);
    values.splice(0..0, vec![first; samples]);
}

/// Adds the torques of weights on the links, so that the equations of the links tell more.
fn heavy(columns: &mut Columns) {
    let [q1, q2] = ["q1", "q2"].map(|name| values(columns, name));
    let both: Vec<[f64; 2]> = (q1.iter().zip(&q2))
        .map(|(one, two)| [-60.0 * one.cos(), -20.0 * (one + two).cos()])
        .collect();
    let mut add = |name: &str, torque: fn(&[f64; 2]) -> f64| {
        let values = of(columns, name);
        for (value, both) in values.iter_mut().zip(&both) {
            *value += torque(both);
        }
    };
    add("tau1", |both| both[0] + both[1]);
    add("tau2", |both| both[1]);
}

/// Rounds positions to milliradians.
fn coarse(columns: &mut Columns, name: &str) {
    let values = of(columns, name);
    for value in values {
        *value = (*value * 1e3).round() / 1e3;
    }
}

fn add(columns: &mut Columns, name: &str, offset: f64) {
    jump_at(columns, name, offset, 0);
}

/// Adds a step in the middle of the log.
fn jump(columns: &mut Columns, name: &str, size: f64) {
    let middle = columns[0].1.len() / 2;
    jump_at(columns, name, size, middle);
}

fn jump_at(columns: &mut Columns, name: &str, size: f64, begin: usize) {
    let values = of(columns, name);
    for value in &mut values[begin..] {
        *value += size;
    }
}

fn exchange(columns: &mut Columns, one: &str, two: &str) {
    let at = [one, two].map(|name| columns.iter().position(|(known, _)| known == name).unwrap());
    let exchanged = at.map(|k| columns[k].1.clone());
    [columns[at[1]].1, columns[at[0]].1] = exchanged;
}

fn wrapped(columns: &mut Columns, name: &str) {
    let values = of(columns, name);
    let turn = std::f64::consts::TAU;
    for value in values {
        *value = value.rem_euclid(turn);
    }
}

/// A log with a fault: its name, what is done to its columns, replaced texts of its file, and the finding with a line.
struct Row {
    name: &'static str,
    damage: Damage,
    edits: &'static [Edit],
    code: &'static str,
}

const IN_DEGREES: f64 = 180.0 / std::f64::consts::PI;

type Edit = [&'static str; 2];

const fn row(
    name: &'static str,
    damage: Damage,
    edits: &'static [Edit],
    code: &'static str,
) -> Row {
    Row {
        name,
        damage,
        edits,
        code,
    }
}

const LINKS: &str = "link_position_rad = [\"q1\", \"q2\"]";
const SHOULDER: &str = "\"shoulder\"";
const ELBOW: &str = "\"elbow\"";
const LOG: &str = "[log]\n";

#[rustfmt::skip]
const RIGID: [Edit; 3] = [
    ["link_position_rad = [\"q1\", \"q2\"]\n", ""],
    [SHOULDER, "\"shoulder\"\ntransmission = \"rigid\"\ngear_ratio = 100"],
    [ELBOW, "\"elbow\"\ntransmission = \"rigid\"\ngear_ratio = 100"],
];
#[rustfmt::skip]
const GEARED: [Edit; 3] = [
    [LOG, "[log]\nmotor_position_side = \"motor\"\n"],
    [SHOULDER, "\"shoulder\"\ngear_ratio = 100"],
    [ELBOW, "\"elbow\"\ngear_ratio = 100"],
];
#[rustfmt::skip]
const CURRENTS: [Edit; 3] = [
    ["motor_torque_nm", "motor_current_a"],
    [SHOULDER, "\"shoulder\"\ntorque_constant_nm_per_a = 0.1\ngear_ratio = 100"],
    [ELBOW, "\"elbow\"\ntorque_constant_nm_per_a = 0.1\ngear_ratio = 100"],
];
const SENSORS: Edit = ["sign =", "joint_torque_nm = [\"s1\", \"s2\"]\nsign ="];
const GYROSCOPES: Edit = [LINKS, "gyroscope_rad_per_s.y = [\"g1\", \"g2\"]"];
const FIXED: Edit = [
    "[robot]\n",
    "[robot]\nfixed = { \"shoulder.rotor_inertia\" = 0.12 }\n",
];
const GAIN: Edit = ["sign =", "gain = { \"tau1\" = \"estimate\" }\nsign ="];
const HALVED: Edit = ["sign =", "gain = { \"q2\" = 2.0 }\nsign ="];
const ONE_LAW: Edit = [ELBOW, "\"elbow\"\nmotor_friction = [\"viscous\"]"];
const DECLARED: Edit = [LOG, "[identify]\nlaws = \"declared\"\n[log]\n"];
const LOW: Edit = [LOG, "[identify]\nposition_cutoff_hz = 1.5\n[log]\n"];
const HIGH: Edit = [LOG, "[identify]\nposition_cutoff_hz = 200\n[log]\n"];
const SLOW: Edit = [LOG, "[identify]\nfilter_cutoff_rad_per_s = 0.2\n[log]\n"];
const NO_OFFSET: Edit = [LOG, "[identify]\nencoder_offset = \"none\"\n[log]\n"];

fn before_the_gear(log: &mut Columns) {
    heavy(log);
    scale(log, &["phi1", "phi2"], 100.0);
}

/// The description names motor positions before the gear.
fn exchanged_before_the_gear(log: &mut Columns) {
    scale(log, &["phi1", "phi2"], 100.0);
    exchange(log, "q2", "phi2");
}

#[rustfmt::skip]
const ROWS: [Row; 30] = [
    row("reversed", |log| scale(log, &["tau2"], -1.0), &[], "reversed-torque"),
    row("reversed position", |log| scale(log, &["phi2"], -1.0), &[], "opposite-signs"),
    row("reversed joint", |log| scale(log, &["q2", "phi2", "tau2"], -1.0), &[], "reversed-joint"),
    row("reversed positions", |log| scale(log, &["q2", "phi2"], -1.0), &[], "reversed-joint"),
    row("degrees of one", |log| scale(log, &["phi2"], IN_DEGREES), &[], "units-disagree"),
    row("counts of a turn", |log| scale(log, &["phi2"], 1.5), &[], "slope-not-one"),
    row("degrees of both", |log| scale(log, &NAMES[1..5], IN_DEGREES), &[], "looks-like-degrees"),
    row("before the gear", before_the_gear, &RIGID, "motor-side-positions"),
    row("late", |log| late(log, "q2", 4), &[], "delayed-channel"),
    row("gain", |log| scale(log, &["q2"], 1.03), &[], "channel-gain"),
    row("gain beside a number", |log| scale(log, &["q2"], 0.515), &[HALVED], "channel-gain"),
    row("milliseconds", |log| scale(log, &["t"], 1000.0), &[], "time-unit"),
    row("wrapped", |log| wrapped(log, "phi2"), &[], "wraps-around"),
    row("lost counts", |log| jump(log, "phi2", 0.4), &[], "position-jumps"),
    row("exchanged", |log| exchange(log, "q2", "phi2"), &[], "exchanged-columns"),
    row("exchanged before the gear", exchanged_before_the_gear, &GEARED, "exchanged-columns"),
    row("swapped", |log| exchange(log, "tau1", "tau2"), &[["\"tau1\" = -1", "\"tau2\" = -1"]], "swapped-joints"),
    row("millinewtons", |log| scale(log, &["tau2"], 1000.0), &[], "torque-scale"),
    row("offset", |log| add(log, "q2", 0.02), &[NO_OFFSET], "encoder-offset"),
    row("low cut-off", |_| (), &[LOW], "position-cutoff-low"),
    row("high cut-off", |log| NAMES[1..5].iter().for_each(|name| coarse(log, name)), &[HIGH], "position-cutoff-high"),
    row("slow filter", |_| (), &[SLOW], "filter-cutoff"),
    row("a law less", |_| (), &[ONE_LAW, DECLARED], "laws-missing"),
    row("sign asked for", |_| (), &[["\"tau1\" = -1", "\"tau1\" = -1, \"tau2\" = \"estimate\""]], "sign-estimated"),
    row("gain asked for", |log| scale(log, &["tau1"], 2.0), &[FIXED, GAIN], "gain-estimated"),
    row("currents", |log| scale(log, &["tau1", "tau2"], 0.1), &CURRENTS, "torque-side-found"),
    row("reversed sensor", |log| with_torque_sensors(log, [1.0, -1.0]), &[SENSORS], "joint-torque-sign"),
    row("sensor of another unit", |log| with_torque_sensors(log, [1.0, 1000.0]), &[SENSORS], "joint-torque-scale"),
    row("reversed gyroscope", |log| with_gyroscopes(log, [1.0, -1.0]), &[GYROSCOPES], "inertial-sensor-sign"),
    row("reversed gyroscope of the first", |log| with_gyroscopes(log, [-1.0, 1.0]), &[GYROSCOPES], "inertial-sensor-sign"),
];

#[test]
fn lines_of_findings_can_be_pasted_and_clear_them() {
    let (desk, log) = recorded();
    let as_recorded: Columns = NAMES
        .iter()
        .map(|name| (*name).to_owned())
        .zip(log)
        .collect();
    for row in ROWS {
        let mut damaged = as_recorded.clone();
        (row.damage)(&mut damaged);
        scale(&mut damaged, &["tau1"], -1.0);
        desk.log(&damaged);
        let file = (row.edits.iter()).fold(FILE.to_owned(), |file, [from, to]| {
            assert!(file.contains(from), "{from}");
            file.replace(from, to)
        });
        let before = findings(&desk, &file);
        let with_line: Vec<&Value> = (before.iter())
            .filter(|finding| finding["setting"].is_string())
            .collect();
        let name = row.name;
        assert!(
            with_line.iter().any(|finding| finding["code"] == row.code),
            "{name}: {before:#?}"
        );
        for finding in with_line {
            let setting = str_of(&finding["setting"]);
            println!("{name}: {} {setting}", finding["code"]);
            let joint = str_of(&finding["text"]).split(':').next().unwrap();
            let text = paste(&file, setting, joint);
            let after = findings(&desk, &text);
            assert!(
                !after.iter().any(|other| is_same(finding, other)),
                "{name}: {finding}: {text}: {after:#?}"
            );
        }
    }
}
