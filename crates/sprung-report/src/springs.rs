//! Composes the sections about springs by the vibrations of motors, and about joints that are taken as rigid.

use super::document::{Block, Fold, Section};
use super::numbers::{or_dash, significant, with_error};
use super::rows::rows;
use super::section::folded;
use crate::estimate::{Identification, RigidJoint};

/// Returns the section; `None` without such springs.
pub(super) fn springs(identification: &Identification) -> Option<Section> {
    let error = |value: Option<f64>, error: Option<f64>| {
        let known = value.zip(error);
        known.map_or_else(
            || "-".to_owned(),
            |(value, error)| with_error(value, 4, error),
        )
    };
    let table = rows(&identification.springs_from_motor)
        .text("Joint", |spring| &spring.joint)
        .number("Stiffness ± s.e. [N·m/rad, N/m]", |spring| {
            error(spring.stiffness, spring.stiffness_standard_error)
        })
        .number("Rotor inertia ± s.e. [kg·m², kg]", |spring| {
            error(spring.rotor_inertia, spring.rotor_inertia_standard_error)
        })
        .number("Link inertia ± s.e. [kg·m², kg]", |spring| {
            error(spring.link_inertia, spring.link_inertia_standard_error)
        })
        .number("Antiresonance [Hz]", |spring| {
            or_dash(spring.antiresonance_hz, 4)
        })
        .number("Resonance [Hz]", |spring| or_dash(spring.resonance_hz, 4))
        .table_if_any(
            "Values about the mean pose of the log, with standard errors. The link inertia is that \
             of all links that the joint moves. The antiresonance is the vibration of the link while \
             the motor is held, the resonance that of link against motor. A dash: the log does not \
             show the vibration.",
        )?;
    Some(folded(
        Fold::Open,
        "springs",
        "Springs seen from the motors",
        "The stiffness of each joint by the vibrations of its motor, without a sensor at the link. The \
         identified model itself is rigid.",
        vec![Block::Table(table)],
    ))
}

/// Returns the section about springs by deflections and joint torques; `None` without such springs.
pub(super) fn sensed(identification: &Identification) -> Option<Section> {
    let table = rows(&identification.sensed_springs)
        .text("Joint", |spring| &spring.joint)
        .number("Stiffness ± s.e. [N·m/rad, N/m]", |spring| {
            let error = spring.standard_error_nm_per_rad;
            with_error(spring.stiffness_nm_per_rad, 5, error)
        })
        .number("95 % [N·m/rad, N/m]", |spring| {
            let [from, to] = spring.ci95_nm_per_rad.map(|end| significant(end, 5));
            format!("{from} to {to}")
        })
        .table_if_any("Stiffnesses with standard errors and 95 % intervals.")?;
    Some(folded(
        Fold::Open,
        "sensed-springs",
        "Springs by deflections and joint torques",
        "The log has no motor torques, so the identified equations are those of the links. The springs follow from the \
         deflections and the joint torques alone.",
        vec![Block::Table(table)],
    ))
}

/// Returns the section about joints whose springs the logs do not determine; `None` without such joints.
pub(super) fn rigid(identification: &Identification) -> Option<Section> {
    let missed = |share: Option<f64>| or_dash(share.map(|share| 100.0 * share), 3);
    let table = rows(&identification.rigid_joints)
        .text("Joint", |joint| &joint.joint)
        .number("Stiffness [N·m/rad, N/m]", RigidJoint::bound)
        .number("Compliance ± s.e. [rad/(N·m), m/N]", |joint| {
            let error = joint.compliance_standard_error_rad_per_nm;
            with_error(joint.compliance_rad_per_nm, 2, error)
        })
        .number("missed with spring [%]", |joint| {
            missed(joint.hold_out.and_then(|hold_out| hold_out.flexible))
        })
        .number("missed as rigid joint [%]", |joint| {
            missed(joint.hold_out.and_then(|hold_out| hold_out.rigid))
        })
        .table_if_any(
            "Lower bounds of the stiffness (95 %) and compliances with standard errors. The last columns are the \
             torque that is missed in parts of the beginning of the first log, each predicted by a fit of the \
             other parts, with a spring and as a rigid joint. Dashes: a torque sensor separates link and motor, \
             so no choice is needed.",
        )?;
    Some(folded(
        Fold::Open,
        "stiff-joints",
        "Joints that are taken as rigid",
        "The logs do not determine the springs of these joints. Their deflections are smaller than the errors of the \
         positions.",
        vec![Block::Table(table)],
    ))
}
