//! Bags made byte by byte: what no writer would write.

use crate::support::{Files, read_log, says};

const TOPICS: &str = r#"
link_position = { topic = "/states", unit = "rad" }
motor_position = { topic = "/states", unit = "rad" }
motor_torque = { topic = "/states", field = "effort", unit = "N·m" }
"#;

const JOINT_STATE: &str = "std_msgs/Header header\nstring[] name\nfloat64[] position\n\
                           float64[] velocity\nfloat64[] effort\n";

fn text(text: &str) -> Vec<u8> {
    let length = u32::try_from(text.len()).unwrap();
    [&length.to_le_bytes()[..], text.as_bytes()].concat()
}

/// A record of MCAP.
fn record(kind: u8, parts: &[&[u8]]) -> Vec<u8> {
    let body = parts.concat();
    [&[kind][..], &(body.len() as u64).to_le_bytes(), &body].concat()
}

/// A file with one topic of a type and its messages: time, data.
fn bag(kind: &str, encoding: &str, messages: &[(u64, Vec<u8>)]) -> Vec<u8> {
    let one = 1_u16.to_le_bytes();
    let schema = [&one[..], &text(kind), &text("ros2msg"), &text(JOINT_STATE)];
    let channel = [&one[..], &one, &text("/states"), &text(encoding), &[0; 4]];
    let mut file = b"\x89MCAP0\r\n".to_vec();
    file.extend(record(1, &[&[0; 8]]));
    file.extend(record(3, &schema));
    file.extend(record(4, &channel));
    for (time, data) in messages {
        let time = time.to_le_bytes();
        file.extend(record(5, &[&one, &[0; 4], &time, &time, data]));
    }
    file.extend(record(15, &[&[0; 4]]));
    file.extend(record(2, &[&[0; 20]]));
    file.extend(b"\x89MCAP0\r\n");
    file
}

/// A message in CDR.
#[derive(Default)]
struct Cdr(Vec<u8>);

impl Cdr {
    fn pad(&mut self, size: usize) {
        self.0.resize(self.0.len().next_multiple_of(size), 0);
    }

    fn word(&mut self, word: u32) {
        self.pad(4);
        self.0.extend(word.to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.word(u32::try_from(text.len() + 1).unwrap());
        self.0.extend(text.bytes().chain([0]));
    }

    fn numbers(&mut self, numbers: &[f64]) {
        self.word(u32::try_from(numbers.len()).unwrap());
        for number in numbers {
            self.pad(8);
            self.0.extend(number.to_le_bytes());
        }
    }
}

fn joint_state(nanoseconds: u32, names: &[&str], position: &[f64], effort: &[f64]) -> Vec<u8> {
    let mut cdr = Cdr::default();
    cdr.word(0);
    cdr.word(nanoseconds);
    cdr.text("base");
    cdr.word(u32::try_from(names.len()).unwrap());
    for name in names {
        cdr.text(name);
    }
    cdr.numbers(position);
    cdr.numbers(&[]);
    cdr.numbers(effort);
    [&[0, 1, 0, 0][..], &cdr.0].concat()
}

fn read(bytes: Vec<u8>) -> Result<Vec<Vec<f64>>, String> {
    read_log(
        &Files::Memory(vec![("run.mcap", bytes)]),
        "run.mcap",
        TOPICS,
    )
}

const KIND: &str = "sensor_msgs/msg/JointState";
const NAMES: [&str; 2] = ["joint1", "joint2"];

#[test]
fn bags_without_anything_in_them() {
    let mut file = b"\x89MCAP0\r\n".to_vec();
    file.extend(record(1, &[&[0; 8]]));
    file.extend(record(15, &[&[0; 4]]));
    file.extend(record(2, &[&[0; 20]]));
    file.extend(b"\x89MCAP0\r\n");
    says(
        &read(file).unwrap_err(),
        &["has no topic \"/states\"; it has no topics at all"],
    );
    says(
        &read(bag(KIND, "cdr", &[])).unwrap_err(),
        &["/states in run.mcap has no messages"],
    );
    says(
        &read(bag(KIND, "protobuf", &[])).unwrap_err(),
        &["encoded as \"protobuf\"", "only ROS 2 messages"],
    );
}

#[test]
fn stamps_that_nobody_set_are_not_times() {
    let message = |k: u64| {
        (
            k * 1_000_000,
            joint_state(0, &NAMES, &[0.1, 0.2], &[1.0, 2.0]),
        )
    };
    let messages: Vec<_> = (5..15).map(message).collect();
    let found = read(bag(KIND, "cdr", &messages)).unwrap();
    assert_eq!(found[0].len(), 10);
    assert!((found[0][0] - 0.005).abs() < 1e-12 && (found[0][9] - 0.014).abs() < 1e-12);
}

#[test]
fn names_that_change_in_the_middle() {
    let messages: Vec<_> = (0..10)
        .map(|k| {
            let names = if k < 7 { NAMES } else { ["joint1", "wrist"] };
            let data = joint_state(k * 1_000_000, &names, &[0.1, 0.2], &[1.0, 2.0]);
            (u64::from(k) * 1_000_000, data)
        })
        .collect();
    says(
        &read(bag(KIND, "cdr", &messages)).unwrap_err(),
        &["message 8 has no joint \"joint2\"; it has joint1, wrist"],
    );
}

#[test]
fn lists_of_other_lengths_than_their_names() {
    let mut messages: Vec<_> = (0..10)
        .map(|k| {
            let data = joint_state(k * 1_000_000, &NAMES, &[0.1, 0.2], &[1.0, 2.0]);
            (u64::from(k) * 1_000_000, data)
        })
        .collect();
    messages[4].1 = joint_state(4_000_000, &NAMES, &[0.1, 0.2], &[1.0]);
    says(
        &read(bag(KIND, "cdr", &messages)).unwrap_err(),
        &["message 5 has no value at \"effort[joint2]\""],
    );
    messages[4].1.truncate(30);
    says(
        &read(bag(KIND, "cdr", &messages)).unwrap_err(),
        &["message 5 (sensor_msgs/msg/JointState) ends in the middle"],
    );
}
