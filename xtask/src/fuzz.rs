//! Fuzzing of every reader.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};

use crate::install::{hdf5, tool};
use crate::steps::{cargo, exit_code, succeeds};
use crate::{root, target};

/// The version of cargo-fuzz that is installed where none is.
const CARGO_FUZZ: &str = "0.13.2";

/// The target that needs libhdf5, and its feature.
const NEEDS_HDF5: &str = "mat73";

/// Words of libFuzzer before the number of inputs that it tried.
const EXECUTIONS: &str = "stat::number_of_executed_units:";

/// Result of a target.
struct Outcome {
    target: String,
    /// Inputs that it tried; `None` if it ended before it counted them.
    executions: Option<u64>,
    found: bool,
}

/// Checks that the fuzz targets compile; returns `None` if they do not.
pub(crate) fn compiles() -> Option<()> {
    let mut command = cargo();
    command.args(["check", "--quiet", "--manifest-path", "fuzz/Cargo.toml"]);
    // The workspace of the targets takes the compiled dependencies of the toolkit.
    command.arg("--target-dir").arg(target());
    if hdf5() {
        command.arg("--features=mat73");
    }
    succeeds(command.current_dir(root()))
}

/// Runs fuzz targets one after another, with seeds, also after one with a finding.
///
/// - `seconds`: how long each target runs.
/// - `chosen`: targets; all if empty.
pub(crate) fn run(seconds: &str, chosen: &[&str]) -> ExitCode {
    if !tool("cargo-fuzz", CARGO_FUZZ) {
        return ExitCode::FAILURE;
    }
    if !seeds() {
        eprintln!("── the seeds could not be written");
        return ExitCode::FAILURE;
    }
    let has_hdf5 = hdf5();
    let cargo_fuzz = Cargo { has_hdf5 };
    let targets = if chosen.is_empty() {
        Cargo::targets()
    } else {
        chosen.iter().map(|name| (*name).to_owned()).collect()
    };
    let (targets, skipped): (Vec<_>, Vec<_>) =
        (targets.into_iter()).partition(|name| has_hdf5 || name != NEEDS_HDF5);
    if targets.is_empty() {
        eprintln!("── there are no targets");
        return ExitCode::FAILURE;
    }
    // A target that does not compile has found nothing.
    for target in &targets {
        if succeeds(cargo_fuzz.compiler("build").arg(target)).is_none() {
            return ExitCode::FAILURE;
        }
    }
    let outcomes: Vec<Outcome> = (targets.into_iter())
        .map(|target| cargo_fuzz.fuzz(target, seconds))
        .collect();
    for outcome in &outcomes {
        let executions =
            (outcome.executions).map_or_else(|| "?".to_owned(), |count| count.to_string());
        let target = &outcome.target;
        let found = if outcome.found {
            format!("  a finding: fuzz/artifacts/{target}")
        } else {
            String::new()
        };
        println!("{executions:>12} inputs  {target}{found}");
    }
    for target in &skipped {
        println!("     SKIPPED because libhdf5 is absent: {target}");
    }
    exit_code(!outcomes.iter().any(|outcome| outcome.found))
}

/// How cargo-fuzz is called.
struct Cargo {
    has_hdf5: bool,
}

impl Cargo {
    /// Returns a command of cargo-fuzz.
    fn command(word: &str) -> Command {
        let mut command = Command::new(env!("CARGO"));
        // libFuzzer needs flags of the compiler that stable admits only with this variable.
        command.env("RUSTC_BOOTSTRAP", "1");
        command.args(["fuzz", word]).current_dir(root());
        command
    }

    /// Returns a command that compiles targets.
    fn compiler(&self, word: &str) -> Command {
        let mut command = Self::command(word);
        // Without the address sanitizer, which takes half of the time: none of our code is unsafe.
        command.args(["--sanitizer", "none"]);
        if self.has_hdf5 {
            command.args(["--features", NEEDS_HDF5]);
        }
        command
    }

    /// Returns the names of all targets.
    fn targets() -> Vec<String> {
        let list = Self::command("list").output();
        list.map_or_else(
            |_| Vec::new(),
            |list| {
                let names = String::from_utf8_lossy(&list.stdout);
                names.lines().map(str::to_owned).collect()
            },
        )
    }

    /// Runs a target, and shows what it prints.
    fn fuzz(&self, target: String, seconds: &str) -> Outcome {
        eprintln!("── {target}: {seconds} s");
        let mut command = self.compiler("run");
        command
            .args([&target, "--"])
            .arg(format!("-max_total_time={seconds}"))
            .args(["-timeout=30", "-rss_limit_mb=2048", "-print_final_stats=1"])
            .stderr(Stdio::piped());
        let mut executions = None;
        let success = command.spawn().is_ok_and(|mut child| {
            let lines = child
                .stderr
                .take()
                .map(|pipe| BufReader::new(pipe).split(b'\n'));
            for line in lines.into_iter().flatten().map_while(Result::ok) {
                let line = String::from_utf8_lossy(&line).into_owned();
                executions = executions.or_else(|| executions_in(&line));
                eprintln!("{line}");
            }
            child.wait().is_ok_and(|status| status.success())
        });
        Outcome {
            target,
            executions,
            found: !success,
        }
    }
}

/// Returns the number of inputs on a line of libFuzzer's statistics.
fn executions_in(line: &str) -> Option<u64> {
    line.strip_prefix(EXECUTIONS)?.trim().parse().ok()
}

/// Writes the corpus of faulty logs, and undamaged files, as seeds.
fn seeds() -> bool {
    let corpus = root().join("fuzz/corpus");
    let status = Command::new(env!("CARGO"))
        .args(["test", "-p", "sprung-cli", "--test", "cli"])
        .arg("the_corpus_is_large_and_always_the_same")
        .env("SPRUNG_CORPUS", &corpus)
        .current_dir(root())
        .status();
    status.is_ok_and(|status| status.success()) && Path::new(&corpus).is_dir()
}

#[cfg(test)]
mod tests {
    use super::executions_in;

    #[test]
    fn executions_are_read_from_the_statistics() {
        let line = "stat::number_of_executed_units: 204800";
        assert_eq!(executions_in(line), Some(204_800));
        assert_eq!(executions_in("stat::average_exec_per_sec:     1706"), None);
        assert_eq!(executions_in("#204800 DONE"), None);
    }
}
