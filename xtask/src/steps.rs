//! Named steps and their times.

use std::fmt::Display;
use std::process::{Command, ExitCode};
use std::time::{Duration, Instant};

/// Steps that ran. A failed step does not stop the others: one run shows all faults.
pub(crate) struct Steps {
    /// When the first step could start.
    pub(crate) begin: Instant,
    pub(crate) times: Vec<Time>,
    /// Names of the steps that failed.
    pub(crate) failed: Vec<String>,
}

/// What a step took.
pub(crate) struct Time {
    pub(crate) step: String,
    pub(crate) elapsed: Duration,
    /// Of the commands that the step ran to their ends; unlike elapsed time, it hardly depends on other programs.
    /// `None` if the system does not provide it, or if another step ran at the same time.
    pub(crate) processor: Option<Duration>,
}

impl Default for Steps {
    fn default() -> Self {
        Self {
            begin: Instant::now(),
            times: Vec::new(),
            failed: Vec::new(),
        }
    }
}

impl Steps {
    /// Runs a step; returns its value, or `None` if it fails.
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
        eprintln!("── {name}: {what}");
        let (begin, used) = (Instant::now(), processor_time());
        let value = run();
        let processor = (processor_time().zip(used)).map(|(now, then)| now.saturating_sub(then));
        self.times.push(Time {
            step: name.to_owned(),
            elapsed: begin.elapsed(),
            processor,
        });
        if value.is_none() {
            self.failed.push(name.to_owned());
        }
        value
    }

    /// Adds a step that ran beside others.
    pub(crate) fn add(&mut self, step: &str, elapsed: Duration, succeeded: bool) {
        self.times.push(Time {
            step: step.to_owned(),
            elapsed,
            processor: None,
        });
        if !succeeded {
            self.failed.push(step.to_owned());
        }
    }

    /// Runs cargo as a step.
    pub(crate) fn cargo(&mut self, name: &str, arguments: &[&str]) {
        let what = format!("cargo {}", arguments.join(" "));
        self.step(name, &what, || {
            let mut command = cargo();
            let denied = ("RUSTDOCFLAGS", "--deny warnings");
            succeeds(command.args(arguments).env(denied.0, denied.1))
        });
    }
}

/// Returns cargo for a run of all checks: it compiles each crate once and as a whole.
///
/// The parts that cargo keeps for the next change of a crate cost processor time, and they are not optimised together, so
/// identification takes longer.
pub(crate) fn cargo() -> Command {
    let mut command = Command::new(env!("CARGO"));
    command.env("CARGO_INCREMENTAL", "0");
    command
}

/// Returns a value; `None`, and prints what failed and why, without one.
pub(crate) fn said<T>(what: impl Display, done: Result<T, impl Display>) -> Option<T> {
    done.inspect_err(|error| eprintln!("── {what}: {error}"))
        .ok()
}

/// Returns the exit code of a task.
pub(crate) fn exit_code(is_done: bool) -> ExitCode {
    if is_done {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
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

/// Runs a task of the project in a separate process and shows its output when it ends; returns `None`, and prints why, if
/// it fails.
pub(crate) fn task(words: &[&str]) -> Option<()> {
    let program = std::env::current_exe();
    let ended = program.and_then(|program| Command::new(program).args(words).output());
    match ended {
        Ok(output) => {
            let [out, errors] =
                [&output.stdout, &output.stderr].map(|stream| String::from_utf8_lossy(stream));
            eprint!("{out}{errors}");
            output.status.success().then_some(())
        }
        Err(error) => {
            eprintln!("── cannot start {}: {error}", words.join(" "));
            None
        }
    }
}

/// Returns the processor time of all commands that ended, with those that they started.
pub(crate) fn processor_time() -> Option<Duration> {
    of_children(&std::fs::read_to_string("/proc/self/stat").ok()?)
}

/// Returns the processor time of ended children from `/proc/PID/stat` (proc(5)).
fn of_children(stat: &str) -> Option<Duration> {
    // Hundredths of a second on every Linux.
    const TICK: Duration = Duration::from_millis(10);
    // The second field, the name of the program in parentheses, may contain blanks.
    let (_, from_third) = stat.rsplit_once(") ")?;
    let mut fields = from_third.split(' ').skip(16 - 3);
    let user: u32 = fields.next()?.parse().ok()?;
    let system: u32 = fields.next()?.parse().ok()?;
    Some(TICK * (user + system))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_step_runs_after_one_that_fails() {
        let mut steps = Steps::default();
        assert_eq!(steps.step("first", "", || None::<()>), None);
        assert_eq!(steps.step("second", "", || Some(2)), Some(2));
        assert_eq!(steps.failed, ["first"]);
        let names: Vec<&str> = steps.times.iter().map(|time| time.step.as_str()).collect();
        assert_eq!(names, ["first", "second"]);
    }

    #[test]
    fn processor_time_is_that_of_ended_children() {
        let stat = "42 (a name) of) S 1 42 42 0 -1 4194560 1 2 3 4 11 12 150 25 20 0 1 0 77 8 9";
        assert_eq!(of_children(stat), Some(Duration::from_millis(1750)));
        assert_eq!(of_children("42 (short) S 1"), None);
    }
}
