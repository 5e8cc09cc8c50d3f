//! Faulty bags.

use super::keys::{STATES, TOPICS};
use super::mcap_bytes::{JOINT_STATE, bag, file_of, joint_state, message, record, text, topic};
use super::{Faulty, fixture, run};

const KIND: &str = "sensor_msgs/msg/JointState";

const NAMES: [&str; 2] = ["joint1", "joint2"];

const TURNED: [&str; 2] = ["joint2", "joint1"];

/// Messages 1 ms apart. The joints of each message have the order of its names.
fn messages(count: u32, names: impl Fn(u32) -> [&'static str; 2]) -> Vec<(u64, Vec<u8>)> {
    let one = |k: u32| {
        let wave = |name: &str| {
            let place = if name == "joint1" { 0.0 } else { 1.0 };
            (0.02 * f64::from(k) + place).sin()
        };
        let pair = names(k);
        let (q, tau) = (pair.map(wave), pair.map(|name| 2.0 * wave(name)));
        (
            u64::from(k) * 1_000_000,
            joint_state(k * 1_000_000, &pair, &q, &tau),
        )
    };
    (0..count).map(one).collect()
}

fn ordered(count: u32) -> Vec<(u64, Vec<u8>)> {
    messages(count, |_| NAMES)
}

pub(super) fn all() -> Vec<Faulty> {
    [
        nothing_in_them(),
        topics(),
        of_messages(),
        chunks(),
        definitions(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn states(name: &str, bytes: Vec<u8>, says: &[&'static str]) -> Faulty {
    Faulty::log(name, bytes, STATES, says)
}

#[rustfmt::skip]
fn nothing_in_them() -> Vec<Faulty> {
    vec![
        states("a bag without topics", file_of(&[]), &["it has no topics at all"]),
        states("a bag without messages", bag(KIND, "cdr", &[]), &["/states in", "has no messages"]),
        states("a bag with one message", bag(KIND, "cdr", &ordered(1)), &["has 1 samples"]),
        states("a bag of other messages", bag(KIND, "protobuf", &[]), &["encoded as \"protobuf\""]),
    ]
}

fn topics() -> Vec<Faulty> {
    let of = |name: &str, file: &str, from: &str, to: &str, says: &[&'static str]| {
        assert!(TOPICS.contains(from));
        let name = format!("{name} in {file}");
        Faulty::log(&name, fixture(file), &TOPICS.replace(from, to), says)
    };
    let mut all = Vec::new();
    for file in ["zstd.mcap", "plain.db3"] {
        all.extend([
            of(
                "an absent topic",
                file,
                "/joint_states",
                "/joint_state",
                &["did you mean \"/joint_states\"?"],
            ),
            of(
                "an absent field",
                file,
                "effort",
                "efort",
                &["no number \"efort\"; did you mean \"effort\"?"],
            ),
            of(
                "an absent joint",
                file,
                "unit",
                "joint_names = [\"joint1\", \"b\"], unit",
                &["has no joint \"b\"; it has joint1, joint2"],
            ),
            of(
                "an empty field",
                file,
                "\"effort\"",
                "\"velocity\"",
                &["message 1 has no value at \"velocity[joint1]\""],
            ),
        ]);
    }
    all
}

#[rustfmt::skip]
fn of_messages() -> Vec<Faulty> {
    let changed = |change: fn(&mut Vec<(u64, Vec<u8>)>)| {
        let mut all = ordered(30);
        change(&mut all);
        bag(KIND, "cdr", &all)
    };
    let stranger = messages(30, |k| if k < 7 { NAMES } else { ["joint1", "wrist"] });
    vec![
        states(
            "orders of joints that change",
            bag(
                KIND,
                "cdr",
                &messages(300, |k| if k % 3 == 0 { NAMES } else { TURNED }),
            ),
            &["/states.effort[joint2]"],
        )
        .code(0),
        states("names that change", bag(KIND, "cdr", &stranger), &["message 8 has no joint \"joint2\"; it has joint1, wrist"]),
        states(
            "a message that ends early",
            changed(|all| all[4].1.truncate(30)),
            &["message 5 (sensor_msgs/msg/JointState) ends in the middle"],
        ),
        states(
            "a list shorter than its names",
            changed(|all| all[4].1 = joint_state(4_000_000, &NAMES, &[0.1, 0.2], &[1.0])),
            &["message 5 has no value at \"effort[joint2]\""],
        ),
        states(
            "a list of four thousand million",
            // The count of names follows the header, the stamp and the frame.
            changed(|all| all[4].1[24..28].fill(0xff)),
            &["message 5 (sensor_msgs/msg/JointState)"],
        ),
        states("a stamp that goes back", changed(|all| all.swap(10, 20)), &["message", "time goes from"]),
        states(
            "a position that is no number",
            changed(|all| all[4].1 = joint_state(4_000_000, &NAMES, &[0.1, f64::NAN], &[1.0, 2.0])),
            &["message 5", "the value is NaN"],
        ),
    ]
}

/// A chunk that names a compression.
fn chunk(packing: &str, records: &[u8], (size, sum): (usize, u32)) -> Vec<u8> {
    let (size, length) = (
        (size as u64).to_le_bytes(),
        (records.len() as u64).to_le_bytes(),
    );
    record(
        6,
        &[
            &[0; 16],
            &size,
            &sum.to_le_bytes(),
            &text(packing),
            &length,
            records,
        ],
    )
}

#[rustfmt::skip]
fn chunks() -> Vec<Faulty> {
    let mut records = topic(KIND, JOINT_STATE, "cdr");
    for (time, data) in ordered(30) {
        records.extend(message(time, &data));
    }
    let of = |packing: &str, size: usize| file_of(&chunk(packing, &records, (size, 0)));
    let size = records.len();
    vec![
        states("a chunk that is not zstd", of("zstd", size), &["is damaged", "mcap recover"]),
        states("a chunk that is not lz4", of("lz4", size), &["is damaged", "mcap recover"]),
        states("a chunk in xz", of("xz", size), &["chunks compressed with xz"]),
        states("a chunk of another sum", file_of(&chunk("", &records, (size, 7))), &["damaged"]),
        states("a chunk larger than memory", of("zstd", usize::MAX / 2), &["damaged"]),
        states(
            "a chunk of which most is missing",
            file_of(&[&[6][..], &900_000_000_u64.to_le_bytes(), &[0; 64]].concat()),
            &["exceeds limit"],
        ),
        states("a chunk in a chunk", file_of(&chunk("", &chunk("", &records, (size, 0)), (size, 0))), &["run.log"]),
    ]
}

#[rustfmt::skip]
fn definitions() -> Vec<Faulty> {
    let of = |name: &str, definition: &str, says: &[&'static str]| {
        let mut records = topic("my_msgs/msg/State", definition, "cdr");
        for (time, data) in ordered(30) {
            records.extend(message(time, &data));
        }
        states(name, file_of(&records), says)
    };
    let separator = format!("\n{}\nMSG: ", "=".repeat(80));
    let endless = format!("my_msgs/Part part{separator}my_msgs/Part\nmy_msgs/Part part\n");
    let deep: String = (0..2000).fold("my_msgs/P0 p".to_owned(), |all, k| {
        format!("{all}{separator}my_msgs/P{k}\nmy_msgs/P{} p", k + 1)
    });
    let mut two_types = topic(KIND, JOINT_STATE, "cdr");
    let second = [
        &2_u16.to_le_bytes()[..],
        &text("std_msgs/msg/String"),
        &text("ros2msg"),
        &text("string data"),
    ];
    let channel = [&[2, 0, 2, 0][..], &text("/states"), &text("cdr"), &[0; 4]];
    two_types.extend([record(3, &second), record(4, &channel)].concat());
    vec![
        of("a type without numbers", "string data\n", &["have no number"]),
        of("a definition that is none", "\u{1}?? ==\n[[]]\n", &["have no number \"position\"; they contain no numbers"]),
        of("a definition that lacks a part", "my_msgs/Part part\n", &["the definition of my_msgs/msg/State"]),
        of("a definition that holds itself", &endless, &["the definition of my_msgs/msg/State"]),
        of("a definition that is very deep", &deep, &["the definition of my_msgs/msg/State"]),
        of(
            "messages of no size",
            &format!("my_msgs/None[] position{separator}my_msgs/None\nfloat64[0] x\n"),
            &["the definition of my_msgs/msg/State contains a message of no size"],
        ),
        of("an array of a huge length", "float64[99999999999] position\n", &["my_msgs/msg/State"]),
        states("two types on one topic", file_of(&two_types), &["carries two types of messages"]),
    ]
}

/// The report of a check, without the name of the log.
fn columns(faulty: &Faulty) -> serde_json::Value {
    let folder = tempfile::TempDir::new().unwrap();
    faulty.write(folder.path());
    let found = run(folder.path(), "check").unwrap();
    let report: serde_json::Value = serde_json::from_str(&found.report).unwrap();
    report["logs"][0]["columns"].clone()
}

#[test]
fn joints_are_matched_by_name_in_each_message() {
    let of = |messages: &[(u64, Vec<u8>)]| states("", bag(KIND, "cdr", messages), &[]);
    let ordered = columns(&of(&ordered(300)));
    let mixed = columns(&of(&messages(
        300,
        |k| if k % 3 == 0 { NAMES } else { TURNED },
    )));
    assert_eq!(ordered, mixed);
    assert_eq!(ordered.as_array().unwrap().len(), 6);
}
