//! Named steps and the time of each.

use std::process::Command;
use std::time::{Duration, Instant};

/// Steps that ran; after the first that fails, no other starts.
pub(crate) struct Steps {
    /// When the first step could start.
    pub(crate) begin: Instant,
    pub(crate) times: Vec<(String, Duration)>,
    pub(crate) failed: Option<String>,
    /// Whether other steps print at the same time: what cargo prints is then shown only if it fails.
    is_quiet: bool,
}

impl Default for Steps {
    fn default() -> Self {
        Self {
            begin: Instant::now(),
            times: Vec::new(),
            failed: None,
            is_quiet: false,
        }
    }
}

impl Steps {
    /// Starts steps that run at the same time as others, after `earlier`; none runs if one of `earlier` failed.
    pub(crate) fn beside(earlier: &Self) -> Self {
        Self {
            failed: earlier.failed.clone(),
            is_quiet: true,
            ..Self::default()
        }
    }

    /// Adds steps that ran beside others.
    ///
    /// - `other`: `None` if they ended in a panic.
    pub(crate) fn join(&mut self, other: Option<Self>) {
        let Some(other) = other else {
            self.failed = Some("a step that ended in a panic".to_owned());
            return;
        };
        self.times.extend(other.times);
        self.failed = self.failed.take().or(other.failed);
    }

    /// Runs a step unless another failed; returns its value, or `None` if one of them failed.
    ///
    /// - `name`: shown ahead of the step and beside its time.
    /// - `what`: what runs, for the terminal.
    /// - `run`: returns `None` if the step fails; it prints why.
    pub(crate) fn step<T>(
        &mut self,
        name: &str,
        what: &str,
        run: impl FnOnce() -> Option<T>,
    ) -> Option<T> {
        if self.failed.is_some() {
            return None;
        }
        eprintln!("── {name}: {what}");
        let begin = Instant::now();
        let value = run();
        self.times.push((name.to_owned(), begin.elapsed()));
        if value.is_none() {
            self.failed = Some(name.to_owned());
        }
        value
    }

    /// Runs cargo as a step.
    pub(crate) fn cargo(&mut self, name: &str, arguments: &[&str]) {
        let what = format!("cargo {}", arguments.join(" "));
        let is_quiet = self.is_quiet;
        self.step(name, &what, || {
            let mut command = Command::new(env!("CARGO"));
            command
                .args(arguments)
                .env("RUSTDOCFLAGS", "--deny warnings");
            if is_quiet {
                succeeds_quietly(&mut command)
            } else {
                succeeds(&mut command)
            }
        });
    }
}

/// Runs a command; returns `None`, and prints why, if it does not succeed.
pub(crate) fn succeeds(command: &mut Command) -> Option<()> {
    let program = command.get_program().to_string_lossy().into_owned();
    match command.status() {
        Ok(status) if status.success() => Some(()),
        Ok(status) => {
            eprintln!("── {program}: {status}");
            None
        }
        Err(error) => {
            eprintln!("── cannot run {program}: {error}");
            None
        }
    }
}

/// Runs a command; shows what it printed, and returns `None`, if it does not succeed.
fn succeeds_quietly(command: &mut Command) -> Option<()> {
    match command.output() {
        Ok(output) if output.status.success() => Some(()),
        Ok(output) => {
            for text in [output.stdout, output.stderr] {
                eprintln!("{}", String::from_utf8_lossy(&text));
            }
            eprintln!("── {}", output.status);
            None
        }
        Err(error) => {
            eprintln!("── cannot run cargo: {error}");
            None
        }
    }
}
