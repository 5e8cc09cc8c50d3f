//! Composes the report of a check: the findings about a log and their evidence.

use super::document::{
    Badge, Block, Document, Figure, Fold, Layout, Panel, Series, Style, Table, Tone,
};
use super::numbers::{or_dash, significant};
use super::rows::rows;
use super::section::{folded, origin, section, shown};
use super::unknowns::unknowns;
use super::verdict::{as_sentence, first_sentence};
use crate::curves::Curves;
use crate::finding::{Finding, Severity};
use sprung_method::check::{CheckReport, Checked, CheckedLog, ColumnFigures, FindingSamples};

/// Composes the report of a check.
///
/// - `command`: the command that made the report; `experiment`: the text of the experiment file.
#[must_use]
pub fn compose_check(checked: &Checked, command: &str, experiment: &str) -> Document {
    let report = &checked.report;
    let mut sections = vec![
        section(
            "findings",
            "Findings",
            "An error means that the log contradicts the experiment file; sprung identify refuses \
             such a log. A warning makes results doubtful. Each finding contains a remedy and, if \
             possible, the line of the experiment file for it.",
            findings(checked),
        ),
        section(
            "joints",
            "Joints",
            "These figures come from the beginning of the first log. The table shows the percentage \
             of each joint's filtered torque that its motion explains. Below the resonance of a joint, \
             motor and link move equally far; at the resonance, the motor moves less.",
            vec![Block::Table(joints(report))],
        ),
    ];
    let beyond = unknowns(&report.unknowns);
    sections.splice(1..1, beyond);
    for (k, log) in report.logs.iter().enumerate() {
        sections.push(folded(
            Fold::Screen,
            &format!("log-{k}"),
            &log.name(),
            &format!(
                "{} samples in {} s, {} Hz; steps of the time differ by up to {} %; {} gaps, {} s in \
                 total.",
                log.samples,
                significant(log.duration_s, 5),
                significant(log.rate_hz, 5),
                significant(log.jitter_percent, 2),
                log.gaps,
                significant(log.gap_duration_s, 3)
            ),
            vec![Block::Table(columns(log))],
        ));
    }
    sections.push(section(
        "overview",
        "The first log",
        "Smallest and largest value of each part of the log.",
        vec![Block::Figure(overview(report, &checked.overview))],
    ));
    sections.push(origin(Fold::Detail, command, Some(experiment)));
    let above_notes = |finding: &&Finding| finding.severity > Severity::Info;
    let worst = (report.findings.iter().filter(above_notes)).max_by_key(|one| one.severity);
    Document {
        title: report.robot.clone(),
        subtitle: format!(
            "Check of {}",
            (report.logs.iter().map(CheckedLog::name))
                .collect::<Vec<_>>()
                .join(", ")
        ),
        generator: report.generator.clone(),
        verdict: Some(badge(report)),
        summary: summary(report),
        reason: worst.map_or_else(String::new, |finding| first_sentence(&finding.text)),
        what_to_do: worst.map_or_else(
            || "Run sprung identify.".to_owned(),
            |finding| as_sentence(&finding.remedy),
        ),
        sections,
        ..Document::default()
    }
}

/// Returns the consequence of the check for an identification, in a sentence.
fn summary(report: &CheckReport) -> String {
    match report.worst() {
        None | Some(Severity::Info) => {
            "The log agrees with the experiment file: it is ready for an identification."
        }
        Some(Severity::Warning | Severity::Serious) => {
            "An identification is possible, but the findings reduce the trust in its results."
        }
        Some(Severity::Error) => {
            "The log contradicts the experiment file, so sprung identify refuses it."
        }
    }
    .to_owned()
}

fn badge(report: &CheckReport) -> Badge {
    match report.worst() {
        None | Some(Severity::Info) => Badge::new(Tone::Good, "nothing wrong was found"),
        Some(Severity::Warning) => Badge::new(Tone::Doubtful, "warnings"),
        Some(Severity::Serious) => Badge::new(Tone::Bad, "serious findings"),
        Some(Severity::Error) => Badge::new(Tone::Bad, "errors: identify refuses this log"),
    }
}

/// Returns the findings, each with a figure of the samples concerned.
fn findings(checked: &Checked) -> Vec<Block> {
    let all = &checked.report.findings;
    if all.is_empty() {
        return vec![Block::Paragraph("No findings.".to_owned())];
    }
    let mut blocks = Vec::new();
    for (k, finding) in all.iter().enumerate() {
        let mut shown = shown(finding);
        shown.title = format!("{}: {}", finding.severity.word(), shown.title);
        blocks.push(Block::Findings(vec![shown]));
        blocks.extend(finding.setting.iter().map(|line| Block::Code(line.clone())));
        let place = checked.places.iter().find(|place| place.finding == k);
        blocks.extend(place.map(|place| Block::Figure(of_place(finding, place))));
    }
    blocks
}

fn of_place(finding: &Finding, place: &FindingSamples) -> Figure {
    let values = place.values.iter().map(|value| Some(*value)).collect();
    let panel = Panel {
        y_label: format!("{} [{}]", place.column, place.unit),
        x: place.time.clone(),
        series: vec![Series::new(&place.column, Style::Measured, values)],
        ..Panel::default()
    };
    Figure::over_time(
        format!("place-{}", place.finding),
        format!("\"{}\" around the place of {}.", place.column, finding.code),
        Layout::Stack,
        [panel],
    )
}

fn joints(report: &CheckReport) -> Table {
    rows(&report.joints)
        .text("joint", |joint| &joint.joint)
        .number("torque explained [%]", |joint| {
            significant(joint.explained_percent, 4)
        })
        .number("motor over link", |joint| or_dash(joint.slope, 4))
        .number("stiffness, motor row alone [N·m/rad]", |joint| {
            or_dash(joint.stiffness, 4)
        })
        .table("")
}

fn columns(log: &CheckedLog) -> Table {
    rows(&log.columns)
        .text("column", ColumnFigures::label)
        .text("joint", |column| &column.joint)
        .text("quantity", |column| column.quantity.replace('_', " "))
        .text("unit", |column| &column.unit)
        .number("smallest", |column| significant(column.min, 4))
        .number("largest", |column| significant(column.max, 4))
        .number("deviation", |column| significant(column.deviation, 3))
        .number("noise", |column| or_dash(column.noise, 2))
        .number("step", |column| or_dash(column.step, 3))
        .number("effective bits", |column| or_dash(column.effective_bits, 3))
        .number("longest standstill [s]", |column| {
            significant(column.longest_still_s, 3)
        })
        .table("")
}

fn overview(report: &CheckReport, curves: &Curves) -> Figure {
    let unit = |column: &str| {
        (report.logs.first())
            .and_then(|log| log.columns.iter().find(|one| one.column == column))
            .map_or("", |one| one.unit.as_str())
    };
    let panels = curves.columns.iter().enumerate().map(|(i, column)| {
        let series = (curves.sets.iter())
            .zip([Style::Measured, Style::First])
            .map(|(set, style)| Series::new(&set.label, style, set.values[i].clone()));
        Panel {
            y_label: format!("{column} [{}]", unit(column)),
            x: curves
                .sets
                .first()
                .map_or_else(Vec::new, |set| set.time.clone()),
            series: series.collect(),
            ..Panel::default()
        }
    });
    Figure::over_time(
        "overview",
        "All columns; drag to zoom.",
        Layout::Grid,
        panels,
    )
}
