//! `cargo xtask figures`: measures the figures of the documentation.
//!
//! Benchmarks note their figures in a file that `SPRUNG_FIGURES` names. The task keeps them in `benches/figures.json`
//! with commit, date and machine. Pages take them from there.

mod file;
mod pages;
mod parts;
mod plots;

use std::fs;
use std::path::Path;
use std::process::{Command, ExitCode};

use file::{Figures, Measured};
use parts::{Given, Part, parts};

use crate::files;
use crate::steps::{exit_code, said};
use crate::{root, target};

/// Results, relative to the root of the repository.
const FILE: &str = "benches/figures.json";

/// Returns the names of all parts.
pub(crate) fn names() -> Vec<&'static str> {
    parts().iter().map(|part| part.name).collect()
}

/// Measures parts, one after another, and stores each that is not worse than before.
///
/// - `words`: names of parts, all if there is none; `--accept` stores worse figures too.
pub(crate) fn run(words: &[&str]) -> ExitCode {
    let is_accepted = words.contains(&"--accept");
    let chosen: Vec<&str> = (words.iter().copied())
        .filter(|word| *word != "--accept")
        .collect();
    if let Some(unknown) = chosen.iter().find(|name| !names().contains(*name)) {
        let names = names().join(", ");
        eprintln!("there is no part {unknown}; there are {names}");
        return ExitCode::from(2);
    }
    let mut failed = Vec::new();
    for part in &parts() {
        if chosen.is_empty() || chosen.contains(&part.name) {
            eprintln!("── {}", part.name);
            if measure(part, is_accepted, &Given::default()).is_none() {
                failed.push(part.name);
            }
        }
    }
    if !failed.is_empty() {
        eprintln!("── failed, see above: {}", failed.join(", "));
    }
    exit_code(failed.is_empty())
}

/// Makes the gallery: from the logs of real machines if their folder is given, else from the stored figures and curves.
///
/// - `words`: nothing, or the folder of the logs, or this folder and the program.
pub(crate) fn gallery(words: &[&str]) -> ExitCode {
    let absolute = |word: &&str| said(word, Path::new(word).canonicalize());
    let paths: Option<Vec<_>> = words.iter().map(absolute).collect();
    let made = paths.and_then(|paths| {
        let mut paths = paths.into_iter();
        let given = Given {
            data: paths.next(),
            sprung: paths.next(),
        };
        if given.data.is_none() {
            return write_pages();
        }
        // Logs and machines differ from person to person, so a worse figure is no failure here.
        let parts = parts();
        let part = parts.iter().find(|part| part.name == "gallery")?;
        measure(part, true, &given)
    });
    exit_code(made.is_some())
}

/// Measures a part and stores it; returns `None`, and prints why, if a program fails or a figure is worse.
fn measure(part: &Part, is_accepted: bool, given: &Given) -> Option<()> {
    let folder = target().join("figures");
    let notes = folder.join(format!("{}.jsonl", part.name));
    files::write(&notes, "")?;
    part.run(&notes.canonicalize().ok()?, given)?;
    let measured = Measured {
        commit: of(Command::new("git").args(["rev-parse", "--short=8", "HEAD"]))?,
        date: of(Command::new("date").args(["-u", "+%F"]))?,
        machine: machine(),
        figures: file::notes(&fs::read_to_string(&notes).ok()?)?,
    };
    // Another part may have been stored in the meantime.
    let path = root().join(FILE);
    let mut figures: Figures = files::json(&path)?;
    let worse = figures.worse(part.name, &measured);
    for line in &worse {
        eprintln!("── {line}");
    }
    if !worse.is_empty() && !is_accepted {
        eprintln!("── `--accept` stores these figures nevertheless");
        return None;
    }
    figures.0.insert(part.name.to_owned(), measured);
    files::write(&path, &figures.text())?;
    pages::fill_all(&figures).and(plots::write(&figures))
}

/// Writes the figures of the file into the pages and the drawings; returns `None`, and prints why, if one is absent.
pub(crate) fn write_pages() -> Option<()> {
    let figures = files::json(&root().join(FILE))?;
    pages::fill_all(&figures).and(plots::write(&figures))
}

/// Returns the output of a program in the root of the repository; `None`, and prints why, if it fails.
fn of(command: &mut Command) -> Option<String> {
    let output = command.current_dir(root()).output();
    match output {
        Ok(output) if output.status.success() => {
            Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
        }
        _ => {
            eprintln!("── {command:?} failed");
            None
        }
    }
}

/// Returns processor and cores of this machine.
fn machine() -> String {
    let text = fs::read_to_string(Path::new("/proc/cpuinfo")).unwrap_or_default();
    let model = (text.lines())
        .find_map(|line| line.strip_prefix("model name"))
        .and_then(|line| line.split_once(':'))
        .map_or(std::env::consts::ARCH, |(_, model)| model.trim());
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    format!("{cores} cores, {model}")
}
