//! `sprung identify --urdf --log` writes the experiment of `sprung new` and identifies, or names the missing input.

use crate::common::{Ran, contains, list_of, messages};
use crate::new::{ARM, Desk};
use crate::renamed_log::{LEAST_SQUARES, Renamed, column, csv, named, plain, recorded};

/// A column: its name, its number in the log of the twin, and a factor.
const RIGID: [Renamed<'static>; 5] = [
    column("t", 0, 1.0),
    column("q1", 3, 1.0),
    column("q2", 4, 1.0),
    column("tau1", 5, 1.0),
    column("tau2", 6, 1.0),
];

/// A desk with the arm, and `run.csv` with these columns of the log of its twin.
fn desk(columns: &[Renamed<'_>]) -> Desk {
    let (desk, log) = recorded();
    desk.write("run.csv", csv(&named(&log, columns)));
    desk
}

const FROM_LOG: [&str; 5] = ["identify", "--urdf", "arm.urdf", "--log", "run.csv"];

/// Identifies from the robot and the log.
fn identify(desk: &Desk, more: &[&str]) -> Ran {
    desk.run(&[&FROM_LOG[..], &["--set", LEAST_SQUARES], more].concat())
}

#[test]
fn a_rigid_arm_needs_no_file() {
    let desk = desk(&RIGID);
    let Ran {
        code,
        out: said,
        err: message,
    } = identify(&desk, &[]);
    assert!(matches!(code, Some(0 | 1)), "{message}");
    contains(
        &said,
        &[
            "experiment: sprung-run/experiment.toml;",
            "joints: shoulder, elbow\n",
            "  time_s = \"t\"\n",
            "  motor_position_rad = [\"q1\", \"q2\"]\n",
            "  motor_torque_nm = [\"tau1\", \"tau2\"]\n",
            "report: sprung-run/sprung-out/report.html\n",
        ],
    );
    // The file is that of `new`.
    desk.succeeds(&["new", "same", "--urdf", "arm.urdf", "--log", "run.csv"]);
    let text = desk.read("sprung-run/experiment.toml");
    assert_eq!(text, desk.read("same/experiment.toml"));
    // The other commands take the folder.
    for command in [
        &["check", "sprung-run"][..],
        &["validate", "sprung-run"],
        &["export", "sprung-run", "--format", "urdf"],
        &["identify", "sprung-run", "--set", LEAST_SQUARES],
    ] {
        let output = desk.run(command);
        let code = output.code;
        assert!(matches!(code, Some(0 | 1)), "{command:?}: {}", output.err);
    }
    assert!(!desk.path("sprung-run/sprung-out/sprung-out").exists());
}

#[test]
fn another_experiment_is_replaced_only_by_force() {
    let desk = desk(&RIGID);
    let first = identify(&desk, &[]);
    assert_eq!(identify(&desk, &[]), first);
    let text = desk.read("sprung-run/experiment.toml");
    desk.write("sprung-run/experiment.toml", format!("{text}# mine\n"));
    desk.fails(
        &FROM_LOG,
        2,
        &[
            "sprung-run/experiment.toml exists already and is not what this robot and log give",
            "sprung identify sprung-run identifies with it",
            "--out DIR chooses another folder, and --force replaces it",
        ],
    );
    assert!(
        desk.read("sprung-run/experiment.toml")
            .ends_with("# mine\n")
    );
    assert_eq!(identify(&desk, &["--force"]), first);
    assert_eq!(desk.read("sprung-run/experiment.toml"), text);
    // The log is no place for the experiment.
    desk.fails(
        &[&FROM_LOG[..], &["--out", "run.csv"]].concat(),
        2,
        &["run.csv is a file; give the folder for experiment.toml"],
    );
}

#[test]
fn a_flexible_arm_with_all_columns_needs_no_file() {
    let desk = desk(&plain(
        "t=0, link_q1=1, link_q2=2, motor_q1=3, motor_q2=4, tau1=5, tau2=6",
    ));
    let Ran {
        code,
        out: said,
        err: message,
    } = identify(&desk, &["--out", "my results", "--json"]);
    assert!(matches!(code, Some(0 | 1)), "{message}");
    let result: serde_json::Value = serde_json::from_str(&said).unwrap();
    let all = list_of(&result["results"][0]["parameters"]);
    let stiffness = all.iter().find(|one| one["name"] == "shoulder.stiffness");
    let stiffness = stiffness.unwrap()["value"].as_f64().unwrap();
    assert!((stiffness / 900.0 - 1.0).abs() < 0.05, "{stiffness}");
    assert!(desk.path("my results/experiment.toml").exists());
    assert!(
        desk.path("my results/sprung-out/identification.json")
            .exists()
    );
}

#[test]
fn what_the_log_does_not_tell_is_named_with_its_line() {
    let desk = desk(&[
        column("t", 0, 1.0),
        column("q1", 3, 1.0),
        column("q2", 4, 1.0),
        column("i1_A", 5, 0.1),
        column("i2_A", 6, 0.1),
    ]);
    let command = "sprung new new --urdf arm.urdf --log run.csv";
    let args = [&FROM_LOG[..], &["--out", "new"]].concat();
    let message = desk.run(&args).err;
    desk.fails(
        &args,
        3,
        &[
            "arm.urdf and run.csv do not tell everything",
            &format!("{command} writes the experiment file"),
        ],
    );
    // The command that the message names writes these lines.
    let said = desk.succeeds(&command.split(' ').skip(1).collect::<Vec<_>>());
    let text = desk.read("new/experiment.toml");
    let open: Vec<usize> = (text.lines().zip(1..))
        .filter(|(line, _)| line.ends_with("= \"FILL IN\""))
        .map(|(_, number)| number)
        .collect();
    assert!(!open.is_empty(), "{said}");
    for number in open {
        let named = format!("line {number} (torque_constant_nm_per_a)");
        assert!(message.contains(&named), "no {named:?} in: {message}");
    }
}

#[test]
fn a_log_that_contradicts_its_names_is_refused() {
    // The torques are exchanged.
    let columns = plain("t=0, q1=1, q2=2, phi1=3, phi2=4, tau1=6, tau2=5");
    let desk = desk(&columns);
    desk.fails(
        &[&FROM_LOG[..], &["--out", "new"]].concat(),
        3,
        &[
            "run.csv contradicts what its names and values say: ",
            "sprung new new --urdf arm.urdf --log run.csv writes the experiment file for you to correct",
        ],
    );
}

#[test]
fn robot_log_and_experiment_exclude_or_need_each_other() {
    let mut messages = messages("robot_log_and_experiment_exclude_or_need_each_other");
    let desk = Desk::new();
    desk.write("arm.urdf", ARM);
    for args in [
        &["--urdf", "arm.urdf"][..],
        &["--log", "run.csv"],
        &["my-arm", "--log", "run 7.csv"],
        &["my-arm", "--urdf", "arm.urdf", "--log", "run.csv"],
        &["my-arm", "--urdf", "arm.urdf"],
        &["my-arm", "--force"],
        &[],
    ] {
        let args = [&["identify"], args].concat();
        messages.note(&args.join(" "), &desk.refused(&args, 2));
    }
    let args = ["identify", "--urdf", "arm.urdf", "--log", "none.csv"];
    messages.note(&args.join(" "), &desk.refused(&args, 4));
    assert!(!desk.path("sprung-none").exists());
    messages.compare();
}
