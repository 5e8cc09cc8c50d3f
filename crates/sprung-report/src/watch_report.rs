//! Composes the report of a watch.

use super::document::{
    Badge, Block, Document, Figure, Fold, Layout, Panel, Row, Series, Style, Table, Tone,
};
use super::numbers::{or_dash, significant};
use super::section::{folded, section};
use super::tables::{number, text};
use crate::curves::Curves;
use crate::watch::{Watch, WatchEvent};

/// Composes the report of a watch.
///
/// - `curves`: torques from outside, then their thresholds; `command`: the command that made the report.
#[must_use]
pub fn compose_watch(watch: &Watch, curves: &Curves, command: &str) -> Document {
    let mut sections = Vec::new();
    if !watch.events.is_empty() {
        sections.push(section(
            "events",
            "Events",
            "What happened, log by log.",
            vec![Block::Table(events(watch))],
        ));
    }
    sections.push(section(
        "torques",
        "Torques from outside",
        "The torque that something outside of the robot would have to apply to each joint, and its threshold, which moves with \
         speed, load, acceleration and reversals. Logs follow one another.",
        vec![
            Block::Table(joints(watch)),
            Block::Figure(figure(watch, curves)),
        ],
    ));
    sections.push(folded(
        Fold::Screen,
        "settings",
        "Settings",
        "The command that made this report.",
        vec![Block::Code(command.to_owned())],
    ));
    let first = watch.events.first();
    Document {
        title: watch.robot.clone(),
        subtitle: format!("Watched with the values of {}", watch.parameters),
        generator: watch.generator.clone(),
        verdict: Some(Badge {
            tone: if first.is_some() {
                Tone::Doubtful
            } else {
                Tone::Good
            },
            text: if first.is_some() {
                "something happened"
            } else {
                "as identified"
            }
            .to_owned(),
        }),
        summary: watch.sentence(),
        reason: first.map_or_else(String::new, |event| event.finding.text.clone()),
        what_to_do: first.map_or_else(String::new, |event| event.finding.remedy.clone()),
        sections,
        ..Document::default()
    }
}

fn events(watch: &Watch) -> Table {
    let row = |event: &WatchEvent| Row {
        cells: vec![
            event.log.clone(),
            format!("{:.2}", event.begins_s),
            format!("{:.2}", event.ends_s),
            event.joint.clone().unwrap_or_default(),
            event.finding.code.clone(),
            or_dash(event.torque_nm, 3),
            event.finding.text.clone(),
        ],
        tone: Tone::Doubtful,
    };
    Table {
        caption: "Events.".to_owned(),
        columns: vec![
            text("Log"),
            number("From [s]"),
            number("To [s]"),
            text("Joint"),
            text("Code"),
            number("Torque [N·m (N)]"),
            text("What happened"),
        ],
        rows: watch.events.iter().map(row).collect(),
        ..Table::default()
    }
}

fn joints(watch: &Watch) -> Table {
    let rows = watch.joints.iter().map(|joint| Row {
        cells: vec![
            joint.joint.clone(),
            or_dash(joint.typical_threshold_nm, 3),
            or_dash(joint.threshold_sigma, 3),
            significant(joint.motor_share, 2),
        ],
        tone: Tone::Neutral,
    });
    Table {
        caption: format!(
            "Thresholds of {} false alarms per hour, learned from {:.0} s of {}.",
            watch.false_alarms_per_h,
            watch.learned_s,
            watch.learned_from.join(", ")
        ),
        columns: vec![
            text("Joint"),
            number("Typical threshold [N·m (N)]"),
            number("in standard deviations"),
            number("Share of the motor's equation"),
        ],
        rows: rows.collect(),
        ..Table::default()
    }
}

fn figure(watch: &Watch, curves: &Curves) -> Figure {
    let column = |set: usize, joint: usize, sign: f64| -> Vec<Option<f64>> {
        let values = curves.sets.get(set).and_then(|set| set.values.get(joint));
        let signed = values.into_iter().flatten().map(|value| {
            value
                .map(|value| sign * value)
                .filter(|value| value.is_finite())
        });
        signed.collect()
    };
    let series = |name: &str, values: Vec<Option<f64>>, style: Style| Series {
        name: name.to_owned(),
        values,
        style,
        clipped: false,
    };
    let panels = (watch.joints.iter().enumerate()).map(|(joint, of)| Panel {
        y_label: format!("{} [N·m (N)]", of.joint),
        x: curves
            .sets
            .first()
            .map(|set| set.time.clone())
            .unwrap_or_default(),
        series: vec![
            series("torque from outside", column(0, joint, 1.0), Style::First),
            series("threshold", column(1, joint, 1.0), Style::Reference),
            series("− threshold", column(1, joint, -1.0), Style::Reference),
        ],
        ..Panel::default()
    });
    Figure {
        id: "outside".to_owned(),
        caption: "Torques from outside between their thresholds.".to_owned(),
        x_label: "time [s]".to_owned(),
        logarithmic: false,
        layout: Layout::Stack,
        panels: panels.collect(),
    }
}
