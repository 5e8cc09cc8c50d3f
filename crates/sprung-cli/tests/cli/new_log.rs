//! `sprung new --log` chooses columns, units and sides by names and values, and leaves FILL IN where the log does not
//! decide.

use std::fmt::Write as _;

use crate::common::{contains, has_lines, messages};
use crate::new::{ARM, Desk};
use crate::renamed_log::{
    Columns, LEAST_SQUARES, Renamed, begun, column, csv, is_identified, named, plain, recorded,
};

#[test]
fn names_decide_and_nothing_is_left_to_fill_in() {
    let (desk, log) = recorded();
    let names = [
        column("time_ms", 0, 1e3),
        column("shoulder_pos", 1, 1.0),
        column("elbow_pos", 2, 1.0),
        column("shoulder_motor_pos", 3, 1.0),
        column("elbow_motor_pos", 4, 1.0),
        column("shoulder_torque", 5, 1.0),
        column("elbow_torque", 6, 1.0),
        column("shoulder_cmd", 3, 1.0),
        column("elbow_cmd", 4, 1.0),
        column("shoulder_vel", 2, 1.0),
        column("elbow_vel", 1, 1.0),
    ];
    desk.log(&named(&log, &names));
    let text = begun(&desk, "log.csv");
    has_lines(
        &text,
        &[
            "file = \"../log.csv\"",
            "time_ms = \"time_ms\"",
            "link_position_rad = [\"shoulder_pos\", \"elbow_pos\"]",
            "motor_position_rad = [\"shoulder_motor_pos\", \"elbow_motor_pos\"]",
            "motor_torque_nm = [\"shoulder_torque\", \"elbow_torque\"]",
        ],
    );
    contains(&text, &["# Not used: shoulder_cmd, elbow_cmd,"]);
    is_identified(&desk);
    // Two logs with the same columns; a third with others.
    desk.write("second.csv", csv(&named(&log, &names)));
    let logs = ["--log", "log.csv", "--log", "second.csv"];
    desk.succeeds(&[&["new", "two", "--urdf", "arm.urdf"][..], &logs].concat());
    contains(
        &desk.read("two/experiment.toml"),
        &["file = [\"../log.csv\", \"../second.csv\"]"],
    );
    desk.write("third.csv", csv(&named(&log, &names[..6])));
    let logs = ["--log", "log.csv", "--log", "third.csv"];
    desk.fails(
        &[&["new", "new", "--urdf", "arm.urdf"][..], &logs].concat(),
        2,
        &["third.csv has no \"elbow_torque\", which log.csv has"],
    );
}

#[test]
fn values_tell_the_side_of_the_gearbox_and_degrees() {
    let (desk, log) = recorded();
    let degree = 180.0 / std::f64::consts::PI;
    let names = [
        column("t", 0, 1.0),
        column("enc_a_1", 1, degree),
        column("enc_a_2", 2, degree),
        column("enc_b_1", 3, 100.0),
        column("enc_b_2", 4, -120.5),
        column("torque_1", 5, 0.01),
        column("torque_2", 6, -1.0 / 120.5),
    ];
    desk.log(&named(&log, &names));
    let text = begun(&desk, "log.csv");
    has_lines(
        &text,
        &[
            "link_position_deg = [\"enc_a_1\", \"enc_a_2\"]",
            "motor_position = { column = [\"enc_b_1\", \"enc_b_2\"], unit = \"rad\", sign = [1, -1] }",
            "motor_position_side = \"motor\"",
            "motor_torque_side = \"motor\"",
            "gear_ratio = 100.0",
            "gear_ratio = 120.5",
        ],
    );
    let flat = text.replace("\n# ", " ");
    assert!(flat.contains("In degrees by their values"), "{text}");
    assert!(flat.contains("By the equations of the robot"), "{text}");
    is_identified(&desk);
}

#[test]
fn joints_that_move_only_in_the_middle_of_a_long_log_are_seen() {
    let (desk, mut log) = recorded();
    let rows = log[0].len();
    for column in &mut log[1..] {
        let (first, last) = (column[0], column[rows - 1]);
        *column = [vec![first; 30_000], column.clone(), vec![last; 60_000]].concat();
    }
    log[0] = (0..log[1].len()).map(|k| 0.002 * k as f64).collect();
    let names = plain("t=0, q1=3, q2=4, tau1=5, tau2=6");
    desk.log(&named(&log, &names));
    let text = begun(&desk, "log.csv");
    has_lines(
        &text,
        &[
            "time_s = \"t\"",
            "motor_position_rad = [\"q1\", \"q2\"]",
            "motor_torque_nm = [\"tau1\", \"tau2\"]",
        ],
    );
}

#[test]
fn joints_without_link_encoder_are_rigid() {
    let (desk, log) = recorded();
    let names = plain("t=0, q1=3, q2=4, tau1=5, tau2=6");
    desk.log(&named(&log, &names));
    let text = begun(&desk, "log.csv");
    assert_eq!(
        text.matches("\ntransmission = \"rigid\"\n").count(),
        1,
        "{text}"
    );
    contains(&text, &["\nmotor_position_rad = [\"q1\", \"q2\"]\n"]);
    desk.run(&["identify", "exp", "--set", LEAST_SQUARES])
        .has_a_result();
    // A flexible joint without link position names the way out.
    desk.write(
        "exp/experiment.toml",
        text.replace("\"rigid\"", "\"flexible\""),
    );
    desk.fails(
        &["identify", "exp"],
        2,
        &[
            "[log] has no link position of shoulder",
            "transmission = \"rigid\" in the [[robot.joint]] block of shoulder",
            "link_position_rad = [\"…\"]",
        ],
    );
}

#[test]
fn what_only_the_user_knows_is_named_with_its_line() {
    let (desk, log) = recorded();
    let names = [
        column("t", 0, 1.0),
        column("q1", 3, 1.0),
        column("q2", 4, 1.0),
        column("i1_A", 5, 0.1),
        column("i2_A", 6, 0.1),
    ];
    desk.log(&named(&log, &names));
    let text = begun(&desk, "log.csv");
    contains(&text, &["\nmotor_current_a = [\"i1_A\", \"i2_A\"]\n"]);
    let open = "torque_constant_nm_per_a = \"FILL IN\"";
    let line = 1 + text.lines().position(|line| line == open).unwrap();
    desk.fails(
        &["identify", "exp"],
        2,
        &[
            &format!("line {line} of"),
            "FILL IN torque_constant_nm_per_a: only you know",
        ],
    );
}

#[test]
fn a_table_has_as_many_joints_as_the_log() {
    let (desk, log) = recorded();
    for joints in [1, 3] {
        let mut names = vec![("t".to_owned(), 0)];
        for k in 1..=joints {
            names.push((format!("q{k}"), 3));
            names.push((format!("tau{k}"), 5));
        }
        let names: Vec<Renamed<'_>> = (names.iter())
            .map(|(name, place)| column(name, *place, 1.0))
            .collect();
        desk.log(&named(&log, &names));
        let folder = format!("table-{joints}");
        desk.succeeds(&["new", &folder, "--log", "log.csv"]);
        let text = desk.read(&format!("{folder}/experiment.toml"));
        assert_eq!(
            text.matches("\n[[robot.joint]]\n").count(),
            joints,
            "{text}"
        );
        desk.fails(&["identify", &folder], 2, &["FILL IN dh_modified"]);
    }
}

#[test]
fn joints_that_match_nothing_name_the_nearest() {
    let mut messages = messages("joints_that_match_nothing_name_the_nearest");
    let (desk, log) = recorded();
    let names = plain("t=0, sholder pos=3, elbw pos=4, torque a=5");
    desk.log(&named(&log, &names));
    for (log, code) in [("log.csv", 2), ("none.csv", 4)] {
        let args = ["new", "new", "--urdf", "arm.urdf", "--log", log];
        messages.note(log, &desk.refused(&args, code));
    }
    messages.compare();
}

#[test]
fn two_joints_that_match_one_column_are_named() {
    let (desk, log) = recorded();
    desk.write(
        "arm.urdf",
        ARM.replace("name=\"elbow\"", "name=\"Shoulder\""),
    );
    let names = plain("t=0, shoulder_pos=3, shoulder_torque=5, other_pos=4");
    desk.log(&named(&log, &names));
    let text = begun(&desk, "log.csv");
    let flat = text.replace("\n# ", " ");
    assert!(
        flat.contains("one column matches 2 joints, shoulder and Shoulder"),
        "{text}"
    );
    desk.fails(&["identify", "exp"], 2, &["FILL IN"]);
}

#[test]
fn a_picture_is_no_description() {
    let desk = Desk::new();
    desk.write("arm.urdf", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR");
    desk.fails(
        &["new", "exp", "--urdf", "arm.urdf"],
        4,
        &["cannot read arm.urdf: it is a PNG image, and a text file is needed"],
    );
    let said = desk.run(&["export", "exp", "--format", "usd"]).err;
    contains(
        &said,
        &["[possible values: urdf, mjcf, sdf, json, c, rust]"],
    );
    assert!(!said.contains("similar"), "{said}");
    let version = desk.run(&["--version"]).out;
    let number = version.split_whitespace().nth(1);
    assert_eq!(number, Some(env!("CARGO_PKG_VERSION")), "{version}");
}

#[test]
fn after_an_error_nothing_is_proposed() {
    let (desk, log) = recorded();
    let names = plain("t=0, q1=1, q2=2, phi1=3, phi2=4, tau1=6, tau2=5");
    desk.log(&named(&log, &names));
    let said = desk
        .run(&["new", "exp", "--urdf", "arm.urdf", "--log", "log.csv"])
        .ends(3)
        .out
        .clone();
    assert!(
        said.contains("error (swapped-joints)") && !said.contains("next:"),
        "{said}"
    );
    assert!(desk.path("exp/experiment.toml").exists());
}

#[test]
fn headers_in_other_languages_are_understood() {
    let (desk, log) = recorded();
    let degree = 180.0 / std::f64::consts::PI;
    #[rustfmt::skip]
    let languages = [
        ["Zeit", "Abtriebsposition_N [Grad]", "Motorposition_N [Grad]", "Motordrehmoment_N [Nm]"],
        ["temps", "position sortie N (deg)", "position moteur N (deg)", "couple moteur N (Nm)"],
        ["tiempo", "posición_salida_N [°]", "posición_motor_N [°]", "par_motor_N [Nm]"],
        ["tempo", "posizione_uscita_N_deg", "posizione_motore_N_deg", "coppia_N_Nm"],
        ["时间", "关节位置N_deg", "电机位置N_deg", "电机力矩N_Nm"],
    ];
    for (k, [time, link, motor, torque]) in languages.into_iter().enumerate() {
        let name = |stem: &str, joint: usize| stem.replace('N', &joint.to_string());
        let name = |stem: &str, joint: usize| {
            // The unit N·m keeps its letter.
            name(stem, joint).replace(&format!("{joint}m"), "Nm")
        };
        let names: Vec<(String, usize, f64)> = std::iter::once((time.to_owned(), 0, 1.0))
            .chain((1..=2).flat_map(|joint| {
                [
                    (name(link, joint), joint, degree),
                    (name(motor, joint), joint + 2, degree),
                    (name(torque, joint), joint + 4, 1.0),
                ]
            }))
            .collect();
        let renamed: Vec<Renamed<'_>> = (names.iter())
            .map(|(name, place, factor)| column(name, *place, *factor))
            .collect();
        desk.log(&named(&log, &renamed));
        let folder = format!("language{k}");
        desk.succeeds(&["new", &folder, "--urdf", "arm.urdf", "--log", "log.csv"]);
        let text = desk.read(&format!("{folder}/experiment.toml"));
        for (key, stem) in [
            ("link_position_deg", link),
            ("motor_position_deg", motor),
            ("motor_torque_nm", torque),
        ] {
            let line = format!("{key} = [\"{}\", \"{}\"]", name(stem, 1), name(stem, 2));
            assert!(text.contains(&format!("\n{line}\n")), "{line}: {text}");
        }
    }
}

#[test]
fn lines_to_fill_in_have_the_unit_of_the_header() {
    let (desk, log) = recorded();
    let names = [
        column("t", 0, 1.0),
        column("a_1 [Grad]", 1, 57.3),
        column("a_2 [Grad]", 2, 57.3),
        column("b_1 [Grad]", 3, 57.3),
        column("b_2 [Grad]", 4, 57.3),
        column("torque_1", 5, 1.0),
        column("torque_2", 6, 1.0),
    ];
    desk.log(&named(&log, &names));
    let text = begun(&desk, "log.csv");
    contains(&text, &["\nmotor_position_deg = \"FILL IN\"\n"]);
}

/// A chain of joints with bodies.
fn chain(joints: usize) -> String {
    let mut urdf = String::from("<robot name=\"chain\"><link name=\"l0\"/>\n");
    for k in 1..=joints {
        writeln!(
            urdf,
            "<link name=\"l{k}\"><inertial><origin xyz=\"0.1 0 0\"/><mass value=\"1\"/><inertia ixx=\"0.01\" \
             ixy=\"0\" ixz=\"0\" iyy=\"0.01\" iyz=\"0\" izz=\"0.01\"/></inertial></link>\n\
             <joint name=\"part_{k}\" type=\"revolute\"><parent link=\"l{}\"/><child link=\"l{k}\"/>\
             <origin xyz=\"0.05 0 0\"/><axis xyz=\"0 1 0\"/><limit lower=\"-3\" upper=\"3\" effort=\"9\" \
             velocity=\"2\"/></joint>",
            k - 1
        )
        .unwrap();
    }
    urdf + "</robot>"
}

#[test]
fn six_logged_joints_of_sixty_have_blocks() {
    let desk = Desk::new();
    desk.write("arm.urdf", chain(60));
    let logged = [3, 10, 20, 30, 40, 60];
    let mut columns: Columns = vec![(
        "t".to_owned(),
        (0..2000).map(|k| 0.002 * f64::from(k)).collect(),
    )];
    for (i, k) in logged.iter().enumerate() {
        let wave = |scale: f64, shift: f64| -> Vec<f64> {
            let rate = 0.003 + 0.001 * i as f64;
            (0..2000)
                .map(|n| scale * (rate * f64::from(n) + shift).sin())
                .collect()
        };
        columns.push((format!("part_{k}_pos"), wave(0.5, 0.0)));
        columns.push((format!("part_{k}_torque"), wave(5.0, 0.4)));
    }
    desk.log(&columns);
    let text = begun(&desk, "log.csv");
    assert_eq!(text.matches("\n[[robot.joint]]\n").count(), 6, "{text}");
    for k in logged {
        assert!(
            text.contains(&format!("\nname = \"part_{k}\"")),
            "{k}: {text}"
        );
    }
    contains(
        &text,
        &["# Not in the log, so fixed at zero: part_1, part_2, part_4,"],
    );
    assert!(!text.contains("= \"FILL IN\""), "{text}");
    // The numbers are invented, so the check may refuse them, but the file is complete.
    let output = desk.run(&["check", "exp"]);
    assert_ne!(output.code, Some(2), "{}", output.err);
}
