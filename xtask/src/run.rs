//! Runs test programs, shows their output, and collects times and skipped tests.

use std::io::{BufRead, BufReader, Read};
use std::num::NonZero;
use std::process::{Command, Stdio};
use std::sync::{Mutex, PoisonError};

use crate::binaries::{Binary, Kind};

/// Outcome of the tests of some programs. Names of tests begin with that of their program.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Outcome {
    /// Tests that did not fail, skipped ones included.
    pub(crate) ended: usize,
    /// Seconds of each test.
    pub(crate) times: Vec<(String, f64)>,
    /// Reasons of tests that were skipped or ignored; a test may give two.
    pub(crate) skipped: Vec<(String, String)>,
    /// Failed tests, and programs that failed otherwise.
    pub(crate) failed: Vec<String>,
}

impl Outcome {
    /// Runs all programs, one after another, also after a failure.
    pub(crate) fn of(binaries: &[Binary]) -> Self {
        let mut outcome = Self::default();
        for binary in binaries {
            outcome.add(binary, &[]);
        }
        outcome
    }

    /// Runs all programs, two at a time, also after a failure; the second begins when `beside` has returned.
    ///
    /// The tests of a program share half of the processors, so the last test of a program leaves no processor idle.
    pub(crate) fn beside<T: Send>(
        binaries: &[Binary],
        beside: impl FnOnce() -> T + Send,
    ) -> (Self, T) {
        let processors = std::thread::available_parallelism().map_or(1, NonZero::get);
        let arguments = [format!("--test-threads={}", processors.div_ceil(2))];
        let (outcomes, value) = two_at_a_time(longest_first(binaries), beside, |binary| {
            let mut outcome = Self::default();
            outcome.add(binary, &arguments);
            outcome
        });
        let mut all = Self::default();
        for outcome in outcomes {
            all.join(outcome);
        }
        (all, value)
    }

    fn join(&mut self, other: Self) {
        self.ended += other.ended;
        self.times.extend(other.times);
        self.skipped.extend(other.skipped);
        self.failed.extend(other.failed);
    }

    /// Runs a program and shows its output.
    fn add(&mut self, binary: &Binary, arguments: &[String]) {
        let failed_before = self.failed.len();
        match run(binary, arguments) {
            Ok((success, lines)) => {
                println!("── {}\n{}", binary.name, lines.join("\n"));
                for line in &lines {
                    self.take(&binary.name, line);
                }
                if !success && self.failed.len() == failed_before {
                    self.failed.push(binary.name.clone());
                }
            }
            Err(error) => {
                eprintln!("── cannot run {}: {error}", binary.path.display());
                self.failed.push(binary.name.clone());
            }
        }
    }

    /// Takes a line that a program printed.
    fn take(&mut self, program: &str, line: &str) {
        let of = |test: &str| format!("{program}: {test}");
        if let Some((test, reason)) =
            (line.strip_prefix("SKIPPED ")).and_then(|x| x.split_once(": "))
        {
            self.skipped.push((of(test), reason.to_owned()));
            return;
        }
        let Some((test, result)) =
            (line.strip_prefix("test ")).and_then(|line| line.rsplit_once(" ... "))
        else {
            return;
        };
        let (word, time) = result.split_once(" <").unwrap_or((result, ""));
        let test = of(test);
        if let Ok(seconds) = time.trim_end_matches("s>").parse() {
            self.times.push((test.clone(), seconds));
        }
        match word.split(',').next() {
            Some("ok") => self.ended += 1,
            Some("ignored") => {
                self.ended += 1;
                self.skipped
                    .push((test, "it is marked as ignored".to_owned()));
            }
            _ => self.failed.push(test),
        }
    }
}

/// Does two pieces of work at a time, in their order; the second begins when `beside` has returned.
///
/// Returns what each piece returned, in the order of their ends, and the value of `beside`.
pub(crate) fn two_at_a_time<I: Send, O: Send, T: Send>(
    pieces: Vec<I>,
    beside: impl FnOnce() -> T + Send,
    work: impl Fn(I) -> O + Sync,
) -> (Vec<O>, T) {
    let queue = Mutex::new(pieces.into_iter());
    let next = || queue.lock().ok()?.next();
    let done = Mutex::new(Vec::new());
    let row = || {
        while let Some(piece) = next() {
            let value = work(piece);
            done.lock()
                .unwrap_or_else(PoisonError::into_inner)
                .push(value);
        }
    };
    let value = std::thread::scope(|scope| {
        let second = scope.spawn(|| {
            let value = beside();
            row();
            value
        });
        row();
        (second.join()).unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    });
    (
        done.into_inner().unwrap_or_else(PoisonError::into_inner),
        value,
    )
}

/// Programs that take minutes. They begin first, so that none of them runs alone at the end.
const LONGEST: [&str; 2] = ["sprung-cli test cli", "sprung test twin"];

fn longest_first(binaries: &[Binary]) -> Vec<&Binary> {
    let mut all: Vec<&Binary> = binaries.iter().collect();
    all.sort_by_key(|binary| !LONGEST.contains(&binary.name.as_str()));
    all
}

/// Runs a program as cargo would; returns its success and the lines that it printed.
fn run(binary: &Binary, arguments: &[String]) -> std::io::Result<(bool, Vec<String>)> {
    let mut command = Command::new(&binary.path);
    if binary.kind == Kind::Tests {
        // Times of tests are unstable in libtest: the variable admits them on a stable toolchain.
        command
            .env("RUSTC_BOOTSTRAP", "1")
            .args(["-Z", "unstable-options", "--report-time"])
            .args(arguments);
    }
    let mut child = command
        .current_dir(&binary.package)
        .env("CARGO_MANIFEST_DIR", &binary.package)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()?;
    let (stdout, stderr) = (child.stdout.take(), child.stderr.take());
    let lines = std::thread::scope(|scope| {
        let errors = scope.spawn(|| read(stderr));
        let mut lines = read(stdout);
        lines.extend(errors.join().unwrap_or_default());
        lines
    });
    Ok((child.wait()?.success(), lines))
}

/// Returns the lines from a pipe.
fn read(from: Option<impl Read>) -> Vec<String> {
    let Some(from) = from else { return Vec::new() };
    let lines = BufReader::new(from).split(b'\n').map_while(Result::ok);
    lines
        .map(|line| String::from_utf8_lossy(&line).trim_end().to_owned())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn binary(name: &str) -> Binary {
        Binary {
            name: name.to_owned(),
            kind: Kind::Tests,
            path: ["/bin/", name].concat().into(),
            package: "/".into(),
        }
    }

    #[test]
    fn all_programs_run_also_after_one_that_fails() {
        let names = ["false", "true", "no such program", "echo"];
        let (outcome, value) = Outcome::beside(&names.map(binary), || 7);
        let mut failed = outcome.failed;
        failed.sort();
        assert_eq!(failed, ["false", "no such program"]);
        assert_eq!(value, 7);
    }

    #[test]
    fn programs_that_take_minutes_begin_first() {
        let all = ["a", LONGEST[1], "b", LONGEST[0]].map(binary);
        let names: Vec<&str> = (longest_first(&all).iter())
            .map(|binary| binary.name.as_str())
            .collect();
        assert_eq!(names, [LONGEST[1], LONGEST[0], "a", "b"]);
    }

    #[test]
    fn lines_of_libtest_are_understood() {
        let mut outcome = Outcome::default();
        for line in [
            "running 4 tests",
            "test laws::energy ... ok <0.250s>",
            "test laws::momentum - should panic ... ok <12.000s>",
            "test twin::paper ... FAILED <1.500s>",
            "test twin::slow ... ignored, takes an hour",
            "SKIPPED real_machine::emps: ../shared is absent",
            "test real_machine::emps ... ok <0.000s>",
            "test result: FAILED. 3 passed; 1 failed",
        ] {
            outcome.take("cli", line);
        }
        assert_eq!(outcome.ended, 4);
        assert_eq!(outcome.failed, ["cli: twin::paper"]);
        let skipped = |name: &str, why: &str| (name.to_owned(), why.to_owned());
        assert_eq!(
            outcome.skipped,
            [
                skipped("cli: twin::slow", "it is marked as ignored"),
                skipped("cli: real_machine::emps", "../shared is absent")
            ]
        );
        assert_eq!(outcome.times.len(), 4);
        assert_eq!(outcome.times[1].0, "cli: laws::momentum - should panic");
        assert!((outcome.times[1].1 - 12.0).abs() < 1e-12);
    }
}
