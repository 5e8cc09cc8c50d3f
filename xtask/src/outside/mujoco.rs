//! A log of MuJoCo, identified by least squares.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use super::python::Python;
use crate::install::hdf5;
use crate::steps::{cargo, succeeds};
use crate::target;
use crate::test::features;

/// Largest median error of the 15 parameters, as a part of the true value. Ten logs have a median of 0.8 %,
/// because the dry friction of MuJoCo is a constraint and not the law that sprung fits.
const MEDIAN_ERROR: f64 = 0.02;

/// Simulates the demo's arm by MuJoCo, identifies it and compares with its true parameters.
pub(super) fn check(python: &Python) -> Option<()> {
    let (logs, demo, out) = (
        python.folder.join("mujoco"),
        python.folder.join("demo"),
        python.folder.join("identified"),
    );
    python.run(
        "benches/peers/two_joints_mujoco.py",
        &[&logs, Path::new("1")],
    )?;
    build()?;
    sprung(&["demo", "--quiet", "--out", &demo.to_string_lossy()])?;
    sprung(&[
        "identify",
        &demo.to_string_lossy(),
        "--quiet",
        "--set",
        "identify.estimator=[\"least-squares\"]",
        "--set",
        &format!(
            "log.file={}",
            logs.join("000.csv").canonicalize().ok()?.display()
        ),
        "--out",
        &out.to_string_lossy(),
    ])?;
    let truth = std::fs::read_to_string(demo.join("truth.toml")).ok()?;
    let found = std::fs::read_to_string(out.join("identification.json")).ok()?;
    let error = median_error(&found, &truths(&truth))?;
    eprintln!(
        "median error {:.2} %, at most {:.0} %",
        100.0 * error,
        100.0 * MEDIAN_ERROR
    );
    (error <= MEDIAN_ERROR).then_some(())
}

/// Builds the program as the tests do, so that no crate is compiled twice.
pub(super) fn build() -> Option<()> {
    let build = ["build", "--quiet", "--workspace", "--bin", "sprung"];
    succeeds(cargo().args(build).arg(features(hdf5())))
}

/// Runs the program.
pub(super) fn sprung(arguments: &[&str]) -> Option<()> {
    succeeds(Command::new(target().join("debug/sprung")).args(arguments))
}

/// Reads a table of true values.
fn truths(text: &str) -> BTreeMap<&str, f64> {
    let lines = text.lines().filter_map(|line| {
        let (name, value) = line.split_once('=')?;
        Some((name.trim().trim_matches('"'), value.trim().parse().ok()?))
    });
    lines.collect()
}

/// Returns the median error of the first result, as a part of the true values.
///
/// Returns `None`, and prints why, if a parameter is missing.
fn median_error(identification: &str, truths: &BTreeMap<&str, f64>) -> Option<f64> {
    let json: Value = serde_json::from_str(identification).ok()?;
    let parameters = json["results"][0]["parameters"].as_array()?;
    let mut errors = Vec::new();
    for (name, truth) in truths {
        let parameter = parameters
            .iter()
            .find(|parameter| parameter["name"] == *name);
        let Some(value) = parameter.and_then(|parameter| parameter["value"].as_f64()) else {
            eprintln!("── no value of {name}");
            return None;
        };
        errors.push((value / truth - 1.0).abs());
    }
    errors.sort_by(f64::total_cmp);
    errors.get(errors.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_that_of_all_true_values() {
        let truths = truths("# true\n\"a.k\" = 2.0\n\"b.k\"  = 4.0\n\"c.k\" = 1.0\n");
        let all = r#"{"results": [{"parameters": [{"name": "b.k", "value": 5.0},
            {"name": "c.k", "value": 1.0}, {"name": "a.k", "value": 2.2}]}]}"#;
        let found = median_error(all, &truths);
        assert!(
            found.is_some_and(|error| (error - 0.1).abs() < 1e-12),
            "{found:?}"
        );
        assert_eq!(median_error(&all.replace("c.k", "d.k"), &truths), None);
    }
}
