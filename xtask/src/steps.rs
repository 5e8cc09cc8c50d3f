//! Named steps, one after another, and how long each took.

use std::process::Command;
use std::time::{Duration, Instant};

/// Steps that ran; after the first that fails, no other starts.
#[derive(Default)]
pub(crate) struct Steps {
    pub(crate) times: Vec<(String, Duration)>,
    pub(crate) failed: Option<String>,
}

impl Steps {
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
        self.step(name, &what, || {
            let mut command = Command::new(env!("CARGO"));
            succeeds(
                command
                    .args(arguments)
                    .env("RUSTDOCFLAGS", "--deny warnings"),
            )
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
