//! Composes the section about springs by the vibrations that motors see.

use super::document::{Block, Fold, Row, Section, Table, Tone};
use super::numbers::{or_dash, significant};
use super::section::folded;
use super::tables::{number, text};
use crate::estimate::Identification;

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
    let rows = springs.iter().map(|own| Row {
        cells: vec![
            own.joint.clone(),
            with_error(own.stiffness, own.stiffness_standard_error),
            with_error(own.rotor_inertia, own.rotor_inertia_standard_error),
            with_error(own.link_inertia, own.link_inertia_standard_error),
            or_dash(own.antiresonance_hz, 4),
            or_dash(own.resonance_hz, 4),
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
