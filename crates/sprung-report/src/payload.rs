//! Composes the section about payloads.

use super::document::{Block, Fold, Row, Section, Table, Tone};
use super::numbers::{or_dash, significant};
use super::section::folded;
use super::tables::{number, text};
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
    Table {
        caption:
            "Inertial parameters about the origin of the joint's frame, in its axes. The possible \
                  values are those of the nearest body that can exist."
                .to_owned(),
        columns: vec![
            text("Parameter"),
            number("Value ± s.e."),
            text("Unit"),
            number("Possible"),
        ],
        rows: (payload.parameters.iter())
            .map(|parameter| Row {
                cells: vec![
                    parameter.name.clone(),
                    parameter.value.zip(parameter.standard_error).map_or_else(
                        || "-".to_owned(),
                        |(value, error)| {
                            format!("{} ± {}", significant(value, 5), significant(error, 2))
                        },
                    ),
                    parameter.unit.clone(),
                    or_dash(parameter.physical, 5),
                ],
                tone: Tone::Neutral,
            })
            .collect(),
        ..Table::default()
    }
}
