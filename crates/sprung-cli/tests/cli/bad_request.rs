//! Requests that cannot be meant: wrong verbs, flags, values of keys, and files in the wrong place. Every message names
//! the input and the remedy.

use sprung_testing::Messages;

use crate::common::{Case, messages, sprung};

const WRONG_KEYS_OF_LOG: &[&str] = &[
    "log",
    "=3",
    "log.file=",
    "log.link_position_rad=q1_rad",
    "log.link_position_rad=[\"a\",\"b\",\"c\"]",
    "log.link_position_deg=[\"q1_rad\",\"q2_rad\"]",
    "log.link_position={topic=\"/js\",unit=\"rad\"}",
    "log.motor_torque_nm=[\"tau1_nm\",\"tau1_nm\"]",
    "log.time_ms=\"t_s\"",
    "log.nan=drop",
    "log.sampling=never",
    "log.sign.q1_rad=0",
    "log.sign.nope=1",
    "log.gain.q1_rad=-1",
    "log.delay_s.q1_rad=1e300",
    "log.period_s=-1",
    "log.motor_position_side=left",
    "log.csv.delimiter=\";;\"",
    "log.csv.decimal=x",
    "log.csv.skip_lines=-1",
    "log.file={path=\"identification.csv\",from_s=5,to_s=4}",
    "log.file={path=\"identification.csv\",form_s=2}",
];

const KEYS_OF_ANOTHER_LOG: &[&str] = &[
    "log.time_s=99",
    "log.time_s=T_S",
    "log.csv.delimiter=\";\"",
    "log.csv.skip_lines=99999",
    "log.file={path=\"identification.csv\",from_s=1e300}",
    "log.file=truth.toml",
    "log.link_position_rad=[\"q1\",\"q2\"]",
];

const KEYS_OF_ABSENT_FILES: &[&str] = &[
    "log.file=gone.csv",
    "log.file=bags",
    "log.file=[\"identification.csv\",\"gone.csv\"]",
];

const WRONG_KEYS_OF_THE_REST: &[&str] = &[
    "robot.joint.joint3.gear_ratio=1",
    "robot.joint.0.gear_ratio=0",
    "robot.joint.joint1.transmission=soft",
    "robot.joint.joint1.motor_friction=[\"stiction\"]",
    "robot.kinematics=planar-3r",
    "robot.urdf=arm.urdf",
    "identify.estimator=least-square",
    "identify.estimator=[]",
    "identify.position_filter_order=0",
    "identify.filter_cutoff_rad_per_s=-5",
    "identify.lsff_initial_gain=10.0",
    "control.vibrations=log",
    "log.gyroscope_x_deg_per_s=[\"a\"]",
    "controller.kp_nm_per_rad=[1,2,3]",
    "controller.kind=lqr",
    "controller.friction_compensation_speed_rad_per_s=0.05",
    "validate=[{}]",
    "simulate.duration_s=0",
    "simulate.duration_s=1e300",
    "format=2",
];

const WRONG_COMMANDS: &[(&str, i32)] = &[
    ("identfy @experiment.toml", 2),
    ("identify @experiment.toml @experiment.toml", 2),
    ("identify @experiment.toml --threads 0", 2),
    ("check @experiment.toml --thorough", 2),
    ("check @experiment.toml --thorough --json", 2),
    ("identify @experiment.toml --set", 2),
    ("identify @empty.toml", 2),
    ("identify @empty", 4),
    ("identify @experiment.toml --out @experiment.toml", 4),
    ("validate @experiment.toml", 4),
    ("validate @experiment.toml --parameters @gone.json", 4),
    ("validate @experiment.toml --parameters @experiment.toml", 2),
    (
        "validate @experiment.toml --parameters @identification.csv",
        2,
    ),
    ("compare @gone", 4),
    ("compare @empty", 4),
    ("compare @experiment.toml", 2),
    ("simulate @experiment.toml --run nope", 2),
    ("simulate @experiment.toml --parameters @gone.toml", 4),
    ("new @experiment.toml", 2),
    ("new @", 2),
    ("new @arm --urdf @gone.urdf", 4),
    ("new @arm --joints 0", 2),
    ("new @arm --joints 99", 2),
    ("demo --out @experiment.toml", 4),
    ("demo --seed x", 2),
];

/// Runs `identify` with an assignment to a key, checks the exit code and notes the message.
#[track_caller]
fn assignment(messages: &mut Messages, case: &Case, code: i32, text: &str) {
    messages.note(text, &case.refused(code, &["--set", text]));
}

#[test]
fn keys_of_the_log() {
    let mut messages = messages("keys_of_the_log");
    let case = Case::new();
    for text in WRONG_KEYS_OF_LOG {
        assignment(&mut messages, &case, 2, text);
    }
    for text in KEYS_OF_ANOTHER_LOG {
        assignment(&mut messages, &case, 3, text);
    }
    std::fs::create_dir(case.path("bags")).unwrap();
    for text in KEYS_OF_ABSENT_FILES {
        assignment(&mut messages, &case, 4, text);
    }
    case.write("results.json", "{\n  \"format\": 1\n}\n");
    assignment(&mut messages, &case, 3, "log.file=results.json");
    messages.compare();
}

#[test]
fn keys_of_robot_controller_and_estimation() {
    let mut messages = messages("keys_of_robot_controller_and_estimation");
    let case = Case::new();
    for text in WRONG_KEYS_OF_THE_REST {
        assignment(&mut messages, &case, 2, text);
    }
    messages.compare();
}

#[test]
fn verbs_flags_and_their_files() {
    let mut messages = messages("verbs_flags_and_their_files");
    let case = Case::new();
    case.write("empty.toml", "");
    std::fs::create_dir(case.path("empty")).unwrap();
    let run = |words: &str| {
        let words: Vec<String> = (words.split(' '))
            .map(|word| match word.strip_prefix('@') {
                Some(file) => case.at(file),
                None => word.to_owned(),
            })
            .collect();
        sprung(&words.iter().map(String::as_str).collect::<Vec<_>>())
    };
    for (words, code) in WRONG_COMMANDS {
        let output = run(words);
        let message = case.message(&output);
        assert_eq!(output.code, Some(*code), "{words}: {message}");
        messages.note(words, &message);
    }
    assert!(!case.path("arm").exists());
    messages.compare();
}
