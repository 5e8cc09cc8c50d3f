//! `sprung control`: a designed controller, its files and its refusals.

use std::fs;
use std::process::Output;

use serde_json::Value;

use crate::common::{Case, demo, messages, sprung, stderr, stdout, without_decimals};

/// Settings of a short design.
const SHORT: [&str; 4] = [
    "control.draws=8",
    "control.poses=3",
    "control.simulations=1",
    "simulate.duration_s=3",
];

/// Designs a controller for the demo's arm into the folder `design` of a case.
fn control(case: &Case, set: &[&str], more: &[&str]) -> Output {
    let (experiment, out) = (case.path("experiment.toml"), case.path("design"));
    let identified = demo().join("sprung-out/identification.json");
    let mut args = vec!["control", experiment.to_str().unwrap()];
    args.extend(["--out", out.to_str().unwrap()]);
    if !more.contains(&"--parameters") {
        args.extend(["--parameters", identified.to_str().unwrap()]);
    }
    for setting in SHORT.iter().chain(set) {
        args.extend(["--set", setting]);
    }
    args.extend(more);
    sprung(&args)
}

fn designed(case: &Case, set: &[&str], more: &[&str]) -> Value {
    let output = control(case, set, &[&["--json"], more].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    serde_json::from_str(&stdout(&output)).unwrap()
}

#[test]
fn a_designed_controller_runs_as_that_of_an_experiment_and_as_code() {
    let case = Case::new();
    let design = designed(&case, &["control.shaper_modes=1"], &[]);
    for margins in design["loops"].as_array().unwrap() {
        assert!(margins["gain_db"]["worst"].as_f64().unwrap() >= 6.0);
        assert!(margins["phase_deg"]["worst"].as_f64().unwrap() >= 40.0);
    }
    for tracking in design["proof"]["tracking"].as_array().unwrap() {
        let designed = tracking["designed_rad"]["worst"].as_f64().unwrap();
        assert!(designed < 0.25 * tracking["declared_rad"].as_f64().unwrap());
    }
    let text = fs::read_to_string(case.path("design/control.html")).unwrap();
    for id in ["loops", "vibrations", "moves", "tracking"] {
        assert!(text.contains(&format!("id=\"{id}\"")), "{id}");
    }
    // The controller replaces that of the experiment, without its reference.
    let written = fs::read_to_string(case.path("design/controller.toml")).unwrap();
    let experiment = case.path("experiment.toml");
    let text = fs::read_to_string(&experiment).unwrap();
    let (before, rest) = text.split_once("[controller] ").unwrap();
    let (_, after) = rest.split_once("[controller.reference]").unwrap();
    let whole = format!("{before}{written}\n[controller.reference]{after}");
    fs::write(&experiment, whole).unwrap();
    let log = case.path("run");
    let simulated = sprung(&[
        "simulate",
        experiment.to_str().unwrap(),
        "--out",
        log.to_str().unwrap(),
        "--set",
        "simulate.duration_s=2",
    ]);
    assert!(simulated.status.success(), "{}", stderr(&simulated));

    let export = |format: &str| {
        sprung(&[
            "export",
            experiment.to_str().unwrap(),
            "--parameters",
            demo()
                .join("sprung-out/identification.json")
                .to_str()
                .unwrap(),
            "--control",
            case.path("design/control.json").to_str().unwrap(),
            "--format",
            format,
            "--out",
            case.path("code").to_str().unwrap(),
        ])
    };
    for (format, file) in [("c", "code/robot.c"), ("rust", "code/robot.rs")] {
        let output = export(format);
        assert!(output.status.success(), "{}", stderr(&output));
        let code = fs::read_to_string(case.path(file)).unwrap();
        assert!(code.contains("control_step") && code.contains("feedforward"));
    }
    let refused = export("urdf");
    assert_eq!(refused.status.code(), Some(2));
    assert!(stderr(&refused).contains("URDF files have no controller"));
}

#[test]
fn the_same_seed_gives_the_same_files_on_any_number_of_threads() {
    let case = Case::new();
    let files = |threads: &str| {
        designed(
            &case,
            &["control.feedback=declared"],
            &["--threads", threads],
        );
        ["control.json", "controller.toml"]
            .map(|file| fs::read_to_string(case.path("design").join(file)).unwrap())
    };
    let one = files("1");
    assert!(one[1].contains("kind = \"pd\"") && one[1].contains("shaper = [["));
    assert_eq!(one, files("2"));
}

#[test]
fn the_controller_of_the_log_gives_the_period_and_gains_and_verdict_are_printed() {
    let case = Case::new();
    let held = "log.torque=held";
    let set = ["control.feedback=pd", held, "log.controller_period_s=0.002"];
    let output = control(&case, &set, &[]);
    let text = stdout(&output);
    assert!(
        text.contains("pd every 2.000 ms"),
        "{text}{}",
        stderr(&output)
    );
    assert!(text.contains("\nverdict of the values: good\n"), "{text}");
    let written = fs::read_to_string(case.path("design/control.json")).unwrap();
    let design: Value = serde_json::from_str(&written).unwrap();
    assert_eq!(design["controller"]["period_s"], 0.002);
    let gain = design["controller"]["gain"][0][2].as_f64().unwrap();
    let row = text
        .lines()
        .find(|line| line.trim_start().starts_with("joint1"));
    let shown: f64 = row
        .unwrap()
        .split_whitespace()
        .nth(2)
        .unwrap()
        .parse()
        .unwrap();
    assert!((shown / gain - 1.0).abs() < 1e-3, "{shown} {gain}");
    // A controller that is faster than the log: the robot is not known so fast.
    let set = [
        "control.feedback=pd",
        held,
        "log.controller_period_s=0.0005",
    ];
    assert!(stdout(&control(&case, &set, &[])).contains("every 1.000 ms"));
}

#[test]
fn what_cannot_be_designed_is_refused_and_nothing_is_written() {
    let mut messages = messages("what_cannot_be_designed_is_refused_and_nothing_is_written");
    let case = Case::new();
    fs::write(case.path("path.csv"), "joint1,joint2\n0.1,0.2\n0.3,1.5\n").unwrap();
    let limits = "robot.joint.1.limits={position_rad=[-1.0, 1.0]}";
    for set in [
        &["control.bandwidth_hz=[60.0]"][..],
        &["control.bandwidth_hz=[1.0, 2.0, 3.0]"],
        &["control.period_s=0.0005"],
        &["control.damping=0.5"],
        &["control.feedback=lqr"],
        &["control.path=path.csv", limits],
        &["control.path=none.csv"],
        &["control.payload={mass_kg=1.0, com_m=[0.0, 0.0, 0.1]}"],
        &["control.payload={mass_kg=-1.0, com_m=[0.0, 0.0, 0.1]}"],
        &[
            "control.feedback=declared",
            "controller.kp_nm_per_rad=[5000.0, 500.0]",
            "controller.kd_nms_per_rad=[0.0, 0.0]",
        ],
        &["robot.joint.0.limits={torque_nm=0.5}"],
        &["control.shaper_modes=9"],
        &["controller.shaper=[[0.0, 0.5], [0.1, 0.4]]"],
    ] {
        let output = control(&case, set, &[]);
        assert!(!output.status.success(), "{set:?}");
        messages.note(&set.join(" "), &without_decimals(&case.message(&output)));
    }
    assert!(!case.path("design/control.json").exists());
    messages.compare();
}

#[test]
fn unusable_values_need_a_word_and_given_values_are_exact() {
    let case = Case::new();
    let text = fs::read_to_string(demo().join("sprung-out/identification.json")).unwrap();
    let text = text.replacen("\"verdict\": \"good\"", "\"verdict\": \"unusable\"", 1);
    fs::write(case.path("unusable.json"), text).unwrap();
    let file = case.path("unusable.json");
    let file = ["--parameters", file.to_str().unwrap()];
    let refused = control(&case, &[], &file);
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        stderr(&refused).contains("unusable"),
        "{}",
        stderr(&refused)
    );
    let design = designed(&case, &[], &[&file[..], &["--accept-unusable"]].concat());
    assert_eq!(design["verdict"], "unusable");
    let truth = case.path("truth.toml");
    let design = designed(&case, &[], &["--parameters", truth.to_str().unwrap()]);
    assert_eq!(design["draws"], 0);
    let assumed = design["assumed"].to_string();
    assert!(
        assumed.contains("no margin covers their errors"),
        "{assumed}"
    );
}
