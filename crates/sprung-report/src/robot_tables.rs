//! Composes further tables of a robot: encoder offsets, the choice of the cut-off, and the standard
//! parameters of lumped link parameters.

use super::document::Table;
use super::numbers::{given, or_dash, significant, with_error};
use super::rows::rows;
use crate::estimate::{CutoffChoice, Decided, EstimateResult, Identification};
use crate::model::short;

/// Relative change over the cut-offs above which a row is marked.
const MARKED_CHANGE: f64 = 0.05;

/// Minimum share of a row's torque for a parameter in the table of cut-offs.
const MIN_LISTED_SHARE: f64 = 0.05;

/// Returns a table of the constant differences between link and motor encoders.
pub(super) fn encoder_offsets(identification: &Identification) -> Option<Table> {
    rows(&identification.results.first()?.encoder_offsets)
        .text("Joint", |offset| &offset.joint)
        .number("Offset [mrad]", |offset| {
            significant(1e3 * offset.offset_rad, 3)
        })
        .number("± s.e.", |offset| {
            or_dash(offset.standard_error_rad.map(|error| 1e3 * error), 2)
        })
        .number("[°]", |offset| {
            format!("{:.4}", offset.offset_rad.to_degrees())
        })
        .table_if_any(
            "Offset of each link encoder relative to the motor encoder: minus the preload \
             divided by the stiffness.",
        )
}

/// Returns a table of the changes of the estimates over the cut-offs, in percent of the estimate at
/// the chosen cut-off.
pub(super) fn cutoffs(identification: &Identification, choice: &CutoffChoice) -> Option<Table> {
    let result = identification.results.first()?;
    let chosen = identification.settings.position_cutoff_hz;
    let near = |hz: f64| (hz - chosen).abs();
    let middle =
        (choice.sweep.iter()).min_by(|a, b| near(a.cutoff_hz).total_cmp(&near(b.cutoff_hz)))?;
    let matters = |share: Option<f64>| share.is_some_and(|share| share >= MIN_LISTED_SHARE);
    let listed = (result.parameters.iter().enumerate()).filter(|(i, p)| {
        matters(p.torque_share) && middle.values.get(*i).is_some_and(|v| *v != 0.0)
    });
    let change = |values: &[f64], i: usize| values[i] / middle.values[i] - 1.0;
    let mut table = rows(listed)
        .text("Parameter", |(_, parameter)| &parameter.name)
        .marked(|(i, _)| {
            (choice.sweep.iter()).any(|point| change(&point.values, i).abs() > MARKED_CHANGE)
        });
    for point in &choice.sweep {
        let heading = format!("{} Hz", significant(point.cutoff_hz, 3));
        table = table.number(heading, |(i, _)| {
            format!("{:+.1} %", 100.0 * change(&point.values, i))
        });
    }
    Some(table.table(format!(
        "Estimates from the beginning of the log, as changes from those at the chosen cut-off, \
             for parameters with at least {:.0} % of the largest torque of their row. Marked \
             parameters change by more than {:.0} %.",
        100.0 * MIN_LISTED_SHARE,
        100.0 * MARKED_CHANGE
    )))
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
    rows(&result.standard_parameters)
        .text("Parameter", |p| &p.name)
        .number("Value ± s.e.", |p| match p.standard_error {
            Some(error) => with_error(p.value, 5, error),
            None => significant(p.value, 5),
        })
        .number("Nominal", |p| given(p.nominal))
        .text("Unit", |p| &p.unit)
        .text("Decided by", |p| match p.decided {
            Decided::Log => "log",
            Decided::Both => "log and nominal value",
            Decided::Nominal => "nominal value",
            Decided::Nothing => "nothing",
            Decided::Given => "given",
        })
        .marked(|p| p.decided == Decided::Nothing)
        .table_if_any(
            "Parameters of single links and rotors, of bodies that can exist, near the estimate. \
             The log decides combinations; nominal values decide the rest. Nothing decides the \
             marked parameters: they have no nominal value, and other values give the same motion.",
        )
}
