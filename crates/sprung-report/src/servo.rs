//! Composes the report of a servo.

use super::document::{Badge, Block, Document, Fold, Row, Table, Tone};
use super::numbers::{or_dash, significant};
use super::section::{folded, section, shown};
use super::tables::{number, text};
use super::verdict;
use crate::finding::Severity;
use sprung_servo::{Scale, ServoEstimate, ServoIdentification};

/// Composes the report of a servo.
///
/// - `command`: the command that made the report.
/// - `experiment`: text of the experiment file.
#[must_use]
pub fn compose_servo(found: &ServoIdentification, command: &str, experiment: &str) -> Document {
    let worst = (found.findings.iter()).max_by_key(|finding| finding.severity);
    let deciding = worst.filter(|finding| finding.severity > Severity::Info);
    let (tone, word) = match deciding.map(|finding| finding.severity) {
        None => (Tone::Good, "good"),
        Some(Severity::Warning | Severity::Info) => (Tone::Doubtful, "doubtful"),
        Some(Severity::Serious | Severity::Error) => (Tone::Bad, "unusable"),
    };
    let mut sections = vec![section(
        "parameters",
        "Parameters",
        "Values with standard errors and 95 % intervals.",
        vec![Block::Table(parameters(found))],
    )];
    if !found.findings.is_empty() {
        let findings = found.findings.iter().map(shown).collect();
        sections.push(section(
            "findings",
            "Findings",
            "",
            vec![Block::Findings(findings)],
        ));
    }
    sections.push(section(
        "logs",
        "Logs",
        "The logs with their known loads.",
        vec![Block::Table(logs(found)), Block::KeyValues(fit(found))],
    ));
    sections.push(folded(
        Fold::Screen,
        "settings",
        "Settings",
        "The command that made this report, and the experiment file.",
        vec![
            Block::Code(command.to_owned()),
            Block::Code(experiment.to_owned()),
        ],
    ));
    Document {
        title: found.robot.clone(),
        subtitle: format!(
            "Servo {}, identified from targets and positions",
            found.joint
        ),
        generator: found.generator.clone(),
        verdict: Some(Badge {
            tone,
            text: word.to_owned(),
        }),
        summary: scale(found.scale).to_owned(),
        reason: deciding.map_or_else(String::new, |finding| {
            verdict::first_sentence(&finding.text)
        }),
        what_to_do: deciding
            .map_or_else(String::new, |finding| verdict::as_sentence(&finding.remedy)),
        sections,
        ..Document::default()
    }
}

/// Returns a sentence on the scale of all torques.
fn scale(scale: Scale) -> &'static str {
    match scale {
        Scale::KnownLoad => "The known loads give the scale of all torques.",
        Scale::Given => "The given torque per volt or ampere is the scale of all torques.",
        Scale::None => {
            "Nothing gives the scale of the torques, so only their ratios follow from the logs."
        }
    }
}

fn parameters(found: &ServoIdentification) -> Table {
    let row = |parameter: &ServoEstimate| Row {
        cells: vec![
            parameter.name.clone(),
            parameter.unit.clone(),
            significant(parameter.value, 5),
            if parameter.fixed {
                "given".to_owned()
            } else {
                or_dash(parameter.standard_error, 2)
            },
            or_dash(parameter.ci95.map(|[low, _]| low), 4),
            or_dash(parameter.ci95.map(|[_, high]| high), 4),
        ],
        tone: Tone::Neutral,
    };
    Table {
        caption: "`braking` is viscous friction and back-EMF together.".to_owned(),
        columns: vec![
            text("Parameter"),
            text("Unit"),
            number("value"),
            number("± s.e."),
            number("95 % from"),
            number("to"),
        ],
        rows: (found.parameters.iter().chain([&found.braking]))
            .map(row)
            .collect(),
        ..Table::default()
    }
}

fn logs(found: &ServoIdentification) -> Table {
    let rows = found.logs.iter().map(|log| Row {
        cells: vec![
            log.log.clone(),
            log.samples.to_string(),
            significant(log.duration_s, 4),
            significant(log.load_inertia_kgm2, 4),
            significant(log.load_torque_nm, 4),
        ],
        tone: Tone::Neutral,
    });
    Table {
        columns: vec![
            text("Log"),
            number("samples"),
            number("duration, s"),
            number("load inertia, kg·m²"),
            number("load torque, N·m"),
        ],
        rows: rows.collect(),
        ..Table::default()
    }
}

fn fit(found: &ServoIdentification) -> Vec<(String, String)> {
    let fit = &found.fit;
    vec![
        (
            "Simulated minus logged position, root mean square".to_owned(),
            format!("{} mrad", significant(1e3 * fit.position_rms_rad, 3)),
        ),
        (
            "The same over the noise of the sensor".to_owned(),
            significant(fit.position_rms_over_noise, 3),
        ),
        (
            "Windows that the simulation does not follow".to_owned(),
            format!("{} %", significant(100.0 * fit.windows_not_followed, 2)),
        ),
        (
            "Computing time".to_owned(),
            format!("{} s", significant(found.elapsed_s, 2)),
        ),
    ]
}
