//! Output for the user during and after a command.

mod foreign;
mod layout;
mod progress;
mod tables;

use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};

use sprung::check::UnknownResult;
use sprung::estimate::{Identification, Refinement, Verdict};
use sprung::finding::{Finding, Severity};
use sprung::foreign::escaped;
use sprung::progress::{Answer, Listener, Progress};
use sprung::report::{ShownUnknown, significant};
use sprung::validate::Validation;

use crate::args::{Color, Voice};
use foreign::bounded;
use layout::{Stream, wrapped};
use progress::{LONG_S, bar, long, show};
use tables::{error_table, parameter_table, spring_table, unknown_table};

pub(crate) use layout::Grid;
pub(crate) use tables::dash;

/// Writes messages to stderr and results to stdout.
#[derive(Clone, Copy)]
pub(crate) struct Terminal {
    voice: Voice,
    json: bool,
}

impl Terminal {
    pub(crate) fn new(voice: Voice, json: bool) -> Self {
        Self { voice, json }
    }

    /// Prints a result for people.
    pub(crate) fn say(self, text: impl std::fmt::Display) {
        if self.speaks() {
            let text = text.to_string();
            print(&wrapped(&escaped(&bounded(&text)), Stream::Stdout.width()));
        }
    }

    /// Prints a result with a verdict, in the colour of the verdict if the user requests colours.
    fn say_verdict(self, before: &str, (verdict, word): (Verdict, &str), after: &str) {
        if self.speaks() {
            let text = format!("{before}{word}{after}");
            let text = wrapped(&escaped(&bounded(&text)), Stream::Stdout.width());
            write_out(&text.replacen(word, &self.colored(verdict, word), 1));
        }
    }

    /// Prints a table for people.
    pub(crate) fn table(self, grid: &Grid) {
        if self.speaks() {
            print(&grid.text(Stream::Stdout.width()));
        }
    }

    fn speaks(self) -> bool {
        !self.voice.quiet && !self.json
    }

    /// Prints a result as JSON, if the user requests it.
    pub(crate) fn json(self, value: &impl serde::Serialize) {
        if self.json {
            print_json(value);
        }
    }

    /// Runs a function and shows its progress.
    ///
    /// - `what`: text until the run reports its first phase.
    pub(crate) fn follow<T>(self, what: &str, run: impl FnOnce(&mut dyn Listener) -> T) -> T {
        self.follow_until(|| false, what, run)
    }

    /// Runs a function like [`follow`](Self::follow), and stops it when `is_stopped` returns true.
    pub(crate) fn follow_until<T>(
        self,
        is_stopped: impl Fn() -> bool + Sync,
        what: &str,
        run: impl FnOnce(&mut dyn Listener) -> T,
    ) -> T {
        let bar = bar(what, self.voice.no_progress || !self.speaks());
        let outcome = run(&mut |progress: Progress| {
            match progress.expected_s {
                Some(seconds) if seconds > LONG_S && !self.voice.quiet => {
                    bar.suspend(|| complain(&long(progress.phase, seconds)));
                }
                _ => show(&bar, progress),
            }
            if is_stopped() {
                Answer::Stop
            } else {
                Answer::GoOn
            }
        });
        bar.finish_and_clear();
        outcome
    }

    /// Prints the parameters of all estimators, and the findings about the log and the first estimator.
    pub(crate) fn parameters(
        self,
        identification: &Identification,
        truth: Option<&BTreeMap<String, f64>>,
    ) {
        for line in of_log(identification) {
            self.say(line);
        }
        for result in &identification.results {
            let before = format!("{}: ", result.estimator);
            let after = format!(
                ", {} of {} parameters determined, condition number {} ({} scaled)",
                result.parameters.iter().filter(|p| p.identifiable).count(),
                result.parameters.len(),
                dash(result.condition_number, 4),
                dash(result.condition_number_scaled, 4),
            );
            self.say_verdict(&before, (result.verdict, result.verdict.word()), &after);
            if let Some(refinement) = result.refined() {
                self.say(disturbances(refinement));
            }
        }
        self.table(&parameter_table(identification, truth));
        for payload in &identification.payloads {
            self.say(format!("\n{}", payload.summary()));
        }
        for finding in &identification.findings {
            self.finding("log", finding);
        }
        for (i, result) in identification.results.iter().enumerate() {
            self.findings_about(&result.estimator, i > 0, result.warnings.iter());
        }
    }

    /// Prints the root mean square errors of all runs and parameter sets.
    pub(crate) fn validation(self, validation: &Validation) {
        for run in &validation.runs {
            if run.simulated {
                self.say(format!(
                    "{}: root mean square of measured minus simulated, tau in N·m, q and phi in rad; \
                     fit: error of the filtered torque; promise: largest error over the promised \
                     one ({})",
                    run.name, run.log
                ));
            } else {
                self.say(format!(
                    "{}: fit: error of the filtered torque; promise: largest error over the promised one; \
                     without a controller, sprung simulated no loop ({})",
                    run.name, run.log
                ));
            }
            self.table(&error_table(run));
            for finding in &run.findings {
                self.finding(&run.name, finding);
            }
            for (i, set) in run.sets.iter().enumerate() {
                let about = format!("{}, {}", run.name, set.parameters);
                let findings = set.findings.iter();
                self.findings_about(if i > 0 { &about } else { &run.name }, i > 0, findings);
            }
        }
    }

    /// Prints findings about a result. Findings about results that do not decide are only counted, unless the user
    /// requests notes.
    fn findings_about<'a>(
        self,
        about: &str,
        is_beside: bool,
        findings: impl Iterator<Item = &'a Finding>,
    ) {
        if !is_beside || self.voice.verbose {
            findings.for_each(|finding| self.finding(about, finding));
            return;
        }
        let mut codes: Vec<&str> = findings
            .filter(|finding| finding.severity != Severity::Info)
            .map(|finding| finding.code.as_str())
            .collect();
        codes.dedup();
        if !codes.is_empty() && !self.voice.quiet {
            complain(&format!(
                "note ({about}): {}; the verdict does not depend on this result, -v prints its findings",
                codes.join(", ")
            ));
        }
    }

    /// Prints a warning, or a note if the user requests notes.
    pub(crate) fn finding(self, about: &str, finding: &Finding) {
        if finding.severity == Severity::Info && !self.voice.verbose {
            return;
        }
        if !self.voice.quiet {
            complain(&format!(
                "{} ({about}, {}): {}{}",
                finding.severity.word(),
                finding.code,
                finding.text,
                remedy(finding)
            ));
        }
    }

    /// Prints a finding as a result, with the line of the experiment file that corrects it.
    pub(crate) fn finding_with_line(self, finding: &Finding) {
        self.say(format!(
            "{} ({}): {}{}",
            finding.severity.word(),
            finding.code,
            finding.text,
            remedy(finding)
        ));
    }

    /// Prints what a log shows beyond its description; nothing for an empty list.
    pub(crate) fn unknowns(self, found: &[UnknownResult]) {
        if !found.is_empty() {
            self.say(format!("\n{}", ShownUnknown::HEADING.to_lowercase()));
            self.say("(falls: by how much each lowers the squared error of the torques)");
            self.table(&unknown_table(found));
        }
    }

    /// Prints the springs by deflections and joint torques.
    pub(crate) fn springs(self, identification: &Identification) {
        if !identification.sensed_springs.is_empty() {
            self.say("\nsprings by deflections and joint torques");
            self.table(&spring_table(identification));
        }
    }

    /// Prints the changes beyond the experiment file that were applied.
    pub(crate) fn applied(self, identification: &Identification) {
        if identification.applied.is_empty() {
            return;
        }
        self.say("applied beyond the experiment file:");
        for change in &identification.applied {
            self.say(format!("  - {}", change.sentence()));
        }
    }

    /// Prints the decision on the first result, which decides the exit code.
    pub(crate) fn decision(self, identification: &Identification) {
        let Some(result) = identification.results.first() else {
            return;
        };
        let sentence = &result.decision.sentence;
        match sentence.split_once(':') {
            Some((word, rest)) => {
                self.say_verdict("", (result.verdict, word), &format!(":{rest}"));
            }
            None => self.say(sentence),
        }
        if !result.decision.findings.is_empty() {
            self.say(format!(
                "decided by: {} (sprung explain {})",
                result.decision.findings.join(", "),
                result.decision.findings[0]
            ));
        }
    }

    /// Returns a word in the colour of a verdict, if the user requests colours.
    fn colored(self, verdict: Verdict, word: &str) -> String {
        let color = match self.voice.color {
            Color::Always => true,
            Color::Never => false,
            Color::Auto => {
                std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none()
            }
        };
        let code = match verdict {
            Verdict::Good => 32,
            Verdict::Doubtful => 33,
            Verdict::Unusable => 31,
        };
        if color {
            format!("\x1b[1;{code}m{word}\x1b[0m")
        } else {
            word.to_owned()
        }
    }
}

/// Returns the remedy of a finding, and the line of the experiment file that corrects it, on separate lines.
fn remedy(finding: &Finding) -> String {
    let line = finding.setting.as_ref();
    let line = line.map_or_else(String::new, |line| format!("\n  line: {line}"));
    format!("\n  remedy: {}{line}", finding.remedy)
}

/// Returns the disturbances found by a refinement, as text.
fn disturbances(refinement: &Refinement) -> String {
    let rows = refinement.disturbances.iter().map(|row| {
        let name = row.row.trim_end_matches("_nm").trim_end_matches("_n");
        let share = 100.0 * row.disturbance_nm / row.torque_nm;
        format!("{name} {} %", significant(share, 2))
    });
    format!(
        "  disturbances relative to the motor torque: {}",
        rows.collect::<Vec<_>>().join(", ")
    )
}

/// Returns the delays, signs and gains that were estimated from the log, one per line.
fn of_log(identification: &Identification) -> Vec<String> {
    let log = &identification.log;
    let delays = log.delay_s.iter().filter_map(|(column, delay)| {
        let error = delay.standard_error?;
        Some(format!(
            "{column}: {} s late (standard error {} s)",
            significant(delay.value, 4),
            significant(error, 2)
        ))
    });
    let signs = log.sign.iter().map(|(column, sign)| {
        format!(
            "{column}: sign {} (log-likelihood +{} against the other)",
            sign.value,
            significant(sign.log_likelihood, 3)
        )
    });
    let gains = log.gain.iter().map(|(column, gain)| {
        format!(
            "{column}: gain {} (standard error {})",
            significant(gain.value, 5),
            significant(gain.standard_error, 2)
        )
    });
    delays.chain(signs).chain(gains).collect()
}

/// Prints an error or a warning on stderr.
#[expect(
    clippy::print_stderr,
    reason = "this is where messages leave the program"
)]
pub(crate) fn complain(message: &str) {
    let message = bounded(message);
    eprintln!("{}", wrapped(&escaped(&message), Stream::Stderr.width()));
}

/// Prints an error as JSON on stderr.
#[expect(
    clippy::print_stderr,
    reason = "this is where messages leave the program"
)]
pub(crate) fn complain_json(value: &impl serde::Serialize) {
    if let Ok(text) = serde_json::to_string_pretty(value) {
        eprintln!("{}", escaped(&text));
    }
}

/// Prints a value as JSON on stdout.
pub(crate) fn print_json(value: &impl serde::Serialize) {
    if let Ok(text) = serde_json::to_string_pretty(value) {
        print(&text);
    }
}

/// Whether a line of output could not be written.
static OUTPUT_LOST: AtomicBool = AtomicBool::new(false);

/// Returns whether a line of output could not be written.
pub(crate) fn output_lost() -> bool {
    OUTPUT_LOST.load(Ordering::Relaxed)
}

/// Prints a line on stdout.
pub(crate) fn print(text: &impl std::fmt::Display) {
    write_out(&escaped(&text.to_string()));
}

/// Writes a line on stdout. A closed pipe changes the exit code and gives no message, because its reader wants no more.
fn write_out(text: &str) {
    let mut stdout = std::io::stdout();
    if let Err(error) = writeln!(stdout, "{text}").and_then(|()| stdout.flush())
        && !OUTPUT_LOST.swap(true, Ordering::Relaxed)
        && error.kind() != std::io::ErrorKind::BrokenPipe
    {
        complain(&format!("error: cannot write to stdout: {error}"));
    }
}
