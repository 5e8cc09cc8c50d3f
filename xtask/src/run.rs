//! Runs test programs, shows what they print, and collects times and skipped tests.

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Command, Stdio};

use crate::binaries::{Binary, Kind};

/// What came of the tests of some programs. Names of tests begin with that of their program.
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
            println!("── {}", binary.name);
            let failed_before = outcome.failed.len();
            match run(binary) {
                Ok((success, lines)) => {
                    for line in &lines {
                        outcome.take(&binary.name, line);
                    }
                    if !success && outcome.failed.len() == failed_before {
                        outcome.failed.push(binary.name.clone());
                    }
                }
                Err(error) => {
                    eprintln!("── cannot run {}: {error}", binary.path.display());
                    outcome.failed.push(binary.name.clone());
                }
            }
        }
        outcome
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

/// Runs a program as cargo would, forwards what it prints, and returns its success and its lines.
fn run(binary: &Binary) -> std::io::Result<(bool, Vec<String>)> {
    let mut command = Command::new(&binary.path);
    if binary.kind == Kind::Tests {
        // Times of tests are unstable in libtest: the variable admits them on a stable toolchain.
        command
            .env("RUSTC_BOOTSTRAP", "1")
            .args(["-Z", "unstable-options", "--report-time"]);
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
        let errors = scope.spawn(|| forward(stderr, std::io::stderr()));
        let mut lines = forward(stdout, std::io::stdout());
        lines.extend(errors.join().unwrap_or_default());
        lines
    });
    Ok((child.wait()?.success(), lines))
}

/// Copies lines from a pipe to the terminal; returns them.
fn forward(from: Option<impl Read>, mut to: impl Write) -> Vec<String> {
    let mut lines = Vec::new();
    let Some(from) = from else { return lines };
    let mut reader = BufReader::new(from);
    let mut bytes = Vec::new();
    while reader
        .read_until(b'\n', &mut bytes)
        .is_ok_and(|read| read > 0)
    {
        // A terminal that is gone does not end the tests.
        let _ = to.write_all(&bytes).and_then(|()| to.flush());
        lines.push(String::from_utf8_lossy(&bytes).trim_end().to_owned());
        bytes.clear();
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

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
