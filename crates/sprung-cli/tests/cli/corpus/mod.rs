//! Faulty logs and other files, made by code, and the expected messages.
//!
//! `SPRUNG_CORPUS="$PWD/fuzz/corpus" cargo test -p sprung-cli --test cli corpus` writes these files, and undamaged
//! ones, as seeds for `cargo fuzz`.

mod bags;
mod binary;
mod experiments;
#[path = "../../../../sprung-log/tests/formats/keys.rs"]
mod keys;
mod motions;
mod seeds;
mod text;

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::mcap_bytes;

/// A run that takes longer counts as hanging: all of them end within a few seconds.
const PATIENCE: Duration = Duration::from_secs(120);

/// Largest length of a message, bytes: a message must not repeat a cell of a megabyte.
const MESSAGE: usize = 3000;

/// A robot with two joints.
const ROBOT: &str = r#"format = 1
[robot]
name = "two joints"
kinematics = "planar-2r"
[[robot.joint]]
name = "joint1"
[[robot.joint]]
name = "joint2"
"#;

/// An experiment with something wrong.
struct Faulty {
    name: String,
    files: Vec<(String, Vec<u8>)>,
    /// Exit code of `sprung check`.
    code: i32,
    /// Fragments that it must print: parts of the error, or codes of findings.
    says: Vec<&'static str>,
}

impl Faulty {
    /// A log of the robot with two joints.
    ///
    /// - `keys`: of `[log]`, without the file.
    fn log(name: &str, bytes: Vec<u8>, keys: &str, says: &[&'static str]) -> Self {
        let experiment = format!("{ROBOT}[log]\nfile = \"run.log\"\n{keys}");
        let files = vec![
            ("experiment.toml".to_owned(), experiment.into_bytes()),
            ("run.log".to_owned(), bytes),
        ];
        Self {
            name: name.to_owned(),
            files,
            code: 3,
            says: says.to_vec(),
        }
    }

    /// Replaces text in the experiment.
    fn naming(mut self, from: &str, to: &str) -> Self {
        let text = String::from_utf8(std::mem::take(&mut self.files[0].1)).unwrap();
        assert!(text.contains(from), "{}: no {from:?} in {text}", self.name);
        self.files[0].1 = text.replace(from, to).into_bytes();
        self
    }

    fn code(self, code: i32) -> Self {
        Self { code, ..self }
    }

    fn write(&self, folder: &Path) {
        for (file, bytes) in &self.files {
            std::fs::write(folder.join(file), bytes).unwrap();
        }
    }

    /// Checks the log. If the check refuses it, `identify` must refuse it too. Returns what is wrong.
    fn told(&self) -> Result<(), String> {
        let folder = TempDir::new().unwrap();
        self.write(folder.path());
        let found = run(folder.path(), "check")?;
        if found.code != Some(self.code) {
            return Err(format!("ends with {:?}: {}", found.code, found.said()));
        }
        let all = format!("{}{}", found.err, found.report);
        if let Some(part) = self.says.iter().find(|part| !all.contains(**part)) {
            return Err(format!("no {part:?} in {}", found.said()));
        }
        if self.code > 1 {
            // A check refuses a log with a report, or fails before it writes one.
            std::fs::remove_dir_all(folder.path().join("sprung-out")).ok();
            let found = run(folder.path(), "identify")?;
            if found.code != Some(self.code) || !found.files.is_empty() {
                return Err(format!(
                    "identify ends with {:?} and {:?}: {}",
                    found.code,
                    found.files,
                    found.said()
                ));
            }
        }
        Ok(())
    }
}

/// Runs a command until it ends or the time limit is reached.
fn run(folder: &Path, verb: &str) -> Result<Found, String> {
    let (out, err) = (folder.join("stdout"), folder.join("stderr"));
    let mut child = Command::new(env!("CARGO_BIN_EXE_sprung"))
        .args([verb, "-v"])
        .arg(folder)
        .stdin(Stdio::null())
        .stdout(std::fs::File::create(&out).unwrap())
        .stderr(std::fs::File::create(&err).unwrap())
        .spawn()
        .unwrap();
    let start = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if start.elapsed() > PATIENCE {
            child.kill().unwrap();
            child.wait().unwrap();
            return Err(format!("{verb} hangs"));
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    let err = String::from_utf8_lossy(&std::fs::read(err).unwrap()).into_owned();
    let found = Found::new(folder, status.code(), err);
    if found.err.contains("panicked") || found.code.is_none() {
        return Err(format!("{verb} panics: {}", found.err));
    }
    found.whole()?;
    Ok(found)
}

/// Outcome of a run.
#[derive(Debug)]
struct Found {
    code: Option<i32>,
    err: String,
    /// Content of check.json; empty if the file is absent.
    report: String,
    /// Names of files in the folder of results.
    files: Vec<String>,
}

impl Found {
    fn new(folder: &Path, code: Option<i32>, err: String) -> Self {
        let out = folder.join("sprung-out");
        let mut files: Vec<String> = std::fs::read_dir(&out).map_or_else(
            |_| Vec::new(),
            |entries| {
                let name = |entry: std::fs::DirEntry| entry.file_name().into_string().unwrap();
                entries.map(|entry| name(entry.unwrap())).collect()
            },
        );
        files.sort();
        Self {
            code,
            err,
            report: std::fs::read_to_string(out.join("check.json")).unwrap_or_default(),
            files,
        }
    }

    /// The error, or the codes of findings.
    fn said(&self) -> String {
        let report: serde_json::Value = serde_json::from_str(&self.report).unwrap_or_default();
        let codes: Vec<&serde_json::Value> = (report["findings"].as_array().into_iter().flatten())
            .map(|finding| &finding["code"])
            .collect();
        let error: String = self.err.chars().take(300).collect();
        format!("{error:?} {codes:?}")
    }

    /// Checks that all result files exist, or no result file after an error, and that the error is short.
    fn whole(&self) -> Result<(), String> {
        let wanted: &[&str] = if self.err.starts_with("error: ") {
            &[]
        } else {
            &["check.html", "check.json"]
        };
        if self.files != wanted {
            return Err(format!("leaves {:?}: {}", self.files, self.said()));
        }
        if self.err.len() > MESSAGE {
            return Err(format!("says {} bytes: {}", self.err.len(), self.said()));
        }
        let report: Result<serde_json::Value, _> = serde_json::from_str(&self.report);
        match report {
            Err(error) if !wanted.is_empty() => Err(format!("check.json: {error}")),
            _ => Ok(()),
        }
    }
}

/// Content of a fixture that another program wrote.
fn fixture(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../sprung-log/tests/formats/fixtures");
    std::fs::read(folder.join(name)).unwrap()
}

fn all() -> Vec<Faulty> {
    [
        text::all(),
        binary::all(),
        bags::all(),
        motions::all(),
        experiments::all(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Checks a part of the corpus and reports all deviations together.
fn are_told(corpus: &[Faulty]) {
    let wrong: Vec<String> = (corpus.iter())
        .filter_map(|faulty| Some(format!("{}: {}", faulty.name, faulty.told().err()?)))
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn faulty_texts() {
    are_told(&text::all());
}

#[test]
fn faulty_binary_files() {
    are_told(&binary::all());
}

#[test]
fn faulty_bags() {
    are_told(&bags::all());
}

#[test]
fn faulty_motions() {
    are_told(&motions::all());
}

#[test]
fn faulty_experiments() {
    are_told(&experiments::all());
}

#[test]
fn the_corpus_is_large_and_always_the_same() {
    let (one, other) = (all(), all());
    println!("{} faulty experiments", one.len());
    assert!(one.len() >= 60, "{}", one.len());
    let mut names: Vec<&str> = one.iter().map(|faulty| faulty.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), one.len());
    assert!(one.iter().all(|faulty| !faulty.says.is_empty()));
    for (one, other) in one.iter().zip(&other) {
        assert_eq!(one.files, other.files, "{}", one.name);
    }
    if let Some(folder) = std::env::var_os("SPRUNG_CORPUS") {
        seeds::write(Path::new(&folder), &one);
    }
}
