//! `sprung control`: a designed controller, its files and its refusals.

use std::fs;

use serde_json::Value;

use crate::common::{
    Case, Ran, contains, demo, f64_of, list_of, messages, sprung, without_decimals,
};

/// Settings of a short design.
const SHORT: [&str; 4] = [
    "control.draws=8",
    "control.poses=3",
    "control.simulations=1",
    "simulate.duration_s=3",
];

/// Designs a controller for the demo's arm into the folder `design` of a case.
fn control(case: &Case, set: &[&str], more: &[&str]) -> Ran {
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
    output.ends(0);
    output.json()
}

#[test]
fn a_designed_controller_runs_as_that_of_an_experiment_and_as_code() {
    let case = Case::new();
    let design = designed(&case, &["control.shaper_modes=1"], &[]);
    for margins in list_of(&design["loops"]) {
        assert!(f64_of(&margins["gain_db"]["worst"]) >= 6.0);
        assert!(f64_of(&margins["phase_deg"]["worst"]) >= 40.0);
    }
    for tracking in list_of(&design["proof"]["tracking"]) {
        let designed = f64_of(&tracking["designed_rad"]["worst"]);
        assert!(designed < 0.25 * f64_of(&tracking["declared_rad"]));
    }
    let text = case.read("design/control.html");
    for id in ["loops", "vibrations", "moves", "tracking"] {
        assert!(text.contains(&format!("id=\"{id}\"")), "{id}");
    }
    // The controller replaces that of the experiment, without its reference.
    let written = case.read("design/controller.toml");
    let text = case.read("experiment.toml");
    let (before, rest) = text.split_once("[controller] ").unwrap();
    let (_, after) = rest.split_once("[controller.reference]").unwrap();
    let whole = format!("{before}{written}\n[controller.reference]{after}");
    case.write("experiment.toml", whole);
    let log = case.at("run");
    case.run(
        "simulate",
        &["--out", &log, "--set", "simulate.duration_s=2"],
    )
    .ends(0);

    let export = |format: &str| {
        let identified = demo().join("sprung-out/identification.json");
        let parameters = ["--parameters", identified.to_str().unwrap()];
        let (design, out) = (case.at("design/control.json"), case.at("code"));
        let of = ["--control", &design, "--format", format, "--out", &out];
        case.run("export", &[&parameters[..], &of].concat())
    };
    for (format, file) in [("c", "code/robot.c"), ("rust", "code/robot.rs")] {
        export(format).ends(0);
        contains(&case.read(file), &["control_step", "feedforward"]);
    }
    export("urdf")
        .ends(2)
        .tells(&["URDF files have no controller"]);
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
        ["control.json", "controller.toml"].map(|file| case.read(&format!("design/{file}")))
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
    let text = &output.out;
    assert!(text.contains("pd every 2.000 ms"), "{text}{}", output.err);
    contains(text, &["\nverdict of the values: good\n"]);
    let design = case.json("design/control.json");
    assert_eq!(design["controller"]["period_s"], 0.002);
    let gain = f64_of(&design["controller"]["gain"][0][2]);
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
    assert!(control(&case, &set, &[]).out.contains("every 1.000 ms"));
}

#[test]
fn what_cannot_be_designed_is_refused_and_nothing_is_written() {
    let mut messages = messages("what_cannot_be_designed_is_refused_and_nothing_is_written");
    let case = Case::new();
    case.write("path.csv", "joint1,joint2\n0.1,0.2\n0.3,1.5\n");
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
        assert_ne!(output.code, Some(0), "{set:?}");
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
    case.write("unusable.json", text);
    let file = case.path("unusable.json");
    let file = ["--parameters", file.to_str().unwrap()];
    control(&case, &[], &file).ends(2).tells(&["unusable"]);
    let design = designed(&case, &[], &[&file[..], &["--accept-unusable"]].concat());
    assert_eq!(design["verdict"], "unusable");
    let truth = case.at("truth.toml");
    let design = designed(&case, &[], &["--parameters", &truth]);
    assert_eq!(design["draws"], 0);
    let assumed = design["assumed"].to_string();
    contains(&assumed, &["no margin covers their errors"]);
}
