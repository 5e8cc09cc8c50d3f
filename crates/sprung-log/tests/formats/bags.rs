//! Bags made byte by byte, with content that no writer produces.

use crate::keys::STATES;
use crate::mcap_bytes::{bag, joint_state, record};
use crate::support::{Files, read_log, says};

fn read(bytes: Vec<u8>) -> Result<Vec<Vec<f64>>, String> {
    read_log(
        &Files::Memory(vec![("run.mcap", bytes)]),
        "run.mcap",
        STATES,
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
