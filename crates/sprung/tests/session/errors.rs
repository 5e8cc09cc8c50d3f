//! Errors that a session returns for wrong input, and their kinds.

use std::path::Path;

use sprung::session::{Depth, ErrorKind, Parameters, Session, SessionError};
use sprung_base::demo;
use sprung_base::progress::Unheard;
use sprung_log::{Arrays, LogSource};

use crate::support::{files, folder, of_memory, session};

/// Checks the kind and part of the message of an error.
fn says<T>(outcome: Result<T, SessionError>, kind: ErrorKind, part: &str) {
    let error = outcome.err().unwrap();
    assert_eq!(error.kind(), kind, "{error}");
    assert!(error.to_string().contains(part), "{error}");
}

#[test]
fn files_that_are_missing_are_the_files_fault() {
    let mut files = files().clone();
    files.remove("identification.csv");
    let session = of_memory(files, &[]);
    let part = "cannot read identification.csv";
    says(
        session.check(Depth::OnePass, &mut Unheard),
        ErrorKind::File,
        part,
    );
    says(session.identify(&mut Unheard), ErrorKind::File, part);
    let missing = Session::open(Path::new("nowhere/experiment.toml"), &[]);
    says(
        missing,
        ErrorKind::File,
        "there is no experiment file nowhere/experiment.toml; check the path; sprung new FOLDER",
    );
}

#[test]
fn logs_that_are_wrong_are_the_logs_fault() {
    let mut files = files().clone();
    let log = String::from_utf8(files["identification.csv"].clone()).unwrap();
    let mut lines: Vec<&str> = log.lines().collect();
    let broken = format!("{},nan", lines[100].rsplit_once(',').unwrap().0);
    lines[100] = &broken;
    files.insert("identification.csv", lines.join("\n").into_bytes());
    let session = of_memory(files, &[]);
    let part = "line 101 of identification.csv, column \"tau2_nm\": ";
    says(
        session.check(Depth::OnePass, &mut Unheard),
        ErrorKind::Log,
        part,
    );
    says(session.identify(&mut Unheard), ErrorKind::Log, part);
}

#[test]
fn experiments_that_lack_something_are_the_users_fault() {
    let of = |text: &str| {
        let open = |_: &Path| Err(std::io::Error::from(std::io::ErrorKind::NotFound));
        Session::read("experiment.toml", text, &[], open)
    };
    says(of("format = 9"), ErrorKind::Usage, "experiment.toml");
    let usage = ErrorKind::Usage;
    let cut = |from: &str| demo::EXPERIMENT.split(from).next().unwrap().to_owned();
    let no_twin = of(&cut("[simulate]")).unwrap();
    says(no_twin.twin(None, None), usage, "no [simulate] block");
    let no_log = of(&cut("[log]")).unwrap();
    says(no_log.identify(&mut Unheard), usage, "no [log]");
    let demo = session(&[]);
    let unknown = demo.twin(Some("else"), None);
    says(unknown, usage, "the blocks are: direct, prediction");
    says(
        Session::open(Path::new("run7.csv"), &[]),
        usage,
        "run7.csv is a log, not an experiment file; give the experiment file that names it",
    );
}

#[test]
fn files_that_hold_no_parameters_are_named() {
    let folder = folder("parameters");
    let write = |name: &str, text: &str| {
        let file = folder.join(name);
        std::fs::write(&file, text).unwrap();
        file
    };
    let usage = ErrorKind::Usage;
    let text = write("text.toml", "stiffness is 9");
    says(
        Parameters::open(&text),
        usage,
        "is not a file of parameters",
    );
    let json = write("other.json", "{}");
    says(
        Parameters::open(&json),
        usage,
        "is not a file of parameters",
    );
    let gone = folder.join("gone.toml");
    says(Parameters::open(&gone), ErrorKind::File, "cannot read");
}

/// Returns the columns of a log of the demo.
fn columns() -> Vec<(String, Vec<f64>)> {
    let log = String::from_utf8(files()["identification.csv"].clone()).unwrap();
    let mut lines = log.lines();
    let names = lines.next().unwrap().split(',');
    let mut all: Vec<(String, Vec<f64>)> =
        names.map(|name| (name.to_owned(), Vec::new())).collect();
    for line in lines {
        for ((_, values), cell) in all.iter_mut().zip(line.split(',')) {
            values.push(cell.parse().unwrap());
        }
    }
    all
}

#[test]
fn columns_in_memory_that_are_wrong_are_named() {
    let session = session(&[]);
    let with = |columns| {
        let mut sources = [LogSource::arrays("run 7", Arrays::new(columns).unwrap())];
        session.identify_with(&mut sources, &mut Unheard)
    };
    with(columns()).unwrap();
    let mut nan = columns();
    nan[3].1[99] = f64::NAN;
    let part = format!("row 100 of run 7, column \"{}\": ", nan[3].0);
    says(with(nan), ErrorKind::Log, &part);
    let mut missing = columns();
    let gone = missing.remove(3).0;
    says(
        with(missing),
        ErrorKind::Log,
        &format!("run 7 has no column \"{gone}\""),
    );
    let mut unequal = columns();
    unequal[3].1.truncate(99);
    let error = Arrays::new(unequal).unwrap_err().to_string();
    assert!(error.contains(&gone) && error.contains("99"), "{error}");
}
