//! Requests that cannot be meant: wrong verbs, flags, values of keys, and files in the wrong place. Every message names
//! the input and the remedy.

use crate::common::{Case, sprung, stderr};

const WRONG_KEYS_OF_LOG: &[(&str, &[&str])] = &[
    ("log", &["log: write it as key.path=value"]),
    ("=3", &["unquoted keys cannot be empty"]),
    (
        "log.file=",
        &["file in [log] is an empty name", "path of the log"],
    ),
    (
        "log.link_position_rad=q1_rad",
        &["names 1 columns", "2 joints (joint1, joint2)"],
    ),
    (
        "log.link_position_rad=[\"a\",\"b\",\"c\"]",
        &["names 3 columns", "2 joints"],
    ),
    (
        "log.link_position_deg=[\"q1_rad\",\"q2_rad\"]",
        &["both give the link positions", "keep one"],
    ),
    (
        "log.link_position={topic=\"/js\",unit=\"rad\"}",
        &["both give the link positions", "keep one"],
    ),
    (
        "log.motor_torque_nm=[\"tau1_nm\",\"tau1_nm\"]",
        &["\"tau1_nm\" is named twice"],
    ),
    (
        "log.time_ms=\"t_s\"",
        &["time_s and time_ms both give the time", "keep one"],
    ),
    (
        "log.nan=drop",
        &["unknown nan \"drop\"", "use \"refuse\" or \"gap\""],
    ),
    (
        "log.sampling=never",
        &["unknown sampling \"never\"", "did you mean \"even\"?"],
    ),
    (
        "log.sign.q1_rad=0",
        &["the sign of \"q1_rad\" is 0", "must be 1 or -1"],
    ),
    ("log.sign.nope=1", &["\"nope\", which is not a column"]),
    (
        "log.gain.q1_rad=-1",
        &["the gain of \"q1_rad\" is -1", "use sign"],
    ),
    (
        "log.delay_s.q1_rad=1e300",
        &["the delay of \"q1_rad\" is 1e300 s", "within ±60 s"],
    ),
    ("log.period_s=-1", &["period_s = -1 must be positive"]),
    (
        "log.motor_position_side=left",
        &["unknown side \"left\"", "\"output\" or \"motor\""],
    ),
    (
        "log.csv.delimiter=\";;\"",
        &["\";;\" is not understood", "one character"],
    ),
    ("log.csv.decimal=x", &["decimal = \"x\" is not understood"]),
    (
        "log.csv.skip_lines=-1",
        &["`-1`", "expected a whole number from 0"],
    ),
    (
        "log.file={path=\"identification.csv\",from_s=5,to_s=4}",
        &["from 5 s to 4 s", "is empty"],
    ),
    (
        "log.file={path=\"identification.csv\",form_s=2}",
        &["\"form_s\"", "did you mean \"from_s\"?"],
    ),
];

const KEYS_OF_ANOTHER_LOG: &[(&str, &[&str])] = &[
    ("log.time_s=99", &["no column \"99\"", "it has 7 columns"]),
    (
        "log.time_s=T_S",
        &["no column \"T_S\"", "did you mean \"t_s\"?"],
    ),
    (
        "log.csv.delimiter=\";\"",
        &["no column \"t_s\"", "t_s,q1_rad"],
    ),
    (
        "log.csv.skip_lines=99999",
        &["ends before skip_lines = 99999"],
    ),
    (
        "log.file={path=\"identification.csv\",from_s=1e300}",
        &["from 1e300 s", "end at 9.999 s"],
    ),
    ("log.file=truth.toml", &["has no column \"t_s\""]),
    (
        "log.link_position_rad=[\"q1\",\"q2\"]",
        &["no column \"q1\"", "its columns are t_s, q1_rad"],
    ),
];

const KEYS_OF_ABSENT_FILES: &[(&str, &[&str])] = &[
    ("log.file=gone.csv", &["cannot read", "gone.csv"]),
    (
        "log.file=bags",
        &["it is a folder without .mcap or .db3 file"],
    ),
    (
        "log.file=[\"identification.csv\",\"gone.csv\"]",
        &["cannot read", "gone.csv"],
    ),
];

const WRONG_KEYS_OF_THE_REST: &[(&str, &[&str])] = &[
    (
        "robot.joint.joint3.gear_ratio=1",
        &["no element \"joint3\"", "2 (joint1, joint2)"],
    ),
    (
        "robot.joint.0.gear_ratio=0",
        &["joint1: gear_ratio = 0 must be finite and not zero"],
    ),
    (
        "robot.joint.joint1.transmission=soft",
        &["unknown transmission \"soft\"", "\"rigid\""],
    ),
    (
        "robot.joint.joint1.motor_friction=[\"stiction\"]",
        &["unknown friction law \"stiction\"", "\"stribeck\""],
    ),
    (
        "robot.kinematics=planar-3r",
        &["unknown kinematics", "did you mean \"planar-2r\"?"],
    ),
    (
        "robot.urdf=arm.urdf",
        &["kinematics and urdf both describe the kinematics"],
    ),
    (
        "identify.estimator=least-square",
        &["did you mean \"least-squares\"?"],
    ),
    (
        "identify.estimator=[]",
        &["the list of estimators is empty"],
    ),
    (
        "identify.position_filter_order=0",
        &["must be between 1 and 10"],
    ),
    (
        "identify.filter_cutoff_rad_per_s=-5",
        &["= -5 must be positive"],
    ),
    (
        "identify.lsff_initial_gain=10.0",
        &[
            "unknown key \"lsff_initial_gain\" in [identify]",
            "there is no successor",
        ],
    ),
    (
        "log.gyroscope_x_deg_per_s=[\"a\"]",
        &["write gyroscope_deg_per_s.x = …"],
    ),
    (
        "controller.kp_nm_per_rad=[1,2,3]",
        &["needs 2 numbers in kp_nm_per_rad, one per joint"],
    ),
    (
        "controller.kind=lqr",
        &["unknown controller \"lqr\"", "\"pd\" or \"state-feedback\""],
    ),
    (
        "controller.friction_compensation_speed_rad_per_s=0.05",
        &["friction_compensation_speed_rad_per_s belongs to controller \"state-feedback\""],
    ),
    ("validate=[{}]", &["missing field `name`"]),
    (
        "simulate.duration_s=0",
        &["duration_s = 0 must be positive"],
    ),
    ("simulate.duration_s=1e300", &["more than 1e9 samples"]),
    ("format=2", &["format 2 is not known", "reads format 1"]),
];

const WRONG_COMMANDS: &[(&str, i32, &[&str])] = &[
    ("identfy @experiment.toml", 2, &["identfy", "identify"]),
    (
        "identify @experiment.toml @experiment.toml",
        2,
        &["unexpected argument"],
    ),
    (
        "identify @experiment.toml --threads 0",
        2,
        &["'0'", "1..=256"],
    ),
    (
        "identify @experiment.toml --set",
        2,
        &["a value is required for '--set"],
    ),
    (
        "identify @empty.toml",
        2,
        &[
            "missing field `format`",
            "begins with format = 1",
            "sprung new",
        ],
    ),
    (
        "identify @empty",
        4,
        &["there is no experiment file", "sprung new"],
    ),
    (
        "identify @experiment.toml --out @experiment.toml",
        4,
        &["cannot create the folder", "choose another"],
    ),
    (
        "validate @experiment.toml",
        4,
        &["no identification.json", "run sprung identify first"],
    ),
    (
        "validate @experiment.toml --parameters @gone.json",
        4,
        &["cannot read", "gone.json"],
    ),
    (
        "validate @experiment.toml --parameters @experiment.toml",
        2,
        &["is not a file of parameters", "give an identification.json"],
    ),
    (
        "validate @experiment.toml --parameters @identification.csv",
        2,
        &["is not a file of parameters", "give an identification.json"],
    ),
    ("compare @gone", 4, &["cannot read", "gone"]),
    (
        "compare @empty",
        4,
        &[
            "no identification.json in the folder",
            "run sprung identify first",
        ],
    ),
    (
        "compare @experiment.toml",
        2,
        &["it looks like an experiment file"],
    ),
    (
        "simulate @experiment.toml --run nope",
        2,
        &["\"nope\"", "direct, prediction"],
    ),
    (
        "simulate @experiment.toml --parameters @gone.toml",
        4,
        &["cannot read", "gone.toml"],
    ),
    ("new @experiment.toml", 2, &["is a file", "give the folder"]),
    ("new @", 2, &["exists already and is not overwritten"]),
    (
        "new @arm --urdf @gone.urdf",
        4,
        &["cannot read", "gone.urdf"],
    ),
    ("new @arm --joints 0", 2, &["1 to 32 joints, not for 0"]),
    ("new @arm --joints 99", 2, &["1 to 32 joints, not for 99"]),
    (
        "demo --out @experiment.toml",
        4,
        &["cannot create the folder"],
    ),
    ("demo --seed x", 2, &["'x'", "--seed"]),
];

/// Runs `identify` with an assignment to a key, and checks the exit code and the message.
#[track_caller]
fn assignment(case: &Case, code: i32, text: &str, fragments: &[&str]) {
    let output = case.identify(&["--set", text]);
    let message = stderr(&output);
    println!("{message}");
    assert_eq!(output.status.code(), Some(code), "{text}: {message}");
    assert_eq!(message.trim().lines().count(), 1, "{message}");
    for fragment in fragments {
        assert!(
            message.contains(fragment),
            "{text}: no {fragment:?} in: {message}"
        );
    }
    assert!(!case.path("sprung-out").exists(), "{text} left results");
}

#[test]
fn keys_of_the_log() {
    let case = Case::new();
    for (text, fragments) in WRONG_KEYS_OF_LOG {
        assignment(&case, 2, text, fragments);
    }
    for (text, fragments) in KEYS_OF_ANOTHER_LOG {
        assignment(&case, 3, text, fragments);
    }
    std::fs::create_dir(case.path("bags")).unwrap();
    for (text, fragments) in KEYS_OF_ABSENT_FILES {
        assignment(&case, 4, text, fragments);
    }
}

#[test]
fn keys_of_robot_controller_and_estimation() {
    let case = Case::new();
    for (text, fragments) in WRONG_KEYS_OF_THE_REST {
        assignment(&case, 2, text, fragments);
    }
}

#[test]
fn verbs_flags_and_their_files() {
    let case = Case::new();
    std::fs::write(case.path("empty.toml"), "").unwrap();
    std::fs::create_dir(case.path("empty")).unwrap();
    let run = |words: &str| {
        let words: Vec<String> = (words.split(' '))
            .map(|word| match word.strip_prefix('@') {
                Some(file) => case.path(file).to_str().unwrap().to_owned(),
                None => word.to_owned(),
            })
            .collect();
        sprung(&words.iter().map(String::as_str).collect::<Vec<_>>())
    };
    for (words, code, fragments) in WRONG_COMMANDS {
        let output = run(words);
        let message = stderr(&output);
        println!("{message}");
        assert_eq!(output.status.code(), Some(*code), "{words}: {message}");
        for fragment in *fragments {
            assert!(
                message.contains(fragment),
                "{words}: no {fragment:?} in: {message}"
            );
        }
    }
    assert!(!case.path("arm").exists());
}

#[test]
fn huge_constants_and_results_given_as_logs() {
    let case = Case::new();
    let constant = Case::new().column(4, |_| 1e308);
    constant.fails(
        3,
        &["\"phi2_rad\" never changes (1e308 rad in all 10000 samples)"],
    );
    std::fs::write(case.path("results.json"), "{\n  \"format\": 1\n}\n").unwrap();
    assignment(
        &case,
        3,
        "log.file=results.json",
        &["is JSON", "give the log as CSV"],
    );
}
