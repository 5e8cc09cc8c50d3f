//! Logs as recorders write them: counters of rows, torque sensors, commands, robots with a world. Each row is a header or
//! a file, and lines that `sprung new` must write.

use crate::common::{contains, each};
use crate::new::{ARM, Desk};
use crate::renamed_log::recorded;

/// Columns of the log of the twin.
pub(crate) const T: usize = 0;
pub(crate) const Q: usize = 1;
pub(crate) const PHI: usize = 3;
pub(crate) const TAU: usize = 5;
/// Derived: torque of the springs, current, velocity of the motors, row, noise.
const SPRING: usize = 7;
const CURRENT: usize = 9;
pub(crate) const RATE: usize = 11;
const ROW: usize = 13;

/// The log of the twin with derived columns.
pub(crate) fn log() -> (Desk, Vec<Vec<f64>>) {
    let (desk, mut log) = recorded();
    let count = log[T].len();
    let period = log[T][1] - log[T][0];
    for joint in 0..2 {
        let spring = (0..count).map(|k| 500.0 * (log[PHI + joint][k] - log[Q + joint][k]));
        log.push(spring.collect());
    }
    for joint in 0..2 {
        log.push(log[TAU + joint].iter().map(|torque| torque / 8.0).collect());
    }
    for joint in 0..2 {
        let phi = &log[PHI + joint];
        let rate = |k: usize| {
            let (from, to) = (k.saturating_sub(1), (k + 1).min(count - 1));
            (phi[to] - phi[from]) / ((to - from) as f64 * period)
        };
        log.push((0..count).map(rate).collect());
    }
    log.push((0..count).map(|k| k as f64).collect());
    (desk, log)
}

/// Returns the text of a new experiment for columns with names; `*` in a name stands for the number of the joint from
/// `first` on.
fn begun(columns: &[(&str, usize)], first: usize) -> String {
    let (desk, log) = log();
    let mut named = Vec::new();
    for &(name, column) in columns {
        if name.contains('*') {
            for joint in 0..2 {
                let name = name.replace('*', &(first + joint).to_string());
                named.push((name, log[column + joint].clone()));
            }
        } else {
            named.push((name.to_owned(), log[column].clone()));
        }
    }
    desk.log(&named);
    let output = desk.run(&["new", "exp", "--urdf", "arm.urdf", "--log", "log.csv"]);
    assert!(matches!(output.code, Some(0 | 3)), "{output:?}");
    desk.read("exp/experiment.toml")
}

#[test]
fn names_of_recorders_give_the_columns_that_they_mean() {
    for (columns, first, lines) in [
        // franka: a log without motor torque.
        (
            &[
                ("time", T),
                ("q[*]", Q),
                ("theta[*]", PHI),
                ("tau_J[*]", SPRING),
                ("tau_ext_hat_filtered[*]", RATE),
            ][..],
            0,
            &[
                "link_position_rad = [\"q[0]\", \"q[1]\"]",
                "motor_position_rad = [\"theta[0]\", \"theta[1]\"]",
                "joint_torque_nm = [\"tau_J[0]\", \"tau_J[1]\"]",
            ][..],
        ),
        // ANYdrive.
        (
            &[
                ("time", T),
                ("/anydrives/leg*/current", CURRENT),
                ("/anydrives/leg*/gear_position", PHI),
                ("/anydrives/leg*/joint_position", Q),
                ("/anydrives/leg*/joint_torque", SPRING),
            ],
            1,
            &[
                "motor_position_rad = [\"/anydrives/leg1/gear_position\", \"/anydrives/leg2/gear_position\"]",
                "link_position_rad = [\"/anydrives/leg1/joint_position\", \"/anydrives/leg2/joint_position\"]",
                "motor_current_a = [\"/anydrives/leg1/current\", \"/anydrives/leg2/current\"]",
                "joint_torque_nm = [\"/anydrives/leg1/joint_torque\", \"/anydrives/leg2/joint_torque\"]",
            ],
        ),
        // HEBI.
        (
            &[
                ("hw_rx_time", T),
                ("position[*]", Q),
                ("effort[*]", SPRING),
                ("motor_current[*]", CURRENT),
                ("motor_position[*]", PHI),
            ],
            0,
            &[
                "link_position_rad = [\"position[0]\", \"position[1]\"]",
                "motor_current_a = [\"motor_current[0]\", \"motor_current[1]\"]",
                "joint_torque_nm = [\"effort[0]\", \"effort[1]\"]",
            ],
        ),
        // A sensor that only its content tells, and a torque that is that of the motor.
        (
            &[
                ("t", T),
                ("axis*_torque", SPRING),
                ("axis*_amps", CURRENT),
                ("axis*_motor_pos", PHI),
                ("axis*_pos", Q),
            ],
            1,
            &[
                "motor_current_a = [\"axis1_amps\", \"axis2_amps\"]",
                "joint_torque_nm = [\"axis1_torque\", \"axis2_torque\"]",
            ],
        ),
        (
            &[
                ("t", T),
                ("axis*_torque", TAU),
                ("axis*_amps", CURRENT),
                ("axis*_motor_pos", PHI),
                ("axis*_pos", Q),
            ],
            0,
            &["motor_torque_nm = [\"axis0_torque\", \"axis1_torque\"]"],
        ),
        // Commands are no sensors.
        (
            &[
                ("time", T),
                ("PositionCmptd*", Q),
                ("Position*", PHI),
                ("TorqueRef*", SPRING),
                ("Torque*", TAU),
            ],
            1,
            &[
                "transmission = \"rigid\"",
                "motor_position_rad = [\"Position1\", \"Position2\"]",
                "motor_torque_nm = [\"Torque1\", \"Torque2\"]",
            ],
        ),
    ] {
        let text = begun(columns, first);
        for line in lines {
            assert!(
                text.contains(&format!("\n{line}")),
                "{columns:?} {line}: {text}"
            );
        }
    }
}

#[test]
fn a_counter_of_rows_is_neither_time_nor_torque() {
    for (name, has_velocities, line) in [
        ("ID", false, "period_s = \"FILL IN\""),
        ("sample", false, "period_s = \"FILL IN\""),
        ("n", false, "period_s = \"FILL IN\""),
        ("", false, "period_s = \"FILL IN\""),
        ("time", false, "period_s = \"FILL IN\""),
        ("ID", true, "period_s = 0.00"),
    ] {
        let mut columns = vec![(name, ROW), ("q*", PHI), ("tau*", TAU)];
        if has_velocities {
            columns.push(("dq*", RATE));
        }
        let text = begun(&columns, 1);
        assert!(text.contains(&format!("\n{line}")), "{name}: {text}");
        assert!(
            text.contains("motor_torque_nm = [\"tau1\", \"tau2\"]"),
            "{name}: {text}"
        );
    }
    // An input without a quantity is asked for.
    let text = begun(&[("t", T), ("n", ROW), ("u*", TAU), ("theta*", PHI)], 1);
    contains(&text, &["motor_torque_nm = \"FILL IN\"", "motor_current_a"]);
}

#[test]
fn robot_files_are_read_as_their_programs_read_them() {
    let world = |joint: &str| {
        let link = ARM.find("<link").unwrap();
        let (before, after) = ARM.split_at(link);
        let root = after.split('"').nth(1).unwrap();
        format!("{before}{}{after}", joint.replace("ROOT", root))
    };
    for (text, said) in [
        (
            world(
                "<joint name=\"weld\" type=\"fixed\"><parent link=\"world\"/><child link=\"ROOT\"/></joint>",
            ),
            None,
        ),
        (
            world(
                "<joint name=\"base\" type=\"floating\"><parent link=\"world\"/><child link=\"ROOT\"/></joint>",
            ),
            Some("joint \"base\" lets the whole robot float; sprung fixes it"),
        ),
        (
            ARM.replacen(
                "<parent ",
                "<origin xyz=\"0 0 0\"/><origin xyz=\"0 0 9\"/><parent ",
                1,
            ),
            Some("this is the second <origin> of joint"),
        ),
    ] {
        let desk = Desk::new();
        desk.write("arm.urdf", &text);
        let told = desk.succeeds(&["new", "exp", "--urdf", "arm.urdf"]);
        assert!(told.contains(said.unwrap_or_default()), "{told}");
        let written = desk.read("exp/experiment.toml");
        assert_eq!(
            written.contains("arm.urdf, line"),
            said.is_some(),
            "{written}"
        );
    }
}

#[test]
fn bodies_that_cannot_be_are_named_with_link_and_line() {
    let link = |name: &str, mass: f64, izz: f64| {
        format!(
            "<link name=\"{name}\"><inertial><mass value=\"{mass}\"/><inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.02\" \
             iyz=\"0\" izz=\"{izz}\"/></inertial></link>\n"
        )
    };
    let joint = |name: &str, parent: &str, child: &str| {
        format!(
            "<joint name=\"{name}\" type=\"continuous\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
             <axis xyz=\"0 0 1\"/></joint>\n"
        )
    };
    #[rustfmt::skip]
    let rows = [
        (1.0, 0.02, None),
        (42.9, 0.02, Some("line 4: link \"wrist\" has 42.9 kg, and the heaviest link that carries it 2 kg")),
        (1.0, 0.05, Some("line 4: no body has the inertia of link \"wrist\"")),
        (1.0, -0.02, Some("line 4: no body has the inertia of link \"wrist\"")),
    ];
    each(rows, |(wrist, izz, said)| {
        let desk = Desk::new();
        let links = link("upper", 2.0, 0.02) + &link("wrist", wrist, izz);
        let joints = joint("shoulder", "base", "upper") + &joint("turn", "upper", "wrist");
        desk.write(
            "arm.urdf",
            format!("<robot name=\"a\">\n<link name=\"base\"/>\n{links}{joints}</robot>"),
        );
        let told = desk.succeeds(&["new", "exp", "--urdf", "arm.urdf"]);
        assert!(told.contains(said.unwrap_or_default()), "{told}");
        assert_eq!(told.contains("arm.urdf, line"), said.is_some(), "{told}");
    });
}

#[test]
fn formats_of_other_simulators_are_named_with_what_converts_them() {
    for (text, said) in [
        (
            "<mujoco model=\"a\"/>",
            "`python -m mjcf_urdf_simple_converter.mjcf_urdf_simple_converter arm.xml arm.urdf`",
        ),
        ("<sdf version=\"1.9\"/>", "it is SDF, the format of Gazebo"),
        ("<COLLADA/>", "`xacro arm.xml > arm.xml.expanded.urdf`"),
    ] {
        let desk = Desk::new();
        desk.write("arm.xml", text);
        desk.fails(&["new", "exp", "--urdf", "arm.xml"], 2, &[said]);
    }
}
