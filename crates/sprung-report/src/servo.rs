//! Composes the report of a servo.

use super::document::{Badge, Block, Document, Fold, Table, Tone};
use super::numbers::{or_dash, significant};
use super::rows::rows;
use super::section::{findings, origin, section};
use super::verdict;
use crate::finding::Severity;
use sprung_servo::{Scale, ServoIdentification};

/// Composes the report of a servo.
///
/// - `command`: the command that made the report.
/// - `experiment`: text of the experiment file.
#[must_use]
pub fn compose_servo(found: &ServoIdentification, command: &str, experiment: &str) -> Document {
    let worst = (found.findings.iter()).max_by_key(|finding| finding.severity);
    let deciding = worst.filter(|finding| finding.severity > Severity::Info);
    let badge = match deciding.map(|finding| finding.severity) {
        None => Badge::new(Tone::Good, "good"),
        Some(Severity::Warning | Severity::Info) => Badge::new(Tone::Doubtful, "doubtful"),
        Some(Severity::Serious | Severity::Error) => Badge::new(Tone::Bad, "unusable"),
    };
    let mut sections = vec![section(
        "parameters",
        "Parameters",
        "Values with standard errors and 95 % intervals.",
        vec![Block::Table(parameters(found))],
    )];
    let all = findings(&found.findings);
    sections.extend(all.map(|all| section("findings", "Findings", "", vec![all])));
    sections.push(section(
        "logs",
        "Logs",
        "The logs with their known loads.",
        vec![Block::Table(logs(found)), Block::KeyValues(fit(found))],
    ));
    sections.push(origin(Fold::Screen, command, Some(experiment)));
    Document {
        title: found.robot.clone(),
        subtitle: format!(
            "Servo {}, identified from targets and positions",
            found.joint
        ),
        generator: found.generator.clone(),
        verdict: Some(badge),
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
    rows(found.parameters.iter().chain([&found.braking]))
        .text("Parameter", |parameter| &parameter.name)
        .text("Unit", |parameter| &parameter.unit)
        .number("value", |parameter| significant(parameter.value, 5))
        .number("± s.e.", |parameter| {
            if parameter.fixed {
                "given".to_owned()
            } else {
                or_dash(parameter.standard_error, 2)
            }
        })
        .number("95 % from", |parameter| {
            or_dash(parameter.ci95.map(|[low, _]| low), 4)
        })
        .number("to", |parameter| {
            or_dash(parameter.ci95.map(|[_, high]| high), 4)
        })
        .table("`braking` is viscous friction and back-EMF together.")
}

fn logs(found: &ServoIdentification) -> Table {
    rows(&found.logs)
        .text("Log", |log| &log.log)
        .number("samples", |log| log.samples)
        .number("duration, s", |log| significant(log.duration_s, 4))
        .number("load inertia, kg·m²", |log| {
            significant(log.load_inertia_kgm2, 4)
        })
        .number("load torque, N·m", |log| {
            significant(log.load_torque_nm, 4)
        })
        .table("")
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
