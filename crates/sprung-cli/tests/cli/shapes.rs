//! Shapes of recordings: several files of one recording, blocks without names, a row of units, JSON, formats that are only
//! named. Each row is a set of files, and lines that `sprung new` must write.

use std::fmt::Write as _;

use crate::common::{contains, each, f64_of, has_lines};
use crate::new::{ARM, Desk};
use crate::recorders::{PHI, Q, RATE, T, TAU, log};
use crate::renamed_log::{csv, is_identified};

/// Columns of both joints of the log under names with `*` for their numbers, in order.
fn columns(log: &[Vec<f64>], names: &[(&str, usize)]) -> Vec<(String, Vec<f64>)> {
    let mut all = Vec::new();
    for &(name, column) in names {
        for joint in 0..=usize::from(name.contains('*')) {
            let name = name.replace('*', &(joint + 1).to_string());
            all.push((name, log[column + joint].clone()));
        }
    }
    all
}

fn without_header(text: &str) -> String {
    text.split_once('\n').unwrap().1.to_owned()
}

fn json(columns: &[(String, Vec<f64>)], is_of_samples: bool) -> String {
    if !is_of_samples {
        let of = |(name, values): &(String, Vec<f64>)| format!("\"{name}\": {values:?}");
        let all: Vec<String> = columns.iter().map(of).collect();
        return format!("{{\"robot\": \"arm\", \"log\": {{{}}}}}", all.join(", "));
    }
    let mut text = "[".to_owned();
    for k in 0..columns[0].1.len() {
        let cell = |(name, values): &(String, Vec<f64>)| format!("\"{name}\": {}", values[k]);
        let all: Vec<String> = columns.iter().map(cell).collect();
        write!(
            text,
            "{}{{{}}}",
            if k == 0 { "" } else { ",\n" },
            all.join(", ")
        )
        .unwrap();
    }
    text + "]"
}

#[test]
fn recordings_of_any_shape_are_read_without_an_edit() {
    let (_, log) = log();
    let of = |names: &[(&str, usize)]| columns(&log, names);
    let (q, phi, tau) = (("q*", Q), ("phi*", PHI), ("tau*", TAU));
    let named = |file: &str, text: String| (file.to_owned(), text);
    let with_units = |names: &[(&str, usize)], units: &str| {
        csv(&of(names)).replacen('\n', &format!("\n{units}\n"), 1)
    };
    let all = [("time", T), q, phi, tau];
    let plain = [
        "link_position_rad = [\"q1\", \"q2\"]",
        "motor_position_rad = [\"phi1\", \"phi2\"]",
    ];
    for (files, lines, said) in [
        (
            vec![
                named("positions.csv", csv(&of(&[("time", T), q, phi]))),
                named("efforts.csv", csv(&of(&[("time", T), tau]))),
            ],
            vec![
                "file = \"../positions.csv\"",
                "motor_torque = { file = \"../efforts.csv\", time = \"time\", column = [\"tau1\", \"tau2\"], unit = \"N·m\" }",
            ],
            "efforts.csv is another part of the same recording, joined by \"time\"",
        ),
        // The names of the files say what their columns are.
        (
            vec![
                named("link_position.csv", csv(&of(&[("t", T), ("j*", Q)]))),
                named("motor_torque.csv", csv(&of(&[("t", T), ("j*", TAU)]))),
                named("motor_position.csv", csv(&of(&[("t", T), ("j*", PHI)]))),
            ],
            vec![
                "link_position_rad = [\"j1\", \"j2\"]",
                "motor_position = { file = \"../motor_position.csv\", time = \"t\", column = [\"j1\", \"j2\"], unit = \"rad\" }",
                "motor_torque = { file = \"../motor_torque.csv\", time = \"t\", column = [\"j1\", \"j2\"], unit = \"N·m\" }",
            ],
            "motor_position.csv is another part",
        ),
        (
            vec![named(
                "run.csv",
                with_units(&all, "s,rad,rad,rad,rad,N·m,N·m"),
            )],
            [
                &plain[..],
                &[
                    "motor_torque_nm = [\"tau1\", \"tau2\"]",
                    "time_s = \"time\"",
                ],
            ]
            .concat(),
            "",
        ),
        (
            vec![named(
                "run.csv",
                with_units(
                    &[("clock", T), ("enc*", Q), ("motor_enc*", PHI), tau],
                    "[s],[rad],[rad],,,[Nm],[Nm]",
                ),
            )],
            vec![
                "time_s = \"clock\"",
                "link_position_rad = [\"enc1\", \"enc2\"]",
            ],
            "",
        ),
        (
            vec![named(
                "run.csv",
                without_header(&csv(&of(&[phi, ("dphi*", RATE), tau]))),
            )],
            vec![
                "motor_position_rad = [1, 2]",
                "motor_torque_nm = [5, 6]",
                "period_s = 0.002",
            ],
            "",
        ),
        (
            vec![named("run.json", json(&of(&all), true))],
            [&plain[..], &["motor_torque_nm = [\"tau1\", \"tau2\"]"]].concat(),
            "",
        ),
        (
            vec![named("run.json", json(&of(&all), false))],
            vec![
                "link_position_rad = [\"log.q1\", \"log.q2\"]",
                "time_s = \"log.time\"",
            ],
            "",
        ),
    ] {
        is_read(&files, &lines, said);
    }
}

/// Checks that a template for files has these lines, says something, and is identified.
fn is_read(files: &[(String, String)], lines: &[&str], said: &str) {
    let desk = arm();
    let mut args = vec!["new", "exp", "--urdf", "arm.urdf"];
    for (file, text) in files {
        desk.write(file, text);
        args.extend(["--log", file]);
    }
    let output = desk.run(&args);
    let told = &output.out;
    assert_eq!(output.code, Some(0), "{args:?}: {told}");
    let text = desk.read("exp/experiment.toml");
    for line in lines {
        assert!(text.contains(&format!("\n{line}\n")), "{line}: {told}");
    }
    contains(told, &[said]);
    // Joints with one position are rigid and have no stiffness.
    if text.contains("link_position_rad = [") {
        is_identified(&desk);
    }
}

/// A desk with the arm.
fn arm() -> Desk {
    let desk = Desk::new();
    desk.write("arm.urdf", ARM);
    desk
}

#[test]
fn two_recordings_are_not_joined_and_blocks_need_one_torque() {
    let (desk, log) = log();
    let mut later = log.clone();
    later[T].iter_mut().for_each(|time| *time += 100.0);
    let [one, two] = [
        columns(&log, &[("time", T), ("q*", Q)]),
        columns(&later, &[("time", T), ("tau*", TAU)]),
    ];
    desk.write("one.csv", csv(&one));
    desk.write("two.csv", csv(&two));
    let logs = ["--log", "one.csv", "--log", "two.csv"];
    let args = [&["new", "new", "--urdf", "arm.urdf"][..], &logs].concat();
    desk.fails(
        &args,
        2,
        &[
            "two.csv has no \"q1\", which one.csv has",
            "the files of one recording",
        ],
    );
    let two_torques = columns(
        &log,
        &[("q*", Q), ("dq*", RATE), ("tau*", TAU), ("tau*", TAU)],
    );
    desk.write("blocks.csv", without_header(&csv(&two_torques)));
    let output = desk.run(&["new", "blocks", "--urdf", "arm.urdf", "--log", "blocks.csv"]);
    assert_ne!(output.code, Some(0), "{}", output.err);
}

#[test]
fn formats_that_sprung_does_not_read_are_named_with_the_line_that_converts_them() {
    // A zip archive of one empty member.
    let zip = |name: &str| {
        let (mut local, mut entry) = (b"PK\x03\x04".to_vec(), b"PK\x01\x02\x14\0".to_vec());
        let sizes = [
            &[20, 0, 0, 0, 0, 0, 0, 0, 0, 0][..],
            &[0; 12],
            &[name.len() as u8, 0, 0, 0],
        ]
        .concat();
        local.extend(&sizes);
        local.extend(name.as_bytes());
        entry.extend(&sizes);
        entry.extend([0; 14]);
        entry.extend(name.as_bytes());
        let (at, length) = (local.len() as u8, entry.len() as u8);
        let end = [
            &b"PK\x05\x06\0\0\0\0\x01\0\x01\0"[..],
            &[length, 0, 0, 0, at, 0, 0, 0, 0, 0],
        ]
        .concat();
        [local, entry, end].concat()
    };
    #[rustfmt::skip]
    let rows = [
        (zip("xl/workbook.xml"), "is a spreadsheet; save it as CSV: pandas.read_excel("),
        (zip("run/data.pkl"), "is a file of PyTorch; write its arrays: d = torch.load("),
        (b"\x80\x04\x95\0\0".to_vec(), "is a pickle of Python, which can run code and is not read"),
        (b"#ROSBAG V2.0\n\0".to_vec(), "pip install rosbags; rosbags-convert --src run.bag --dst run"),
        (b"[{\"t\": 0}, {".to_vec(), "is JSON: EOF while parsing"),
        (b"{\"robot\": \"arm\"}".to_vec(), "is JSON without lists of numbers or of samples"),
    ];
    each(rows, |(bytes, said)| {
        let desk = arm();
        desk.write("run", bytes);
        desk.fails(
            &["new", "new", "--urdf", "arm.urdf", "--log", "run"],
            3,
            &[said],
        );
    });
}

#[test]
fn some_joints_have_currents_and_others_forces() {
    let desk = Desk::new();
    let link = |name: &str| {
        format!(
            "<link name=\"{name}\"><inertial><origin xyz=\"0.2 0 0\"/><mass value=\"2\"/><inertia ixx=\"0.01\" ixy=\"0\" \
             ixz=\"0\" iyy=\"0.05\" iyz=\"0\" izz=\"0.05\"/></inertial></link>"
        )
    };
    let joint = |name: &str, kind: &str, parent: &str, child: &str| {
        format!(
            "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/><axis xyz=\"0 1 0\"/>\
             <limit lower=\"-3\" upper=\"3\" effort=\"50\" velocity=\"5\"/></joint>"
        )
    };
    let links = link("sled") + &link("arm");
    let joints =
        joint("slide", "prismatic", "base", "sled") + &joint("turn", "revolute", "sled", "arm");
    desk.write(
        "lift.urdf",
        format!("<robot name=\"lift\"><link name=\"base\"/>{links}{joints}</robot>"),
    );
    let mut text = "t,slide_position,turn_position,slide_force,turn_current\n".to_owned();
    for k in 0..4000 {
        let t = 0.002 * f64::from(k);
        let (x, q) = ((2.0 * t).sin(), (3.1 * t).sin());
        let (v, w) = (2.0 * (2.0 * t).cos(), 3.1 * (3.1 * t).cos());
        writeln!(
            text,
            "{t},{x},{q},{},{}",
            3.0 * v - 8.0 * x,
            0.2 * w - 0.9 * q
        )
        .unwrap();
    }
    desk.write("log.csv", &text);
    desk.run(&["new", "exp", "--urdf", "lift.urdf", "--log", "log.csv"])
        .ends(0);
    let text = desk.read("exp/experiment.toml");
    has_lines(
        &text,
        &[
            "motor_force_n = [\"slide_force\"]",
            "motor_current_a = [\"turn_current\"]",
        ],
    );
    assert_eq!(
        text.matches("\ntorque_constant_nm_per_a = \"FILL IN\"")
            .count(),
        1,
        "{text}"
    );
    let constant = "\ntorque_constant_nm_per_a = \"FILL IN\"";
    desk.write(
        "exp/experiment.toml",
        text.replace(constant, "\ntorque_constant_nm_per_a = 2.0"),
    );
    let output = desk.run(&["check", "exp"]);
    assert!(matches!(output.code, Some(0 | 3)), "{}", output.err);
    output.prints(&["turn_current"]);
}

#[test]
fn the_filters_follow_the_rate_from_20_hz() {
    let (desk, log) = log();
    for (every, cutoff) in [(15, 10.0), (25, 6.0), (1, 30.0)] {
        let mut slow = columns(&log, &[("time", T), ("phi*", PHI), ("tau*", TAU)]);
        for (_, values) in &mut slow {
            *values = values.iter().copied().step_by(every).collect();
        }
        desk.log(&slow);
        let folder = format!("at{every}");
        desk.succeeds(&["new", &folder, "--urdf", "arm.urdf", "--log", "log.csv"]);
        for verb in ["check", "identify"] {
            let output = desk.run(&[verb, &folder]);
            output.has_a_result();
            let told = output.out + &output.err;
            assert!(
                !told.contains("filter-cutoff") && !told.contains("too short"),
                "{told}"
            );
        }
        let json = desk.read(&format!("{folder}/sprung-out/identification.json"));
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        let used = f64_of(&json["settings"]["filter_cutoff_rad_per_s"]);
        assert!((used / cutoff - 1.0_f64).abs() < 1e-9, "{used}");
    }
}
