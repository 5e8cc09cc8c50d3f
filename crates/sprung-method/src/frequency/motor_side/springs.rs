//! Springs, rotors and links by the spectra of torques and motor positions.

use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sprung_core::chain::JointKind;
use sprung_core::friction::Law;
use sprung_core::parameters::{JointParameter, Side as Ends};

use super::descent::covariance;
use super::equations::Places;
use super::lines::Lines;
use super::search::{half_differences, solve};
use crate::finding::{Finding, Severity};
use crate::frequency::record::Record;
use crate::model::Model;
use crate::numbers::Shown;

/// Largest relative standard errors of a spring that the log determines: of its stiffness, and of the
/// inertias at its ends.
const LARGEST_ERROR: f64 = 0.1;
const LARGEST_ERROR_OF_INERTIA: f64 = 0.2;

/// The spring of a joint by the vibrations of its motor.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SpringFromMotor {
    /// Name of the joint.
    pub joint: String,
    /// Stiffness, N·m/rad (N/m); absent if the log does not determine it, like all other values.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<f64>,
    /// Its standard error.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness_standard_error: Option<f64>,
    /// Inertia of the rotor after the gear, kg·m² (kg).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotor_inertia: Option<f64>,
    /// Its standard error.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotor_inertia_standard_error: Option<f64>,
    /// Inertia of the links that the joint moves, in the mean pose of the log, kg·m² (kg).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub link_inertia: Option<f64>,
    /// Its standard error.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub link_inertia_standard_error: Option<f64>,
    /// Frequency of the link on its spring while all motors and the other links are held, Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub antiresonance_hz: Option<f64>,
    /// Frequency of link against motor while the other links are held, Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resonance_hz: Option<f64>,
}

/// Returns the springs of a robot whose motors alone are measured, without values where the record does
/// not determine them, \[n\].
#[must_use]
pub(crate) fn springs_from_motor(record: &Record, model: &Model) -> Vec<SpringFromMotor> {
    determined(record, model).unwrap_or_else(|| {
        let open = |joint: &String| SpringFromMotor {
            joint: joint.clone(),
            ..SpringFromMotor::default()
        };
        model.joints().iter().map(open).collect()
    })
}

/// Returns the springs; `None` if the record is too short or contains too little motion.
fn determined(record: &Record, model: &Model) -> Option<Vec<SpringFromMotor>> {
    let (segment, sharpness) = (record.longest(), sharpness(model));
    let lines = Lines::of(segment, &sharpness)?;
    let (x, errors) = solve(&lines)?;
    let places = Places::new(&lines);
    let covariance = covariance(&errors);
    let highest = lines.hz.last().copied()?;
    let halves = segment
        .halves()
        .map(|half| Lines::below(&half, &sharpness, highest));
    let between = half_differences(halves, &x);
    let springs = (0..lines.joints()).map(|joint| {
        let error = |place: usize| -> f64 {
            let sampling_error = covariance
                .as_ref()
                .map(|covariance| covariance[(place, place)].sqrt());
            sampling_error.map_or(f64::INFINITY, |sampling_error| {
                sampling_error.hypot(between[place])
            })
        };
        let name = model.joints()[joint].clone();
        let inertia = Places::inertia(joint, joint);
        let share = error(places.stiffness(joint));
        let of_inertias = error(places.rotor(joint)).max(error(inertia) / x[inertia]);
        let is_determined = share <= LARGEST_ERROR && of_inertias <= LARGEST_ERROR_OF_INERTIA;
        if !is_determined {
            return SpringFromMotor {
                joint: name,
                ..SpringFromMotor::default()
            };
        }
        let (stiffness, rotor) = (
            x[places.stiffness(joint)].exp(),
            x[places.rotor(joint)].exp(),
        );
        SpringFromMotor {
            joint: name,
            stiffness: Some(stiffness),
            stiffness_standard_error: Some(stiffness * share),
            rotor_inertia: Some(rotor),
            rotor_inertia_standard_error: Some(rotor * error(places.rotor(joint))),
            link_inertia: Some(x[inertia]),
            link_inertia_standard_error: Some(error(inertia)),
            antiresonance_hz: Some((stiffness / x[inertia]).sqrt() / TAU),
            resonance_hz: Some((stiffness * (x[inertia].recip() + rotor.recip())).sqrt() / TAU),
        }
    });
    Some(springs.collect())
}

/// Returns findings about the springs.
///
/// - `springs`: as [`springs_from_motor`] returns them; `file`: name of the log.
#[must_use]
pub(crate) fn about_springs(
    springs: &[SpringFromMotor],
    model: &Model,
    file: &str,
) -> Vec<Finding> {
    let name = |joint: &str| format!("{joint}.stiffness");
    let (mut found, mut open) = (Vec::new(), Vec::new());
    let all = model.joints().iter().enumerate();
    for (joint, joint_name) in all {
        let spring = springs.iter().find(|spring| spring.joint == *joint_name);
        let unit = match model.kind(joint) {
            JointKind::Revolute => "N·m/rad",
            JointKind::Prismatic => "N/m",
        };
        match spring.and_then(|spring| Some((spring.stiffness?, spring))) {
            Some((stiffness, spring)) => found.push((
                name(joint_name),
                format!(
                    "{joint_name} {} ± {} {unit}",
                    rounded(stiffness, 4),
                    rounded(spring.stiffness_standard_error.unwrap_or_default(), 2)
                ),
            )),
            None => open.push((name(joint_name), joint_name.clone())),
        }
    }
    let finding = |severity, code, text: String, remedy: &str, of: Vec<String>| {
        Finding::new(severity, code, text, remedy).about(of)
    };
    let mut findings = Vec::new();
    let (names, texts): (Vec<String>, Vec<String>) = found.into_iter().unzip();
    if !names.is_empty() {
        findings.push(finding(
            Severity::Info,
            "springs-by-vibration",
            format!(
                "the vibrations that the motors see in {file} give stiffnesses (with standard errors): {}. They \
                 stand beside the identified model, which is rigid",
                texts.join(", ")
            ),
            "identify the rigid model from a log with slower motion, because its equations contain no \
             vibrations",
            names,
        ));
    }
    let (names, joints): (Vec<String>, Vec<String>) = open.into_iter().unzip();
    if !names.is_empty() {
        findings.push(finding(
            Severity::Warning,
            "resonance-not-excited",
            format!(
                "{file} hardly shows the vibrations of the springs of {}: the standard errors of stiffness or \
                 inertias would be above {} and {} %, so sprung gives no values",
                joints.join(", "),
                100.0 * LARGEST_ERROR,
                100.0 * LARGEST_ERROR_OF_INERTIA
            ),
            "record a multisine of small amplitude about one pose, with all frequencies up to twice the \
             resonance, for at least half a minute; or remove springs_from_motor",
            names,
        ));
    }
    findings
}

/// Returns a number with some digits.
fn rounded(value: f64, digits: usize) -> Shown {
    let text = format!("{value:.*e}", digits - 1);
    Shown(text.parse().unwrap_or(value))
}

/// Returns the sharpness of the dry friction of each joint; `None` for joints without.
fn sharpness(model: &Model) -> Vec<Option<f64>> {
    (0..model.joint_count())
        .map(|joint| {
            let has = |side| {
                let kind = JointParameter::Friction(side, Law::Coulomb);
                model.index(kind, joint).is_some()
            };
            (has(Ends::Motor) || has(Ends::Link)).then(|| model.shape(joint).sharpness)
        })
        .collect()
}
