//! `sprung check`: what is wrong with a log, before any fit.

use comfy_table::Table;
use sprung::check::{CheckError, CheckReport, Checked, CheckedLog, check};
use sprung::estimate::late_channels;
use sprung::finding::Severity;
use sprung::log::LogError;
use sprung::progress::Progress;
use sprung::report::{compose_check, render, significant};

use crate::args::Check;
use crate::exit_code::{ExitCode, Failure};
use crate::experiment::{Loaded, load, openers, sources};
use crate::output::Output;
use crate::terminal::{Terminal, dash, plain, show};

pub(crate) fn run(args: &Check) -> Result<ExitCode, Failure> {
    let common = &args.common;
    let terminal = Terminal::new(common.voice, common.json);
    let loaded = load(&args.experiment, &common.overrides)?;
    let mut checked = from_disk(&loaded, terminal)?;
    // Of a log that is not what the file says no likelihood says anything.
    if args.thorough && !checked.report.refused {
        delays(&loaded, &mut checked, terminal)?;
    }

    let mut output = Output::new(&loaded.out(common.out.as_ref()))?.keeping(loaded.inputs());
    output.write("check.json", |write| {
        serde_json::to_writer_pretty(&mut *write, &checked.report)?;
        writeln!(write)
    })?;
    let document = compose_check(&checked, &super::command_line(), &loaded.text);
    let html = render(&document).map_err(|error| {
        Failure::new(ExitCode::File, format!("cannot make the report: {error}"))
    })?;
    let report = output.text("check.html", &html)?;
    output.commit()?;

    terminal.json(&checked.report);
    say(terminal, &checked.report);
    terminal.say(format!("\nreport: {}", report.display()));
    Ok(match checked.report.worst() {
        Some(Severity::Error) => ExitCode::Log,
        Some(Severity::Serious) => ExitCode::Unusable,
        Some(Severity::Warning | Severity::Info) | None => ExitCode::Done,
    })
}

fn from_disk(loaded: &Loaded, terminal: Terminal) -> Result<Checked, Failure> {
    let paths = loaded.log_paths(None)?;
    let bar = terminal.progress("checking", None);
    let mut openers = openers(&loaded.folder, &paths);
    let mut sources = sources(&paths, &mut openers);
    let checked = check(
        &loaded.experiment,
        &loaded.model,
        &mut sources,
        &mut |progress: Progress| show(&bar, progress),
    );
    bar.finish_and_clear();
    checked.map_err(|error| {
        let code = match &error {
            CheckError::Log(LogError::Io { .. }) => ExitCode::File,
            CheckError::Log(_) => ExitCode::Log,
            _ => ExitCode::Usage,
        };
        Failure::new(code, error)
    })
}

/// Finds delays by the likelihood.
fn delays(loaded: &Loaded, checked: &mut Checked, terminal: Terminal) -> Result<(), Failure> {
    let paths = loaded.log_paths(None)?;
    let bar = terminal.progress("finding delays", None);
    let mut openers = openers(&loaded.folder, &paths);
    let mut sources = sources(&paths, &mut openers);
    let mut progress = |progress: Progress| show(&bar, progress);
    let found = late_channels(
        &loaded.experiment,
        &loaded.model,
        &mut sources,
        &mut progress,
    );
    bar.finish_and_clear();
    checked.with_delays(&found.map_err(|error| super::identify::failure(&error))?);
    Ok(())
}

/// One screen: logs, joints, and findings with their remedies.
fn say(terminal: Terminal, report: &CheckReport) {
    for log in &report.logs {
        terminal.say(format!(
            "{}: {} samples, {} s at {} Hz (period {} ms), jitter up to {} %, {} gaps, {} samples \
             missing, {} repeated, {} frozen",
            log.file,
            log.samples,
            significant(log.duration_s, 4),
            significant(log.rate_hz, 4),
            significant(1e3 * log.period_s, 4),
            significant(log.jitter_percent, 2),
            log.gaps,
            log.dropped,
            log.repeated,
            log.frozen
        ));
    }
    if let Some(log) = report.logs.first() {
        terminal.say(column_table(log));
    }
    terminal.say(joint_table(report));
    let of = |severity: Severity| report.counts.get(severity.word()).copied().unwrap_or(0);
    terminal.say(format!(
        "errors {}, serious {}, warnings {}, notes {}",
        of(Severity::Error),
        of(Severity::Serious),
        of(Severity::Warning),
        of(Severity::Info)
    ));
    for finding in &report.findings {
        terminal.finding_with_line(finding);
    }
}

fn column_table(log: &CheckedLog) -> Table {
    let header = ["column", "unit", "from", "to", "noise", "step", "bits"];
    let mut table = plain(header.map(str::to_owned).to_vec(), 2);
    for column in &log.columns {
        table.add_row([
            column.column.clone(),
            column.unit.clone(),
            significant(column.min, 4),
            significant(column.max, 4),
            dash(column.noise, 2),
            dash(column.step, 2),
            dash(column.effective_bits, 3),
        ]);
    }
    table
}

fn joint_table(report: &CheckReport) -> Table {
    let header = [
        "joint",
        "torque explained %",
        "motor/link",
        "most likely late",
        "by ms",
        "± s.e.",
    ];
    let mut table = plain(header.map(str::to_owned).to_vec(), 1);
    for joint in &report.joints {
        let delay = joint.delay.as_ref();
        table.add_row([
            joint.joint.clone(),
            significant(joint.explained_percent, 4),
            dash(joint.slope, 4),
            delay.map_or_else(|| "-".to_owned(), |delay| delay.column.clone()),
            dash(delay.map(|delay| 1e3 * delay.delay_s), 3),
            dash(delay.map(|delay| 1e3 * delay.standard_error_s), 2),
        ]);
    }
    table
}
