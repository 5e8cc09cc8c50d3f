//! Payloads in the experiment file.

use crate::arm::described;
use crate::common::{Case, contains, finding, list_of, messages};

fn with_files(files: &str) -> Case {
    described().replace("file = \"run.csv\"", &format!("file = {files}"))
}

#[test]
fn payloads_that_cannot_be_told_are_refused() {
    let mut messages = messages("payloads_that_cannot_be_told_are_refused");
    let closed_form = Case::new().replace(
        "file = \"identification.csv\"",
        "file = { path = \"identification.csv\", payload = {} }",
    );
    messages.note("a robot in closed form", &closed_form.refused(2, &[]));
    for files in [
        "{ path = \"run.csv\", payload = { name = \"tool\" } }",
        "[\"run.csv\", { path = \"b.csv\", payload = { com_m = [0, 0, 0.1] } }]",
        "[\"run.csv\", { path = \"b.csv\", payload = { mass_kg = 2.0 } }]",
        "[\"run.csv\", { path = \"b.csv\", payload = { mass_kg = -2.0, com_m = [0, 0, 0] } }]",
        "[\"run.csv\", { path = \"b.csv\", payload = { link = \"hand\" } }]",
    ] {
        messages.note(files, &with_files(files).refused(2, &[]));
    }
    messages.compare();
}

#[test]
fn a_log_without_another_mass_has_a_payload_of_zero() {
    // The same log with and without payload: the payload is zero within its errors.
    let case = crate::arm::recorded().replace(
        "file = \"run.csv\"",
        "file = [\"run.csv\", { path = \"loaded.csv\", payload = { name = \"tool\" } }]",
    );
    std::fs::copy(case.path("run.csv"), case.path("loaded.csv")).unwrap();
    let more = ["identify.estimator=\"least-squares\""];
    let json = case
        .run("identify", &["--json", "-q", "--set", more[0]])
        .json();
    let payload = &json["payloads"][0];
    assert_eq!(payload["name"], "tool");
    let mut known = 0;
    for parameter in list_of(&payload["parameters"]) {
        let number = |key: &str| parameter[key].as_f64();
        if let (Some(value), Some(error)) = (number("value"), number("standard_error")) {
            assert!(value.abs() < 3.0 * error, "{parameter}");
            known += 1;
        }
    }
    // Two parallel axes determine the first moments in their plane and one inertia, but not the others.
    assert!(
        (1..=4).contains(&known),
        "{known} of the parameters are determined"
    );
    contains(
        finding(&json, "payload-not-identifiable").unwrap(),
        &["tool.ixz"],
    );
}

#[test]
fn a_joint_that_moves_in_one_log_only_is_named() {
    let case = crate::arm::recorded().replace(
        "file = \"run.csv\"",
        "file = [\"run.csv\", { path = \"loaded.csv\", payload = {} }]",
    );
    std::fs::copy(case.path("run.csv"), case.path("loaded.csv")).unwrap();
    // The elbow moves a hundredth as far.
    let case = case.column_of("loaded.csv", 3, |phi| 0.01 * phi);
    let (_, json) = case.results(&[]);
    contains(
        finding(&json, "payload-moves-other-joints").unwrap(),
        &["elbow moves only without the payload"],
    );
}
