//! Findings about a payload.

use crate::estimate::statistics::{CERTAIN_SIGMAS, UNKNOWN_RELATIVE_ERROR};
use sprung_core::friction::Law;
use sprung_core::parameters::{JointParameter, Side};

use crate::estimate::result::PayloadResult;
use crate::finding::{Finding, Severity};
use crate::model::Model;
use crate::regression::System;

/// Ratio of the velocities of a joint below which it moves in some logs only.
const STANDS: f64 = 0.02;

/// Returns the findings about the parameters of a payload.
///
/// - `distance`: of the nearest possible body, standard errors.
pub(super) fn about_payload(result: &PayloadResult, distance: Option<f64>) -> Vec<Finding> {
    let mut findings = Vec::new();
    let name = &result.name;
    let mass = (result.parameters.first())
        .and_then(|parameter| parameter.value.zip(parameter.standard_error));
    let open: Vec<String> = (result.parameters.iter())
        .filter(|parameter| parameter.value.is_none())
        .map(|parameter| parameter.name.clone())
        .collect();
    if !open.is_empty() {
        findings.push(
            Finding::new(
                if mass.is_none() {
                    Severity::Warning
                } else {
                    Severity::Info
                },
                "payload-not-identifiable",
                format!("no motion in the logs determines {}", open.join(", ")),
                "move more joints that carry the payload, with and without it",
            )
            .about(open),
        );
    }
    let Some((mass, error)) = mass else {
        return findings;
    };
    if error > UNKNOWN_RELATIVE_ERROR * mass.abs() {
        findings.push(Finding::new(
            Severity::Warning,
            "payload-not-determined",
            format!(
                "the logs do not determine the payload {name}: its mass is {mass:.3} ± {error:.3} kg"
            ),
            "move the joints that carry the payload against gravity and with high accelerations, with \
             and without the payload",
        ));
    } else if distance.is_some_and(|distance| distance > CERTAIN_SIGMAS) {
        findings.push(Finding::new(
            Severity::Warning,
            "impossible-payload",
            format!(
                "no body has the estimated parameters of the payload {name}: the nearest possible body \
                 is {:.0} standard errors away",
                distance.unwrap_or_default()
            ),
            "compare the payload's link with the robot; look for effects that changed between the logs, \
             for example the temperature; record the same motion with and without the payload",
        ));
    }
    findings
}

/// Returns a finding that names joints which move only with the payload or only without it.
pub(super) fn about_joints(model: &Model, empty: &System, loaded: &System) -> Option<Finding> {
    let speeds = |system: &System| -> Vec<Option<f64>> {
        let factors = system.whole().unwrap_or_default();
        (0..model.joint_count())
            .map(|joint| {
                let viscous = [Side::Motor, Side::Link].into_iter().find_map(|side| {
                    model.index(JointParameter::Friction(side, Law::Viscous), joint)
                })?;
                let squares = factors.iter().enumerate().filter_map(|(row, factor)| {
                    let at = model
                        .row_columns(row)
                        .iter()
                        .position(|column| *column == viscous)?;
                    Some(factor.column_norm(at).powi(2) / system.weight(row).max(1.0))
                });
                Some(squares.sum::<f64>().sqrt())
            })
            .collect()
    };
    let (without, with) = (speeds(empty), speeds(loaded));
    let names = |a: &[Option<f64>], b: &[Option<f64>]| -> Vec<String> {
        (a.iter().zip(b).zip(model.joints()))
            .filter(|((a, b), _)| a.zip(**b).is_some_and(|(a, b)| a < STANDS * b))
            .map(|(_, name)| name.clone())
            .collect()
    };
    let (only_with, only_without) = (names(&without, &with), names(&with, &without));
    if only_with.is_empty() && only_without.is_empty() {
        return None;
    }
    let part = |names: &[String], when: &str| {
        let verb = if names.len() == 1 { "moves" } else { "move" };
        let names = (!names.is_empty()).then(|| names.join(", "))?;
        Some(format!("{names} {verb} only {when} the payload"))
    };
    let parts = [part(&only_with, "with"), part(&only_without, "without")];
    let text: Vec<String> = parts.into_iter().flatten().collect();
    Some(Finding::new(
        Severity::Warning,
        "payload-moves-other-joints",
        format!(
            "{}. The difference of the logs contains more than the payload",
            text.join("; ")
        ),
        "record the same motion with and without the payload",
    ))
}
