//! Results after a run was killed: all of one run, at any point.

use std::collections::BTreeMap;
use std::path::Path;

use sprung::session::{SWITCH_FILE, Switch};

use crate::common::{Case, Ran, contains, list_of, program, sprung};

/// Files of a folder by name.
type Files = BTreeMap<String, Vec<u8>>;

fn files(folder: &Path) -> Files {
    let entries = std::fs::read_dir(folder).unwrap();
    let read = |entry: std::io::Result<std::fs::DirEntry>| {
        let entry = entry.unwrap();
        let name = entry.file_name().into_string().unwrap();
        (name, std::fs::read(entry.path()).unwrap())
    };
    entries.map(read).collect()
}

/// Replaces the content of a folder.
fn restore(folder: &Path, files: &Files) {
    std::fs::remove_dir_all(folder).unwrap();
    std::fs::create_dir(folder).unwrap();
    for (name, bytes) in files {
        std::fs::write(folder.join(name), bytes).unwrap();
    }
}

/// An experiment with a log of 3 s, the results of `identify` and `validate`, and a copy of the former in `kept`.
struct Desk {
    case: Case,
    before: Files,
}

/// Settings with which every file of another run differs.
const OTHER_CUTOFF: [&str; 2] = ["--set", "identify.filter_cutoff_rad_per_s=25"];
const DIRECT: [&str; 2] = ["--set", "validate=[{name=\"direct\"}]"];
const OTHER_NAME: [&str; 2] = ["--set", "validate=[{name=\"again\"}]"];

impl Desk {
    fn new() -> Self {
        let case = Case::new().replace("[\"least-squares\", \"lsff\"]", "\"least-squares\"");
        case.record("identification.csv", &["--set", "simulate.duration_s=3"]);
        let mut desk = Self {
            case,
            before: Files::new(),
        };
        assert!(desk.run("identify", &[], None).is_none());
        let out = desk.case.path("sprung-out");
        desk.before = files(&out);
        std::fs::create_dir(desk.case.path("kept")).unwrap();
        restore(&desk.case.path("kept"), &desk.before);
        assert!(desk.run("validate", &DIRECT, None).is_none());
        desk.before = files(&out);
        assert_eq!(desk.before.len(), 7, "{:?}", desk.before.keys());
        desk
    }

    /// Runs a verb and kills it at a point. Returns the name of the point, or `None` if the run ended before.
    ///
    /// - `point`: 1 is the first.
    fn run(&self, verb: &str, more: &[&str], point: Option<usize>) -> Option<String> {
        let mut command = program();
        command
            .arg(verb)
            .arg(self.case.path("experiment.toml"))
            .arg("--quiet")
            .args(more);
        if let Some(point) = point {
            command.env("SPRUNG_HALT", point.to_string());
        }
        let output = Ran::of(&mut command);
        if output.code == Some(0) {
            return None;
        }
        let message = &output.err;
        let (_, name) = message
            .split_once("halted at ")
            .unwrap_or_else(|| panic!("{message}"));
        assert_eq!(output.code, None, "the run ended by itself");
        Some(name.trim().to_owned())
    }

    /// Reads the results by a command that writes into another folder.
    fn read(&self) {
        let paths = ["sprung-out", "kept", "comparison"].map(|name| self.case.path(name));
        let [results, kept, out] = paths.each_ref().map(|path| path.to_str().unwrap());
        sprung(&["compare", results, kept, "--quiet", "--out", out]).ends(0);
    }

    /// Runs a command up to the moment before it writes into the folder of the results.
    fn begin_to_write(&self) {
        let [out, kept] = ["sprung-out", "kept"].map(|name| self.case.path(name));
        let output = Ran::of(
            program()
                .args(["compare", "--quiet"])
                .args([&out, &kept])
                .arg("--out")
                .arg(&out)
                .env("SPRUNG_HALT", "1"),
        );
        let message = &output.err;
        contains(message, &["halted at nothing written"]);
    }

    /// Kills a verb at each of its points and checks the results each time. Returns the names of the points.
    ///
    /// - `remaining`: number of files after a complete run, kept ones included.
    fn kill_everywhere(&self, verb: &str, more: &[&str], remaining: usize) -> Vec<String> {
        let folder = self.case.path("sprung-out");
        let mut points: Vec<String> = Vec::new();
        loop {
            restore(&folder, &self.before);
            let Some(point) = self.run(verb, more, Some(1 + points.len())) else {
                break;
            };
            points.push(point);
            let found = files(&folder);
            let decided = decided(&self.before, &found);
            self.read();
            let results = visible(&files(&folder));
            let at = points.join(", ");
            assert!(results == decided, "{verb} killed after {at}");
            if points.iter().any(|point| point == "list in place") {
                assert_eq!(results.len(), remaining, "{verb} killed after {at}");
                let new = |name: &String| self.before[name] != results[name];
                let kept = results.keys().filter(|name| !new(name)).count();
                assert_eq!(
                    kept,
                    remaining - changed(&points),
                    "{verb} killed after {at}"
                );
            } else {
                assert!(results == self.before, "{verb} killed after {at}");
            }
            self.begin_to_write();
            assert!(
                files(&folder) == results,
                "{verb} killed after {at} left files behind"
            );
        }
        let left = files(&folder);
        assert_eq!(left.len(), remaining, "{:?}", left.keys());
        points
    }
}

/// Whether a file is temporary, or the list of renames.
fn is_temporary(name: &str) -> bool {
    name.starts_with('.')
}

fn visible(files: &Files) -> Files {
    let mut all = files.clone();
    all.retain(|name, _| !is_temporary(name));
    all
}

/// Returns the results that a killed run decided on: the files in place, or the earlier files with the changes of its
/// list.
fn decided(before: &Files, found: &Files) -> Files {
    let Some(list) = found.get(SWITCH_FILE).filter(|list| !list.is_empty()) else {
        return visible(found);
    };
    let list: Switch = serde_json::from_slice(list).unwrap();
    let mut decided = before.clone();
    decided.retain(|name, _| !list.outdated.contains(name));
    for (from, to) in list.renames {
        // If the temporary name is absent, the file is in its place.
        let bytes = found.get(&from).unwrap_or_else(|| &found[&to]);
        decided.insert(to, bytes.clone());
    }
    decided
}

/// Returns how many files the run wrote.
fn changed(points: &[String]) -> usize {
    points
        .iter()
        .filter(|point| *point == "a file written")
        .count()
}

/// Returns whether the program was built with its points; reports the test as skipped if not.
fn can_be_killed() -> bool {
    let can = cfg!(debug_assertions);
    if !can {
        sprung_testing::skipped("debug", "points to be killed at need debug assertions");
    }
    can
}

#[test]
fn an_identification_that_is_killed_leaves_results_of_one_run() {
    if !can_be_killed() {
        return;
    }
    let points = Desk::new().kill_everywhere("identify", &OTHER_CUTOFF, 5);
    assert_eq!(
        points.join(", "),
        "nothing written, a file written, a file written, a file written, a file written, a file written, \
         all written, list written, list in place, validation.json, signals.csv, report.html, fit.csv, \
         trace.csv, parameters.csv, identification.json, .sprung-switch, list removed"
    );
}

#[test]
fn a_validation_that_is_killed_leaves_results_of_one_run() {
    if !can_be_killed() {
        return;
    }
    let points = Desk::new().kill_everywhere("validate", &OTHER_NAME, 7);
    assert_eq!(
        points.join(", "),
        "nothing written, a file written, a file written, a file written, all written, list written, \
         list in place, report.html, signals.csv, validation.json, .sprung-switch, list removed"
    );
}

#[test]
fn a_refinement_that_is_killed_leaves_the_result_of_least_squares() {
    if !can_be_killed() {
        return;
    }
    let desk = Desk::new();
    let refine = ["--set", "identify.estimator=prediction-error"];
    let folder = desk.case.path("sprung-out");
    let mut points: Vec<String> = Vec::new();
    // The second point without a written file is after the refinement.
    while points
        .iter()
        .filter(|point| *point == "nothing written")
        .count()
        < 2
    {
        restore(&folder, &desk.before);
        let point = desk.run("identify", &refine, Some(1 + points.len()));
        points.push(point.unwrap());
    }
    assert_eq!(points.len(), 19, "{points:?}");
    desk.read();
    let found = files(&folder);
    let json: serde_json::Value = serde_json::from_slice(&found["identification.json"]).unwrap();
    assert_eq!(json["results"][0]["estimator"], "least-squares");
    let codes: Vec<_> = list_of(&json["findings"])
        .iter()
        .map(|f| &f["code"])
        .collect();
    assert!(codes.contains(&&"refinement-pending".into()), "{codes:?}");
    assert_eq!(json["status"], "refining");
    for name in ["parameters.csv", "trace.csv", "fit.csv"] {
        let table = String::from_utf8_lossy(&found[name]).into_owned();
        let mut lines = table.lines();
        assert!(lines.next().unwrap().ends_with(",status"), "{name}");
        assert!(lines.all(|line| line.ends_with(",refining")), "{name}");
    }
    let report = String::from_utf8_lossy(&found["report.html"]).into_owned();
    contains(&report, &[", being refined"]);
    let path = desk.case.path("experiment.toml");
    for verb in [
        &["validate"][..],
        &["export", "--format", "json"],
        &["control"],
    ] {
        let args = [verb, &[path.to_str().unwrap()]].concat();
        let output = sprung(&args);
        assert_eq!(output.code, Some(2), "{verb:?}");
        output.tells(&["--accept-refining"]);
    }
    assert!(!found.contains_key("validation.json"));
    assert!(desk.run("identify", &refine, None).is_none());
    let json: serde_json::Value =
        serde_json::from_slice(&files(&folder)["identification.json"]).unwrap();
    assert_eq!(json["results"][0]["estimator"], "prediction-error");
}
