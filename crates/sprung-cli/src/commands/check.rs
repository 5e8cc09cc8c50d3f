//! `sprung check`: findings about a log before any fit.

use sprung::check::{CheckReport, CheckedLog};
use sprung::finding::Severity;
use sprung::report::{compose_check, significant};
use sprung::session::{Session, Usability};

use super::servo;
use crate::args::Check;
use crate::command_line::command_line;
use crate::exit_code::{ExitCode, Failure};
use crate::output::{Folder, results_folder};
use crate::results::{write_html, write_json};
use crate::terminal::{Grid, Terminal, dash};

/// Names of the files that a check writes.
const CHECK_FILE: &str = "check.json";
const CHECK_REPORT_FILE: &str = "check.html";

pub(crate) fn run(args: &Check) -> Result<ExitCode, Failure> {
    let common = &args.common;
    let terminal = Terminal::new(common.voice, common.json);
    let session = Session::open(&args.experiment, &common.overrides)?;
    if session.is_servo() {
        return servo::check(&session, common);
    }
    let folder = Folder::new(
        &results_folder(&session, common),
        session.inputs(),
        &[CHECK_FILE, CHECK_REPORT_FILE],
    )?;
    let checked = terminal.follow("checking", |progress| session.check(progress))?;

    let mut output = folder.output()?;
    write_json(&mut output, CHECK_FILE, &checked.report)?;
    let document = compose_check(&checked, &command_line(), session.text());
    let report = write_html(&mut output, CHECK_REPORT_FILE, &document)?;
    output.commit()?;

    terminal.json(&checked.report);
    say(terminal, &checked.report);
    terminal.say(format!("\nreport: {}", report.display()));
    Ok(Usability::from(&checked.report).into())
}

/// Prints logs, joints, and findings with their remedies, on about one screen.
fn say(terminal: Terminal, report: &CheckReport) {
    for log in &report.logs {
        terminal.say(log.name());
        terminal.say(format!(
            "  {} samples, {} s at {} Hz{}",
            log.samples,
            significant(log.duration_s, 4),
            significant(log.rate_hz, 4),
            irregular(log)
        ));
    }
    if let Some(log) = report.logs.first() {
        terminal.table(&column_table(log));
    }
    terminal.table(&joint_table(report));
    terminal.unknowns(&report.unknowns);
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

/// Most jitter of a log with even time stamps, percent.
const EVEN_PERCENT: f64 = 1.0;

/// Returns the faults of sampling of a log; empty if there is nothing.
fn irregular(log: &CheckedLog) -> String {
    let counts = [
        (log.gaps, "gaps"),
        (log.dropped, "missing"),
        (log.repeated, "repeated"),
        (log.frozen, "frozen"),
    ];
    let mut parts: Vec<String> = (counts.into_iter())
        .filter(|(count, _)| *count > 0)
        .map(|(count, word)| format!("{count} {word}"))
        .collect();
    if log.jitter_percent > EVEN_PERCENT {
        parts.push(format!("jitter {} %", significant(log.jitter_percent, 2)));
    }
    if parts.is_empty() {
        String::new()
    } else {
        format!(": {}", parts.join(", "))
    }
}

fn column_table(log: &CheckedLog) -> Grid {
    let header = ["column", "unit", "from", "to", "noise", "step", "bits"];
    let mut table = Grid::new(header, 2).divided(2, 1).without(&[6, 5, 1]);
    for column in &log.columns {
        table.add_row([
            column.label(),
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

fn joint_table(report: &CheckReport) -> Grid {
    let header = ["joint", "explained %", "motor/link"];
    let mut table = Grid::new(header, 1).divided(1, 2);
    for joint in &report.joints {
        table.add_row([
            joint.joint.clone(),
            significant(joint.explained_percent, 4),
            dash(joint.slope, 4),
        ]);
    }
    table
}
