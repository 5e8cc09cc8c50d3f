//! `cargo xtask figures`: measures the figures of the documentation.
//!
//! Benchmarks note their figures in a file that `SPRUNG_FIGURES` names. The task keeps them in `benches/figures.json`
//! with commit, date and machine. Pages take them from there.

mod file;
mod pages;
mod parts;
mod run;

use std::fs;
use std::path::Path;
use std::process::{Command, ExitCode};
use std::time::Instant;

use file::{Figures, Measured};
use parts::{PARTS, Part};

use crate::{root, target};

/// Results, relative to the root of the repository.
const FILE: &str = "benches/figures.json";

/// Returns the names of all parts.
pub(crate) fn names() -> Vec<&'static str> {
    PARTS.iter().map(|part| part.name).collect()
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
        eprintln!(
            "there is no part {unknown}; there are {}",
            names().join(", ")
        );
        return ExitCode::from(2);
    }
    let Some(known) = Figures::read(&root().join(FILE)) else {
        return ExitCode::FAILURE;
    };
    let mut failed = Vec::new();
    for part in PARTS
        .iter()
        .filter(|part| chosen.is_empty() || chosen.contains(&part.name))
    {
        let before = known.parts.get(part.name);
        let took = before.map_or_else(String::new, |before| {
            format!(": it took {} minutes before", before.minutes)
        });
        eprintln!("── {}{took}", part.name);
        if measure(part, is_accepted).is_none() {
            failed.push(part.name);
        }
    }
    if failed.is_empty() {
        return ExitCode::SUCCESS;
    }
    eprintln!("── failed, see above: {}", failed.join(", "));
    ExitCode::FAILURE
}

/// Measures a part and stores it; returns `None`, and prints why, if it is not stored or a page lacks a figure.
fn measure(part: &Part, is_accepted: bool) -> Option<()> {
    let path = root().join(FILE);
    let notes = target()
        .join("figures")
        .join(format!("{}.jsonl", part.name));
    let begin = Instant::now();
    let ended = part.run(&notes);
    let text = fs::read_to_string(&notes).unwrap_or_default();
    let measured = Measured {
        command: format!("cargo xtask figures {}", part.name),
        commit: git(&["rev-parse", "--short=8", "HEAD"])?,
        date: of(Command::new("date").args(["-u", "+%F"]))?,
        machine: machine(),
        code: fingerprint(part)?,
        minutes: (begin.elapsed().as_secs_f64() / 60.0).ceil(),
        figures: file::notes(&text)?,
    };
    // Another part may have been stored in the meantime.
    let mut figures = Figures::read(&path)?;
    let worse = figures.worse(part.name, &measured);
    for line in &worse {
        eprintln!("── {line}");
    }
    if ended.is_none() && measured.figures.is_empty() {
        return None;
    }
    if !worse.is_empty() && !is_accepted {
        eprintln!(
            "── `--accept` stores the figures of {} nevertheless",
            part.name
        );
        return None;
    }
    figures.parts.insert(part.name.to_owned(), measured);
    figures.write(&path)?;
    pages::fill_all(&figures)?;
    ended
}

/// Writes the figures of the file into the pages; returns `None`, and prints why, if a page requests an absent one.
pub(crate) fn write_pages() -> Option<()> {
    pages::fill_all(&Figures::read(&root().join(FILE))?)
}

/// Returns a number for the code that a part measures: it changes with each file of that code.
fn fingerprint(part: &Part) -> Option<String> {
    let files = git(&[&["ls-files", "--"], &part.code.concat()[..]].concat())?;
    let present: Vec<&str> = (files.lines())
        .filter(|file| root().join(file).exists())
        .collect();
    let hashes = git_with(&["hash-object", "--stdin-paths"], &present.join("\n"))?;
    let all = git_with(&["hash-object", "--stdin"], &(present.join("\n") + &hashes))?;
    Some(all.chars().take(12).collect())
}

fn git(arguments: &[&str]) -> Option<String> {
    of(Command::new("git").args(arguments).current_dir(root()))
}

fn git_with(arguments: &[&str], input: &str) -> Option<String> {
    let folder = target().join("figures");
    fs::create_dir_all(&folder).ok()?;
    let thread = std::thread::current();
    let name = format!("input-{}-{:?}", std::process::id(), thread.id());
    let path = folder.join(name);
    fs::write(&path, input).ok()?;
    let file = fs::File::open(&path).ok()?;
    let output = of(Command::new("git")
        .args(arguments)
        .current_dir(root())
        .stdin(file));
    fs::remove_file(&path).ok()?;
    output
}

/// Returns the output of a program; `None`, and prints the reason, if it fails.
fn of(command: &mut Command) -> Option<String> {
    let program = command.get_program().to_string_lossy().into_owned();
    let output = command
        .output()
        .inspect_err(|error| eprintln!("── cannot run {program}: {error}"))
        .ok()?;
    if !output.status.success() {
        let error = String::from_utf8_lossy(&output.stderr);
        eprintln!("── {program}: {}: {}", output.status, error.trim());
        return None;
    }
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
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
