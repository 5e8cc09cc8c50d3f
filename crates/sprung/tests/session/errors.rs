//! Errors that a session returns for wrong input, and their kinds.

use std::path::Path;

use sprung::session::{ErrorKind, Parameters, Session, SessionError};
use sprung_base::demo;
use sprung_base::progress::Unheard;
use sprung_log::{Arrays, LogSource};

use crate::support::{files, folder, messages, of_memory, session};

/// Returns the message of an error, and checks its kind.
#[track_caller]
fn said<T>(outcome: Result<T, SessionError>, kind: ErrorKind) -> String {
    let error = outcome.err().unwrap();
    assert_eq!(error.kind(), kind, "{error}");
    error.to_string()
}

#[test]
fn files_and_logs_that_are_missing_or_wrong() {
    let mut messages = messages("files_and_logs_that_are_missing_or_wrong");
    let log = String::from_utf8(files()["identification.csv"].clone()).unwrap();
    let mut lines: Vec<&str> = log.lines().collect();
    let cell = format!("{},nan", lines[100].rsplit_once(',').unwrap().0);
    lines[100] = &cell;
    let mut gone = files().clone();
    gone.remove("identification.csv");
    let mut broken = files().clone();
    broken.insert("identification.csv", lines.join("\n").into_bytes());
    for (name, files, kind) in [
        ("no log", gone, ErrorKind::File),
        ("a cell without number", broken, ErrorKind::Log),
    ] {
        let session = of_memory(files, &[]);
        let message = said(session.identify(&mut Unheard), kind);
        assert_eq!(message, said(session.check(&mut Unheard), kind));
        messages.note(name, &message);
    }
    let missing = Session::open(Path::new("nowhere/experiment.toml"), &[]);
    messages.note("no experiment", &said(missing, ErrorKind::File));
    messages.compare();
}

#[test]
fn experiments_that_lack_something_are_the_users_fault() {
    let mut messages = messages("experiments_that_lack_something_are_the_users_fault");
    let of = |text: &str| {
        let open = |_: &Path| Err(std::io::Error::from(std::io::ErrorKind::NotFound));
        Session::read("experiment.toml", text, &[], open)
    };
    let usage = ErrorKind::Usage;
    messages.note("another format", &said(of("format = 9"), usage));
    let cut = |from: &str| demo::EXPERIMENT.split(from).next().unwrap().to_owned();
    let no_twin = of(&cut("[simulate]")).unwrap();
    messages.note("no twin", &said(no_twin.twin(None, None), usage));
    let no_log = of(&cut("[log]")).unwrap();
    messages.note("no [log]", &said(no_log.identify(&mut Unheard), usage));
    let unknown = session(&[]);
    let unknown = unknown.twin(Some("else"), None);
    messages.note("an unknown block", &said(unknown, usage));
    let log = Session::open(Path::new("run7.csv"), &[]);
    messages.note("a log for an experiment", &said(log, usage));
    messages.compare();
}

#[test]
fn files_that_hold_no_parameters_are_named() {
    let mut messages = messages("files_that_hold_no_parameters_are_named");
    let folder = folder("parameters");
    std::fs::write(folder.join("text.toml"), "stiffness is 9").unwrap();
    std::fs::write(folder.join("other.json"), "{}").unwrap();
    for (name, kind) in [
        ("text.toml", ErrorKind::Usage),
        ("other.json", ErrorKind::Usage),
        ("gone.toml", ErrorKind::File),
    ] {
        let message = said(Parameters::open(&folder.join(name)), kind);
        let message = message.replace(folder.to_str().unwrap(), "FOLDER");
        messages.note(name, &message);
    }
    messages.compare();
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
    let mut messages = messages("columns_in_memory_that_are_wrong_are_named");
    let session = session(&[]);
    let with = |columns| {
        let mut sources = [LogSource::arrays("run 7", Arrays::new(columns).unwrap())];
        session.identify_with(&mut sources, &mut Unheard)
    };
    with(columns()).unwrap();
    let mut nan = columns();
    nan[3].1[99] = f64::NAN;
    messages.note(
        "a value that is no number",
        &said(with(nan), ErrorKind::Log),
    );
    let mut missing = columns();
    missing.remove(3);
    messages.note("no such column", &said(with(missing), ErrorKind::Log));
    let mut unequal = columns();
    unequal[3].1.truncate(99);
    let error = Arrays::new(unequal).unwrap_err();
    messages.note("columns of two lengths", &error.to_string());
    messages.compare();
}
