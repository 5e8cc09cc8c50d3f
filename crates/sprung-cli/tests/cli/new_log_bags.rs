//! `sprung new --log` chooses topics and joints of bags by their names.

use crate::common::{contains, has_lines, messages};
use crate::mcap_bytes::{file_of, joint_state, record, text};
use crate::new::ARM;
use crate::renamed_log::{
    Columns, LEAST_SQUARES, begun, column, csv, is_identified, named, recorded,
};

/// A bag with the topics of some robots: positions and efforts of two joints.
fn bag(topics: &[&str], log: &[Vec<f64>]) -> Vec<u8> {
    bag_of(topics, &["shoulder", "elbow"], &log[0], |row, k| match k {
        0 => (vec![log[1][row], log[2][row]], vec![]),
        _ => (
            vec![log[3][row] + 0.1 * k as f64, log[4][row]],
            vec![log[5][row], log[6][row]],
        ),
    })
}

/// A bag with topics that have the same joints.
///
/// - `values`: positions and efforts of a row of a topic.
fn bag_of(
    topics: &[&str],
    names: &[&str],
    times: &[f64],
    values: impl Fn(usize, usize) -> (Vec<f64>, Vec<f64>),
) -> Vec<u8> {
    let one = 1_u16.to_le_bytes();
    let definition = crate::mcap_bytes::JOINT_STATE;
    let schema = [
        &one[..],
        &text("sensor_msgs/msg/JointState"),
        &text("ros2msg"),
        &text(definition),
    ];
    let mut records = record(3, &schema);
    for (k, topic) in topics.iter().enumerate() {
        let id = u16::try_from(k + 1).unwrap().to_le_bytes();
        records.extend(record(4, &[&id, &one, &text(topic), &text("cdr"), &[0; 4]]));
    }
    for (row, time) in times.iter().enumerate() {
        let stamp = (time * 1e9).round() as u64;
        for (k, _) in topics.iter().enumerate() {
            let id = u16::try_from(k + 1).unwrap().to_le_bytes();
            let (q, tau) = values(row, k);
            let rest = u32::try_from(stamp % 1_000_000_000).unwrap();
            let data = joint_state(rest, names, &q, &tau);
            let data = with_seconds(data, u32::try_from(stamp / 1_000_000_000).unwrap());
            let time = stamp.to_le_bytes();
            records.extend(record(5, &[&id, &[0; 4], &time, &time, &data]));
        }
    }
    file_of(&records)
}

/// Writes the seconds of the stamp of a message.
fn with_seconds(mut data: Vec<u8>, seconds: u32) -> Vec<u8> {
    data[4..8].copy_from_slice(&seconds.to_le_bytes());
    data
}

/// The arm with a gripper: one finger moves, the other follows.
fn with_gripper() -> String {
    let finger = |name: &str, more: &str| {
        format!(
            "<link name=\"{name}\"/><joint name=\"arm_finger_{name}\" type=\"prismatic\"><parent link=\"lower\"/>\
             <child link=\"{name}\"/><axis xyz=\"0 1 0\"/><limit lower=\"0\" upper=\"0.04\" effort=\"20\" \
             velocity=\"0.2\"/>{more}</joint>"
        )
    };
    let fingers = finger("joint1", "") + &finger("joint2", "<mimic joint=\"arm_finger_joint1\"/>");
    (ARM.replace("\"shoulder\"", "\"arm_joint1\""))
        .replace("\"elbow\"", "\"arm_joint2\"")
        .replace("</robot>", &format!("{fingers}</robot>"))
}

#[test]
fn grippers_and_joints_that_follow_others_are_left_out() {
    let (desk, log) = recorded();
    desk.write("arm.urdf", with_gripper());
    let names = [
        "arm_finger_joint1",
        "arm_finger_joint2",
        "arm_joint1",
        "arm_joint2",
    ];
    let finger = |row: usize| 0.02 + 0.02 * (0.01 * row as f64).sin();
    let values = |row: usize, topic: usize| {
        let column = 1 + 2 * topic;
        let position = vec![
            finger(row),
            finger(row),
            log[column][row],
            log[column + 1][row],
        ];
        let effort = vec![0.5, 0.4, log[5][row], log[6][row]];
        (position, if topic == 0 { vec![] } else { effort })
    };
    let topics = ["/joint_states", "/motor_states"];
    let bytes = bag_of(&topics, &names, &log[0], values);
    desk.write("bag.mcap", bytes);
    // A table with the same names.
    let mut columns = named(&log, &[column("t_s", 0, 1.0)]);
    for (k, quantity) in [(1, "link_pos"), (3, "motor_pos"), (5, "torque")] {
        for (joint, name) in names.iter().enumerate() {
            let values = match joint {
                0 | 1 => (0..log[0].len()).map(finger).collect(),
                _ => log[k + joint - 2].clone(),
            };
            columns.push((format!("{name}_{quantity}"), values));
        }
    }
    desk.write("table.csv", csv(&columns));
    for (folder, file) in [("bag", "bag.mcap"), ("table", "table.csv")] {
        desk.run(&["new", folder, "--urdf", "arm.urdf", "--log", file])
            .prints(&["arm_finger_joint1 is left out as a joint of a gripper, by its name"]);
        let text = desk.read(&format!("{folder}/experiment.toml"));
        let flat = text.replace("\n# ", " ");
        assert!(
            flat.contains("arm_finger_joint2 mimics arm_finger_joint1, so both are fixed at zero"),
            "{text}"
        );
        assert_eq!(text.matches("\n[[robot.joint]]\n").count(), 2, "{text}");
        let keys = text.lines().filter(|line| !line.starts_with('#'));
        assert!(keys.clone().all(|line| !line.contains("finger")), "{text}");
        let wanted = match file {
            "bag.mcap" => {
                "motor_position = { topic = \"/motor_states\", field = \"position\", unit = \"rad\" }"
            }
            _ => "motor_position_rad = [\"arm_joint1_motor_pos\", \"arm_joint2_motor_pos\"]",
        };
        assert!(keys.clone().any(|line| line == wanted), "{text}");
        desk.run(&["identify", folder, "--set", LEAST_SQUARES])
            .has_a_result();
    }
    // A log of the gripper alone.
    let only: Columns = (columns.iter())
        .filter(|(name, _)| name == "t_s" || name.starts_with("arm_finger_joint1"))
        .cloned()
        .collect();
    desk.write("gripper.csv", csv(&only));
    desk.fails(
        &["new", "only", "--urdf", "arm.urdf", "--log", "gripper.csv"],
        2,
        &["gripper.csv has only joints of a gripper: arm_finger_joint1 (by its name)"],
    );
    assert!(!desk.path("only").exists());
}

#[test]
fn topics_are_told_apart_by_their_names_or_asked_for() {
    let (desk, log) = recorded();
    std::fs::write(
        desk.path("two.mcap"),
        bag(&["/joint_states", "/motor_states"], &log),
    )
    .unwrap();
    let text = begun(&desk, "two.mcap");
    has_lines(
        &text,
        &[
            "link_position = { topic = \"/joint_states\", field = \"position\", unit = \"rad\" }",
            "motor_position = { topic = \"/motor_states\", field = \"position\", unit = \"rad\" }",
            "motor_torque = { topic = \"/motor_states\", field = \"effort\", unit = \"N·m\" }",
        ],
    );
    is_identified(&desk);

    std::fs::remove_dir_all(desk.path("exp")).unwrap();
    let topics = ["/joint_states_1", "/joint_states_2", "/joint_states_3"];
    desk.write("three.mcap", bag(&topics, &log));
    let text = begun(&desk, "three.mcap");
    let flat = text.replace("\n# ", " ");
    for topic in topics {
        assert!(
            flat.contains(&format!("\"{topic}.position\"")),
            "{topic}: {text}"
        );
    }
    assert!(
        flat.contains("FILL IN which positions are the motors"),
        "{text}"
    );
    desk.fails(&["identify", "exp"], 2, &["FILL IN motor_position_rad"]);
}

#[test]
fn a_bag_with_two_robots_is_refused_until_one_is_chosen() {
    let mut messages = messages("a_bag_with_two_robots_is_refused_until_one_is_chosen");
    let (desk, log) = recorded();
    let topics = ["/left/joint_states", "/right/joint_states"];
    desk.write("two.mcap", bag(&topics, &log));
    let new = ["new", "exp", "--urdf", "arm.urdf", "--log", "two.mcap"];
    messages.note("two robots", &desk.refused(&new, 2));
    let other = [&new[..], &["--topics", "/lefft"]].concat();
    messages.note("no such robot", &desk.refused(&other, 2));
    messages.compare();
    desk.succeeds(&[&new[..], &["--topics", "/right"]].concat());
    let text = desk.read("exp/experiment.toml");
    contains(&text, &["topic = \"/right/joint_states\""]);
    assert!(!text.contains("/left"), "{text}");
}
