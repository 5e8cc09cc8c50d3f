//! Composes the report of a watch.

use super::document::{
    Badge, Block, Document, Figure, Fold, Layout, Panel, Series, Style, Table, Tone,
};
use super::numbers::{or_dash, significant};
use super::rows::rows;
use super::section::{origin, section};
use crate::curves::Curves;
use crate::watch::Watch;

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
    sections.push(origin(Fold::Screen, command, None));
    let first = watch.events.first();
    Document {
        title: watch.robot.clone(),
        subtitle: format!("Watched with the values of {}", watch.parameters),
        generator: watch.generator.clone(),
        verdict: Some(match first {
            Some(_) => Badge::new(Tone::Doubtful, "something happened"),
            None => Badge::new(Tone::Good, "as identified"),
        }),
        summary: watch.sentence(),
        reason: first.map_or_else(String::new, |event| event.finding.text.clone()),
        what_to_do: first.map_or_else(String::new, |event| event.finding.remedy.clone()),
        sections,
        ..Document::default()
    }
}

fn events(watch: &Watch) -> Table {
    rows(&watch.events)
        .text("Log", |event| &event.log)
        .number("From [s]", |event| format!("{:.2}", event.begins_s))
        .number("To [s]", |event| format!("{:.2}", event.ends_s))
        .text("Joint", |event| event.joint.as_deref().unwrap_or_default())
        .text("Code", |event| &event.finding.code)
        .number("Torque [N·m (N)]", |event| or_dash(event.torque_nm, 3))
        .text("What happened", |event| &event.finding.text)
        .marked(|_| true)
        .table("Events.")
}

fn joints(watch: &Watch) -> Table {
    rows(&watch.joints)
        .text("Joint", |joint| &joint.joint)
        .number("Typical threshold [N·m (N)]", |joint| {
            or_dash(joint.typical_threshold_nm, 3)
        })
        .number("in standard deviations", |joint| {
            or_dash(joint.threshold_sigma, 3)
        })
        .number("Share of the motor's equation", |joint| {
            significant(joint.motor_share, 2)
        })
        .table(format!(
            "Thresholds of {} false alarms per hour, learned from {:.0} s of {}.",
            watch.false_alarms_per_h,
            watch.learned_s,
            watch.learned_from.join(", ")
        ))
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
    let panels = (watch.joints.iter().enumerate()).map(|(joint, of)| Panel {
        y_label: format!("{} [N·m (N)]", of.joint),
        x: curves
            .sets
            .first()
            .map(|set| set.time.clone())
            .unwrap_or_default(),
        series: vec![
            Series::new("torque from outside", Style::First, column(0, joint, 1.0)),
            Series::new("threshold", Style::Reference, column(1, joint, 1.0)),
            Series::new("− threshold", Style::Reference, column(1, joint, -1.0)),
        ],
        ..Panel::default()
    });
    let caption = "Torques from outside between their thresholds.";
    Figure::over_time("outside", caption, Layout::Stack, panels)
}
