//! Fuzzing of every reader.

use std::process::{Command, ExitCode};

use crate::root;

/// Runs fuzz targets one after another, with seeds; stops at the first with a finding.
///
/// - `seconds`: how long each target runs.
/// - `chosen`: targets; all if empty.
pub(crate) fn run(seconds: &str, chosen: &[&str]) -> ExitCode {
    if !seeds() {
        eprintln!("── the seeds could not be written");
        return ExitCode::FAILURE;
    }
    let targets = if chosen.is_empty() {
        targets()
    } else {
        chosen.iter().map(|name| (*name).to_owned()).collect()
    };
    if targets.is_empty() {
        eprintln!("── there are no targets; install nightly with rustup, and cargo-fuzz");
        return ExitCode::FAILURE;
    }
    for target in targets {
        eprintln!("── {target}: {seconds} s");
        // Without the address sanitizer, which takes half of the time: none of our code is unsafe.
        let status = nightly()
            .args(["run", "--sanitizer", "none", &target, "--"])
            .arg(format!("-max_total_time={seconds}"))
            .args(["-timeout=10", "-rss_limit_mb=2048", "-print_final_stats=1"])
            .current_dir(root())
            .status();
        if !status.is_ok_and(|status| status.success()) {
            eprintln!("── {target}: found something; the file is in fuzz/artifacts/{target}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

/// Writes the corpus of faulty logs as seeds.
fn seeds() -> bool {
    let status = Command::new(env!("CARGO"))
        .args(["test", "-p", "sprung-cli", "--test", "cli"])
        .arg("the_corpus_is_large_and_always_the_same")
        .env("SPRUNG_CORPUS", root().join("fuzz/corpus"))
        .current_dir(root())
        .status();
    status.is_ok_and(|status| status.success())
}

/// Returns the names of all targets.
fn targets() -> Vec<String> {
    let list = nightly().arg("list").current_dir(root()).output();
    list.map_or_else(
        |_| Vec::new(),
        |list| {
            let names = String::from_utf8_lossy(&list.stdout);
            names.lines().map(str::to_owned).collect()
        },
    )
}

fn nightly() -> Command {
    let mut command = Command::new("rustup");
    command.args(["run", "nightly", "cargo", "fuzz"]);
    command
}
