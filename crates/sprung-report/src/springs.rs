//! Composes the sections about springs by the vibrations of motors, and about joints that are taken as rigid.

use super::document::{Block, Fold, Row, Section, Table, Tone};
use super::numbers::{or_dash, significant};
use super::section::folded;
use super::tables::{number, text};
use crate::estimate::Identification;
use crate::estimate::RigidJoint;

/// Returns the section; `None` without such springs.
pub(super) fn springs(identification: &Identification) -> Option<Section> {
    let springs = &identification.springs_from_motor;
    if springs.is_empty() {
        return None;
    }
    let with_error = |value: Option<f64>, error: Option<f64>| {
        value.zip(error).map_or_else(
            || "-".to_owned(),
            |(value, error)| format!("{} ± {}", significant(value, 4), significant(error, 2)),
        )
    };
    let rows = springs.iter().map(|spring| Row {
        cells: vec![
            spring.joint.clone(),
            with_error(spring.stiffness, spring.stiffness_standard_error),
            with_error(spring.rotor_inertia, spring.rotor_inertia_standard_error),
            with_error(spring.link_inertia, spring.link_inertia_standard_error),
            or_dash(spring.antiresonance_hz, 4),
            or_dash(spring.resonance_hz, 4),
        ],
        tone: Tone::Neutral,
    });
    Some(folded(
        Fold::Open,
        "springs",
        "Springs seen from the motors",
        "The stiffness of each joint by the vibrations of its motor, without a sensor at the link. The \
         identified model itself is rigid.",
        vec![Block::Table(Table {
            caption: "Values about the mean pose of the log, with standard errors. The link inertia is that \
                      of all links that the joint moves. The antiresonance is the vibration of the link while \
                      the motor is held, the resonance that of link against motor. A dash: the log does not \
                      show the vibration."
                .to_owned(),
            columns: vec![
                text("Joint"),
                number("Stiffness ± s.e. [N·m/rad, N/m]"),
                number("Rotor inertia ± s.e. [kg·m², kg]"),
                number("Link inertia ± s.e. [kg·m², kg]"),
                number("Antiresonance [Hz]"),
                number("Resonance [Hz]"),
            ],
            rows: rows.collect(),
            ..Table::default()
        })],
    ))
}

/// Returns the section about springs by deflections and joint torques; `None` without such springs.
pub(super) fn sensed(identification: &Identification) -> Option<Section> {
    let springs = &identification.sensed_springs;
    if springs.is_empty() {
        return None;
    }
    let rows = springs.iter().map(|spring| {
        let [from, to] = spring.ci95_nm_per_rad;
        let error = significant(spring.standard_error_nm_per_rad, 2);
        Row {
            cells: vec![
                spring.joint.clone(),
                format!("{} ± {error}", significant(spring.stiffness_nm_per_rad, 5)),
                format!("{} to {}", significant(from, 5), significant(to, 5)),
            ],
            tone: Tone::Neutral,
        }
    });
    Some(folded(
        Fold::Open,
        "sensed-springs",
        "Springs by deflections and joint torques",
        "The log has no motor torques, so the identified equations are those of the links. The springs follow from the \
         deflections and the joint torques alone.",
        vec![Block::Table(Table {
            caption: "Stiffnesses with standard errors and 95 % intervals.".to_owned(),
            columns: vec![
                text("Joint"),
                number("Stiffness ± s.e. [N·m/rad, N/m]"),
                number("95 % [N·m/rad, N/m]"),
            ],
            rows: rows.collect(),
            ..Table::default()
        })],
    ))
}

/// Returns the section about joints whose springs the logs do not determine; `None` without such joints.
pub(super) fn rigid(identification: &Identification) -> Option<Section> {
    let joints = &identification.rigid_joints;
    if joints.is_empty() {
        return None;
    }
    let percent = |share: Option<f64>| or_dash(share.map(|share| 100.0 * share), 3);
    let row = |joint: &RigidJoint| Row {
        cells: vec![
            joint.joint.clone(),
            joint.bound(),
            format!(
                "{} ± {}",
                significant(joint.compliance_rad_per_nm, 2),
                significant(joint.compliance_standard_error_rad_per_nm, 2)
            ),
            percent(joint.hold_out.and_then(|hold_out| hold_out.flexible)),
            percent(joint.hold_out.and_then(|hold_out| hold_out.rigid)),
        ],
        tone: Tone::Neutral,
    };
    Some(folded(
        Fold::Open,
        "stiff-joints",
        "Joints that are taken as rigid",
        "The logs do not determine the springs of these joints. Their deflections are smaller than the errors of the \
         positions.",
        vec![Block::Table(Table {
            caption: "Lower bounds of the stiffness (95 %) and compliances with standard errors. The last columns are the \
                      torque that is missed in parts of the beginning of the first log, each predicted by a fit of the \
                      other parts, with a spring and as a rigid joint. Dashes: a torque sensor separates link and motor, \
                      so no choice is needed."
                .to_owned(),
            columns: vec![
                text("Joint"),
                number("Stiffness [N·m/rad, N/m]"),
                number("Compliance ± s.e. [rad/(N·m), m/N]"),
                number("missed with spring [%]"),
                number("missed as rigid joint [%]"),
            ],
            rows: joints.iter().map(row).collect(),
            ..Table::default()
        })],
    ))
}
