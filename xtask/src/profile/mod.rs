//! Processor time by stages: runs of sprung under `perf`.

mod cases;
mod stacks;
mod stages;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

use crate::root;
use crate::steps::succeeds;
use cases::{CASES, Case};
use stacks::Stacks;
use stages::shares;

/// Bytes of the stack that each sample keeps.
const CALL_GRAPH: &str = "dwarf,16384";

/// Returns the names of the cases.
pub(crate) fn names() -> Vec<&'static str> {
    CASES.iter().map(|case| case.name).collect()
}

/// Builds sprung with the lines of its source, runs some cases and prints the time of each and the
/// shares of the stages.
///
/// - `chosen`: names of cases; all if empty.
pub(crate) fn run(chosen: &[&str]) -> ExitCode {
    if let Some(unknown) = chosen.iter().find(|name| !names().contains(name)) {
        eprintln!(
            "── there is no case {unknown}; there are {}",
            names().join(", ")
        );
        return ExitCode::from(2);
    }
    for program in ["perf", "addr2line", "readelf"] {
        if !is_installed(program) {
            eprintln!(
                "── {program} is not installed: on a Debian, `apt-get install linux-perf binutils` installs it"
            );
            return ExitCode::FAILURE;
        }
    }
    let cases = CASES
        .iter()
        .filter(|case| chosen.is_empty() || chosen.contains(&case.name));
    let done = build().and_then(|(sprung, folder)| {
        (cases.into_iter()).try_for_each(|case| profile(case, &sprung, &folder))
    });
    match done {
        Some(()) => ExitCode::SUCCESS,
        None => ExitCode::FAILURE,
    }
}

fn is_installed(program: &str) -> bool {
    let mut command = Command::new(program);
    command.arg("--version");
    (command.stdout(Stdio::null()).stderr(Stdio::null()).status())
        .is_ok_and(|status| status.success())
}

/// Builds sprung; returns the program and the folder of the logs and results.
fn build() -> Option<(PathBuf, PathBuf)> {
    let target = std::env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| root().join("target"), PathBuf::from)
        .join("profile");
    let mut cargo = Command::new(env!("CARGO"));
    cargo
        .args(["build", "--release", "--quiet", "--package", "sprung-cli"])
        .args(["--config", "profile.release.debug=\"line-tables-only\""])
        .arg("--target-dir")
        .arg(&target)
        .current_dir(root());
    eprintln!("── builds sprung in {}", target.display());
    succeeds(&mut cargo)?;
    let program = target.join("release/sprung").canonicalize().ok()?;
    Some((program, target.join("logs")))
}

/// Runs a case and prints its table.
fn profile(case: &Case, sprung: &Path, folder: &Path) -> Option<()> {
    let arguments = case.arguments(sprung, folder)?;
    let milliseconds = processor_time(case, sprung, &arguments)?;
    let recorded = folder.join("perf.data");
    let mut record = Command::new("perf");
    record
        .args(["record", "--quiet", "--call-graph", CALL_GRAPH])
        .args(["--freq", &case.per_second.to_string(), "-o"])
        .arg(&recorded)
        .arg(sprung)
        .args(&arguments);
    ran(&mut record)?;
    let stacks = Stacks::read(&recorded, sprung)?;
    println!(
        "{}: {}, one thread: {milliseconds:.0} ms of processor time",
        case.name, case.what
    );
    for (stage, share) in shares(&stacks.functions()) {
        let time = share * milliseconds;
        println!("    {stage:<24}{:6.1} %{time:9.0} ms", 100.0 * share);
    }
    Some(())
}

/// Returns the processor time of a run, ms, the mean of some runs.
fn processor_time(case: &Case, sprung: &Path, arguments: &[String]) -> Option<f64> {
    let mut stat = Command::new("perf");
    stat.args(["stat", "-x", ",", "-e", "task-clock", "-r"])
        .arg(case.timed_runs.to_string())
        .arg(sprung)
        .args(arguments);
    let text = ran(&mut stat)?;
    let line = text.lines().find(|line| line.contains("task-clock"))?;
    line.split(',').next()?.parse().ok()
}

/// Runs perf and sprung; returns their error output, or `None`, and shows it, if a run failed. A verdict that a result
/// is not usable is no failure.
fn ran(command: &mut Command) -> Option<String> {
    let output = command.stdout(Stdio::null()).output().ok()?;
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    if matches!(output.status.code(), Some(0 | 1)) {
        return Some(text);
    }
    eprintln!("{text}── {}", output.status);
    None
}
