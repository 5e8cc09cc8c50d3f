//! Composes further tables of a robot: encoder offsets, the choice of the cut-off, and the standard
//! parameters of lumped link parameters.

use super::document::{Row, Table, Tone};
use super::numbers::{given, or_dash, significant};
use super::tables::{number, text};
use crate::estimate::{CutoffChoice, Decided, EstimateResult, Identification};
use crate::model::short;

/// Relative change over the cut-offs above which a row is marked.
const MARKED_CHANGE: f64 = 0.05;

/// Minimum share of a row's torque for a parameter in the table of cut-offs.
const MIN_LISTED_SHARE: f64 = 0.05;

/// Returns a table of the constant differences between link and motor encoders.
pub(super) fn encoder_offsets(identification: &Identification) -> Option<Table> {
    let result = identification.results.first()?;
    let rows: Vec<Row> = (result.encoder_offsets.iter())
        .map(|offset| Row {
            cells: vec![
                offset.joint.clone(),
                significant(1e3 * offset.offset_rad, 3),
                or_dash(offset.standard_error_rad.map(|error| 1e3 * error), 2),
                format!("{:.4}", offset.offset_rad.to_degrees()),
            ],
            tone: Tone::Neutral,
        })
        .collect();
    (!rows.is_empty()).then(|| Table {
        caption: "Offset of each link encoder relative to the motor encoder: minus the preload \
                  divided by the stiffness."
            .to_owned(),
        columns: vec![
            text("Joint"),
            number("Offset [mrad]"),
            number("± s.e."),
            number("[°]"),
        ],
        rows,
        ..Table::default()
    })
}

/// Returns a table of the changes of the estimates over the cut-offs, in percent of the estimate at
/// the chosen cut-off.
pub(super) fn cutoffs(identification: &Identification, choice: &CutoffChoice) -> Option<Table> {
    let result = identification.results.first()?;
    let chosen = identification.settings.position_cutoff_hz;
    let near = |hz: f64| (hz - chosen).abs();
    let middle =
        (choice.sweep.iter()).min_by(|a, b| near(a.cutoff_hz).total_cmp(&near(b.cutoff_hz)))?;
    let mut columns = vec![text("Parameter")];
    columns.extend(
        (choice.sweep.iter())
            .map(|point| number(format!("{} Hz", significant(point.cutoff_hz, 3)))),
    );
    let matters = |share: Option<f64>| share.is_some_and(|share| share >= MIN_LISTED_SHARE);
    let rows = (result.parameters.iter().enumerate())
        .filter(|(i, p)| {
            matters(p.torque_share) && middle.values.get(*i).is_some_and(|v| *v != 0.0)
        })
        .map(|(i, parameter)| {
            let changes: Vec<f64> = (choice.sweep.iter())
                .map(|point| point.values[i] / middle.values[i] - 1.0)
                .collect();
            let mut cells = vec![parameter.name.clone()];
            cells.extend(
                changes
                    .iter()
                    .map(|change| format!("{:+.1} %", 100.0 * change)),
            );
            Row {
                cells,
                tone: if changes.iter().any(|change| change.abs() > MARKED_CHANGE) {
                    Tone::Doubtful
                } else {
                    Tone::Neutral
                },
            }
        })
        .collect();
    Some(Table {
        caption: format!(
            "Estimates from the beginning of the log, as changes from those at the chosen cut-off, \
             for parameters with at least {:.0} % of the largest torque of their row. Marked \
             parameters change by more than {:.0} %.",
            100.0 * MIN_LISTED_SHARE,
            100.0 * MARKED_CHANGE
        ),
        columns,
        rows,
        ..Table::default()
    })
}

/// Returns the lumped link parameters: short names and definitions.
pub(super) fn lumped(result: &EstimateResult) -> Vec<(String, String)> {
    (result.parameters.iter())
        .filter(|p| *short(&p.name) != p.name)
        .map(|p| {
            (
                format!("{} {}", p.symbol.replace("theta", "θ"), short(&p.name)),
                p.name.clone(),
            )
        })
        .collect()
}

/// Returns a table of the standard inertial parameters of the links.
pub(super) fn standard(result: &EstimateResult) -> Option<Table> {
    let rows: Vec<Row> = (result.standard_parameters.iter())
        .map(|p| Row {
            cells: vec![
                p.name.clone(),
                match p.standard_error {
                    Some(error) => {
                        format!("{} ± {}", significant(p.value, 5), significant(error, 2))
                    }
                    None => significant(p.value, 5),
                },
                given(p.nominal),
                p.unit.clone(),
                match p.decided {
                    Decided::Log => "log",
                    Decided::Both => "log and nominal value",
                    Decided::Nominal => "nominal value",
                    Decided::Nothing => "nothing",
                    Decided::Given => "given",
                }
                .to_owned(),
            ],
            tone: match p.decided {
                Decided::Nothing => Tone::Doubtful,
                Decided::Log | Decided::Both | Decided::Nominal | Decided::Given => Tone::Neutral,
            },
        })
        .collect();
    (!rows.is_empty()).then(|| Table {
        caption: "Parameters of single links and rotors, of bodies that can exist, near the estimate. \
                  The log decides combinations; nominal values decide the rest. Nothing decides the \
                  marked parameters: they have no nominal value, and other values give the same motion."
            .to_owned(),
        columns: vec![
            text("Parameter"),
            number("Value ± s.e."),
            number("Nominal"),
            text("Unit"),
            text("Decided by"),
        ],
        rows,
        ..Table::default()
    })
}
