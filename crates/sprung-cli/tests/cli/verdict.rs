//! The verdict in words, its promise and the proof, as users read them.

use serde_json::Value;

use crate::arm;
use crate::common::{Case, contains, demo, list_of, str_of};

/// The decision on stdout: the last line, or the last but one above the codes of the findings.
fn last(text: &str) -> &str {
    let mut lines = text.trim_end().lines().rev();
    let last = lines.next().unwrap();
    if last.starts_with("decided by: ") {
        return lines.next().unwrap();
    }
    last
}

#[test]
fn the_last_line_is_the_decision() {
    let output = Case::new().identify(&["--color=always"]);
    let text = &output.out;
    let start = "\u{1b}[1;32mGood\u{1b}[0m: on a new experiment of this kind the model is expected to \
                 predict the motor torques with errors of ";
    assert!(last(text).starts_with(start), "{text}");
    assert!(last(text).ends_with(" % (root mean squares)."), "{text}");
    // No other line repeats the reasons.
    assert_eq!(text.matches("least-squares: ").count(), 1, "{text}");

    let output = Case::new().identify(&["--set", "identify.estimator=[\"lsff\"]"]);
    let text = &output.out;
    assert!(
        last(text).starts_with("Doubtful: on a new experiment"),
        "{text}"
    );
    assert!(last(text).contains(". Do not use "), "{text}");
}

#[test]
fn the_decision_is_in_the_file_and_begins_the_report() {
    let out = demo().join("sprung-out");
    let text = std::fs::read_to_string(out.join("identification.json")).unwrap();
    let json: Value = serde_json::from_str(&text).unwrap();
    let results = list_of(&json["results"]);
    let decisions: Vec<&Value> = results.iter().map(|result| &result["decision"]).collect();
    assert_eq!(list_of(&decisions[0]["findings"]).len(), 0);
    let codes = list_of(&decisions[2]["findings"]);
    assert!(codes.contains(&"impossible-robot".into()), "{codes:?}");
    let parameters = list_of(&decisions[2]["parameters"]);
    assert!(
        parameters.contains(&"joint2.link_viscous".into()),
        "{parameters:?}"
    );

    let report = std::fs::read_to_string(out.join("report.html")).unwrap();
    let (_, after) = report.split_once("<p class=\"summary\">").unwrap();
    let (summary, rest) = after.split_once("</p>").unwrap();
    assert!(
        summary.starts_with(str_of(&decisions[0]["sentence"])),
        "{summary}"
    );
    contains(summary, &["The promise is kept: in prediction no error"]);
    contains(rest, &["<section id=\"parameters\">"]);
    let other = str_of(&decisions[2]["sentence"]);
    assert!(rest.contains(&format!("About lsff: {other}")), "{other}");
}

#[test]
fn a_serious_finding_is_named_in_the_decision() {
    let case = Case::new().column(5, |torque| -torque);
    let output = case.identify(&["--set", "identify.on_check_error=go-on"]);
    let text = &output.out;
    println!("{}", output.err);
    output.ends(1);
    assert!(
        last(text).contains(" Do not use the values, because "),
        "{text}"
    );
    assert!(last(text).contains("the sign of a torque is reversed"));
    contains(text, &["\ndecided by: reversed-torque"]);
}

#[test]
fn a_payload_of_an_arm_is_named_with_its_mass() {
    // 0.5 kg at 0.3 m of the forearm.
    let (mass, at) = (0.5, 0.3);
    let total = 1.5 + mass;
    let center = (1.5 * 0.15 + mass * at) / total;
    let inertia = 0.015 + 1.5 * 0.15_f64.powi(2) + mass * at * at - total * center * center;
    let heavy = (arm::URDF)
        .replace(
            "<origin xyz=\"0.15 0 0\"/><mass value=\"1.5\"/>",
            &format!("<origin xyz=\"{center} 0 0\"/><mass value=\"{total}\"/>"),
        )
        .replace(
            "iyy=\"0.015\" iyz=\"0\" izz=\"0.015\"",
            &format!("iyy=\"{inertia}\" iyz=\"0\" izz=\"{inertia}\""),
        );
    let case = arm::recorded().replace(
        "[simulate]",
        "[[validate]]\nname = \"second\"\nlog = { file = \"second.csv\" }\n[simulate]",
    );
    case.write("heavy.urdf", heavy);
    case.identify(&["-q"]).ends(0);
    let mut said = Vec::new();
    for more in [
        &["--set", "simulate.seed=3"][..],
        &["--set", "robot.urdf=heavy.urdf"],
    ] {
        case.record("second.csv", more);
        let output = case.run("validate", &[]);
        output.ends(0);
        said.push((last(&output.out).to_owned(), output.err));
    }
    let [(kept, nothing), (broken, message)] = &said[..] else {
        panic!("{said:?}");
    };
    assert!(
        kept.starts_with("The promise is kept: in second no error"),
        "{kept}"
    );
    assert!(!nothing.contains("changed"), "{nothing}");
    assert!(
        broken.starts_with("The promise is broken: in second "),
        "{broken}"
    );
    assert!(broken.ends_with("; another load explains it."), "{broken}");
    let (_, mass) = message
        .split_once("fore.m +")
        .unwrap_or_else(|| panic!("{message}"));
    let mass: f64 = mass.split(' ').next().unwrap().parse().unwrap();
    // A twentieth, the largest standard error of a useful value.
    assert!((mass - 0.5).abs() < 0.025, "{message}");
}

#[test]
fn parameters_of_a_file_promise_nothing() {
    let case = Case::new();
    let truth = case.at("truth.toml");
    let text = case
        .run(
            "validate",
            &[
                "--parameters",
                &truth,
                "--set",
                "validate=[{name=\"direct\"}]",
            ],
        )
        .out;
    assert!(
        last(&text).starts_with("There is no promise to prove"),
        "{text}"
    );
}
