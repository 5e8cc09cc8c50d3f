//! Output for the user during and after a command.

use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};

use comfy_table::{CellAlignment, Table, presets};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use sprung::estimate::{EstimateResult, Identification, Refinement, Verdict};
use sprung::finding::{Finding, Severity};
use sprung::model::short;
use sprung::progress::{Answer, Listener, Phase, Progress};
use sprung::report::significant;
use sprung::validate::{JointProof, Validation};

use crate::args::{Color, Voice};

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
        if !self.voice.quiet && !self.json {
            print(&text);
        }
    }

    /// Prints a result as JSON, if the user asked for it.
    pub(crate) fn json(self, value: &impl serde::Serialize) {
        if self.json {
            print_json(value);
        }
    }

    /// Runs a function and shows its progress.
    ///
    /// - `what`: text until the run reports its first phase.
    pub(crate) fn follow<T>(self, what: &str, run: impl FnOnce(&mut dyn Listener) -> T) -> T {
        let bar = self.bar(what);
        let outcome = run(&mut |progress: Progress| {
            match progress.expected_s {
                Some(seconds) if seconds > LONG_S && !self.voice.quiet => {
                    bar.suspend(|| complain(&long(progress.phase, seconds)));
                }
                _ => show(&bar, progress),
            }
            Answer::GoOn
        });
        bar.finish_and_clear();
        outcome
    }

    fn bar(self, what: &str) -> ProgressBar {
        let hidden = self.voice.no_progress || self.voice.quiet || self.json;
        let bar = ProgressBar::new_spinner();
        bar.set_draw_target(if hidden {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr()
        });
        set_template(&bar, SAMPLES_OF_UNKNOWN_TOTAL);
        bar.set_message(what.to_owned());
        bar
    }

    /// Prints the parameters of all estimators.
    pub(crate) fn parameters(
        self,
        identification: &Identification,
        truth: Option<&BTreeMap<String, f64>>,
    ) {
        for line in of_log(identification) {
            self.say(line);
        }
        for result in &identification.results {
            self.say(format!(
                "{}: {}, {} of {} parameters determined, condition number {} ({} scaled)",
                result.estimator,
                self.colored(result.verdict, result.verdict.word()),
                result.parameters.iter().filter(|p| p.identifiable).count(),
                result.parameters.len(),
                dash(result.condition_number, 4),
                dash(result.condition_number_scaled, 4),
            ));
            if let Some(refinement) = result.refined() {
                self.say(disturbances(refinement));
            }
        }
        self.say(parameter_table(identification, truth));
        for finding in &identification.findings {
            self.finding("log", finding);
        }
        for result in &identification.results {
            for finding in &result.warnings {
                self.finding(&result.estimator, finding);
            }
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
            self.say(error_table(run));
            let of_sets = run.sets.iter().flat_map(|set| &set.findings);
            for finding in run.findings.iter().chain(of_sets) {
                self.finding(&run.name, finding);
            }
        }
    }

    /// Prints a warning, or a note if the user wants notes.
    pub(crate) fn finding(self, about: &str, finding: &Finding) {
        if finding.severity == Severity::Info && !self.voice.verbose {
            return;
        }
        let word = finding.severity.word();
        let line =
            (finding.setting.as_ref()).map_or_else(String::new, |line| format!("\n  line: {line}"));
        if !self.voice.quiet {
            complain(&format!(
                "{word} ({about}, {}): {}\n  remedy: {}{line}",
                finding.code, finding.text, finding.remedy
            ));
        }
    }

    /// Prints a finding as a result, with the line of the experiment file that corrects it.
    pub(crate) fn finding_with_line(self, finding: &Finding) {
        let line =
            (finding.setting.as_ref()).map_or_else(String::new, |line| format!("\n  line: {line}"));
        self.say(format!(
            "{} ({}): {}\n  remedy: {}{line}",
            finding.severity.word(),
            finding.code,
            finding.text,
            finding.remedy
        ));
    }

    /// Prints the decision on the first result, which decides the exit code.
    pub(crate) fn decision(self, identification: &Identification) {
        let Some(result) = identification.results.first() else {
            return;
        };
        let sentence = &result.decision.sentence;
        match sentence.split_once(':') {
            Some((word, rest)) => {
                self.say(format!("{}:{rest}", self.colored(result.verdict, word)));
            }
            None => self.say(sentence),
        }
    }

    /// Returns a word in the colour of a verdict, if the user wants colours.
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

/// Templates of the progress bar: samples with unknown total, samples with known total, and filter
/// runs.
const SAMPLES_OF_UNKNOWN_TOTAL: &str = "{msg} {spinner} {human_pos} samples";
const SAMPLES_OF_TOTAL: &str = "{msg} [{bar:30}] {human_pos} of {human_len} samples, {eta} left";
const FILTER_RUNS: &str =
    "{msg} {spinner} filter run {human_pos} of at most {human_len}, {elapsed}";

fn set_template(bar: &ProgressBar, template: &str) {
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
}

/// Shows progress on a bar.
fn show(bar: &ProgressBar, progress: Progress) {
    match (progress.phase, progress.total) {
        (Phase::FindingDelays | Phase::Refining, Some(most)) => {
            set_template(bar, FILTER_RUNS);
            bar.set_message(progress.phase.word());
            bar.set_length(most);
            bar.set_position(progress.done);
            // A filter run may take seconds without a report.
            bar.enable_steady_tick(TICK_INTERVAL);
        }
        (Phase::Simulating, Some(total)) => {
            if bar.length() != Some(total) {
                set_template(bar, SAMPLES_OF_TOTAL);
                bar.set_length(total);
            }
            bar.set_position(progress.done);
        }
        (Phase::Reading | Phase::Validating, _) => {
            // Samples are counted again after filter runs.
            if bar.length().is_some() {
                bar.disable_steady_tick();
                set_template(bar, SAMPLES_OF_UNKNOWN_TOTAL);
                bar.set_message(progress.phase.word());
                bar.unset_length();
            }
            bar.set_position(progress.done);
        }
        _ => bar.tick(),
    }
}

/// Expected duration of a phase from which the terminal announces it, s.
const LONG_S: f64 = 60.0;

/// Returns the announcement of a long phase.
fn long(phase: Phase, seconds: f64) -> String {
    let minutes = (seconds / 60.0).ceil();
    format!(
        "{} takes about {minutes:.0} min; Ctrl-C ends it and keeps the result of least squares",
        phase.word()
    )
}

/// Interval between two drawings of a bar without reports.
const TICK_INTERVAL: std::time::Duration = std::time::Duration::from_millis(200);

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

/// Prints an error or a warning on stderr.
#[expect(
    clippy::print_stderr,
    reason = "this is where messages leave the program"
)]
pub(crate) fn complain(message: &str) {
    eprintln!("{message}");
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

/// Prints a line on stdout. It is not an error if the reader of a pipe has gone.
fn print(text: &impl std::fmt::Display) {
    let mut stdout = std::io::stdout();
    if let Err(error) = writeln!(stdout, "{text}").and_then(|()| stdout.flush())
        && error.kind() != std::io::ErrorKind::BrokenPipe
        && !OUTPUT_LOST.swap(true, Ordering::Relaxed)
    {
        complain(&format!("error: cannot write to stdout: {error}"));
    }
}

pub(crate) fn dash(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| significant(value, digits))
}

/// Returns a table whose first `left` columns are text.
pub(crate) fn plain(header: Vec<String>, left: usize) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    let width = header.len();
    table.set_header(header);
    for column in left..width {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

fn parameter_table(
    identification: &Identification,
    truth: Option<&BTreeMap<String, f64>>,
) -> Table {
    let reference = if truth.is_some() { "true" } else { "nominal" };
    let mut header = vec![
        "parameter".to_owned(),
        "unit".to_owned(),
        reference.to_owned(),
    ];
    for result in &identification.results {
        header.push(result.estimator.clone());
        header.push("± s.e.".to_owned());
        header.push(
            if truth.is_some() {
                "error %"
            } else {
                "% of nominal"
            }
            .to_owned(),
        );
    }
    let mut table = plain(header, 2);
    let of = |result: &EstimateResult, i: usize, reference: Option<f64>| {
        let estimate = &result.parameters[i];
        let share = estimate.value.zip(reference).filter(|(_, r)| *r != 0.0);
        let share = share.map_or_else(
            || "-".to_owned(),
            |(value, reference)| match truth {
                Some(_) => format!("{:+.1}", 100.0 * (value / reference - 1.0)),
                None => format!("{:.1}", 100.0 * value / reference),
            },
        );
        [
            dash(estimate.value, 5),
            dash(estimate.standard_error, 2),
            share,
        ]
    };
    for (i, parameter) in (identification.results.first())
        .map(|result| result.parameters.iter().enumerate())
        .into_iter()
        .flatten()
    {
        let reference = match truth {
            Some(truth) => truth.get(&parameter.name).copied(),
            None => parameter.nominal,
        };
        let mut row = vec![
            short(&parameter.name).into_owned(),
            parameter.unit.clone(),
            dash(reference, 5),
        ];
        for result in &identification.results {
            row.extend(of(result, i, reference));
        }
        table.add_row(row);
    }
    table
}

/// Maximum number of joints that share a row.
const MAX_JOINTS_PER_ROW: usize = 3;

/// Returns a table with one row per parameter set and joint.
fn error_table_by_joint(run: &sprung::validate::RunResult) -> Table {
    let names = ["parameters", "joint", "tau", "q", "phi", "fit %", "promise"];
    let shown = |i: &usize| run.simulated || !(2..5).contains(i);
    let columns = || (0..names.len()).filter(shown);
    let mut table = plain(columns().map(|i| names[i].to_owned()).collect(), 2);
    for set in &run.sets {
        for joint in run.joints() {
            let e = set.e_rms.as_ref();
            let error = |values: Option<&sprung::named::Named>| match values {
                Some(values) => dash(values.get(joint), 3),
                None => set.outcome.words().to_owned(),
            };
            let share = set.torque_relative_residual.get(joint);
            let cells = [
                set.parameters.clone(),
                joint.to_owned(),
                error(e.map(|e| &e.tau_nm)),
                error(e.map(|e| &e.q_rad)),
                error(e.map(|e| &e.phi_rad)),
                share.map_or_else(|| "-".to_owned(), |share| format!("{:.1}", 100.0 * share)),
                promise((set.predictions.iter()).filter(|own| own.joint == joint)),
            ];
            table.add_row(columns().map(|i| cells[i].clone()));
        }
    }
    table
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

fn error_table(run: &sprung::validate::RunResult) -> Table {
    let joints = run.joints();
    if joints.len() > MAX_JOINTS_PER_ROW {
        return error_table_by_joint(run);
    }
    let simulated: &[&str] = if run.simulated {
        &["tau", "q", "phi"]
    } else {
        &[]
    };
    let mut header = vec!["parameters".to_owned()];
    for symbol in simulated {
        header.extend(joints.iter().map(|joint| format!("{symbol} {joint}")));
    }
    header.extend(joints.iter().map(|joint| format!("{joint} fit %")));
    header.push("promise".to_owned());
    let mut table = plain(header, 1);
    for set in &run.sets {
        let mut row = vec![set.parameters.clone()];
        for group in 0..simulated.len() {
            row.extend(joints.iter().map(|joint| match &set.e_rms {
                Some(e) => {
                    let values = [&e.tau_nm, &e.q_rad, &e.phi_rad][group];
                    dash(values.get(joint), 3)
                }
                None => set.outcome.words().to_owned(),
            }));
        }
        row.extend(joints.iter().map(|joint| {
            let share = set.torque_relative_residual.get(joint);
            share.map_or_else(|| "-".to_owned(), |share| format!("{:.1}", 100.0 * share))
        }));
        row.push(promise(set.predictions.iter()));
        table.add_row(row);
    }
    table
}

/// Returns whether errors keep their promise, with the largest ratio of error to promised error.
fn promise<'a>(proofs: impl Iterator<Item = &'a JointProof>) -> String {
    let largest = (proofs.flat_map(JointProof::quantities))
        .filter_map(|quantity| Some((quantity.ratio?, quantity.is_broken())))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    match largest {
        None => "-".to_owned(),
        Some((ratio, true)) => format!("broken, {ratio:.1} times"),
        Some((ratio, false)) => format!("kept, {ratio:.1} times"),
    }
}
