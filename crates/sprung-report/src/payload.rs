//! Composes the section about payloads.

use super::document::{Block, Fold, Section, Table};
use super::numbers::{or_dash, with_error};
use super::rows::rows;
use super::section::folded;
use crate::estimate::{Identification, PayloadResult};

/// Returns the section; `None` without payloads.
pub(super) fn payloads(identification: &Identification) -> Option<Section> {
    let blocks: Vec<Block> = (identification.payloads.iter())
        .flat_map(|payload| {
            [
                Block::Paragraph(payload.summary()),
                Block::Table(table(payload)),
            ]
        })
        .collect();
    if blocks.is_empty() {
        return None;
    }
    Some(folded(
        Fold::Open,
        "payload",
        "Payload",
        "The body that the robot carried in some logs, from these logs and the robot's own parameters \
         with their errors.",
        blocks,
    ))
}

fn table(payload: &PayloadResult) -> Table {
    rows(&payload.parameters)
        .text("Parameter", |parameter| &parameter.name)
        .number("Value ± s.e.", |parameter| {
            let known = parameter.value.zip(parameter.standard_error);
            known.map_or_else(
                || "-".to_owned(),
                |(value, error)| with_error(value, 5, error),
            )
        })
        .text("Unit", |parameter| &parameter.unit)
        .number("Possible", |parameter| or_dash(parameter.physical, 5))
        .table(
            "Inertial parameters about the origin of the joint's frame, in its axes. The possible \
             values are those of the nearest body that can exist.",
        )
}
