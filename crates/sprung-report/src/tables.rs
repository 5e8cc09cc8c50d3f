//! Composes the tables of an identification.

use std::collections::BTreeMap;

use super::document::Table;
use super::groups::Joints;
use super::intervals::half_width;
use super::numbers::{
    dash_if_none, deviation, given, or_dash, percent_or_dash, significant, with_error,
};
use super::rows::{Rows, rows};
use crate::estimate::{EstimateResult, Identification, ParameterEstimate};

/// Returns the value of an estimate with its standard error, or with its bound.
fn value(estimate: &ParameterEstimate) -> String {
    if let Some(most) = estimate.at_most() {
        return format!(
            "{} (< {})",
            or_dash(estimate.value, 5),
            significant(most, 2)
        );
    }
    match (estimate.value, estimate.standard_error) {
        _ if estimate.fixed => format!("{} given", or_dash(estimate.value, 5)),
        (Some(value), Some(error)) => with_error(value, 5, error),
        (None, Some(error)) => format!("– ± {}", significant(error, 2)),
        (value, None) => or_dash(value, 5),
    }
}

/// Distance between an estimate and its possible value, in standard errors, above which the table
/// shows both.
const SHOWN_MOVE: f64 = 0.5;

/// Returns whether the possible value of a parameter differs from the estimate.
fn has_moved(parameter: &ParameterEstimate) -> bool {
    let moved = parameter
        .physical
        .zip(parameter.value)
        .map(|(a, b)| (a - b).abs());
    let error = parameter.standard_error;
    moved
        .zip(error)
        .is_some_and(|(moved, error)| moved > SHOWN_MOVE * error)
}

/// Returns a table of the parameters of the first result, joint by joint, with true and nominal
/// values.
///
/// - `joint`: only its parameters; `None` for all.
pub(super) fn parameters(
    identification: &Identification,
    truth: Option<&BTreeMap<String, f64>>,
    joint: Option<&str>,
) -> Option<Table> {
    let result = identification.results.first()?;
    let joints = Joints::of(identification);
    let shown = result.shown_parameters();
    let of_joint = (shown.iter())
        .filter(|parameter| joint.is_none_or(|joint| joints.group(&parameter.name) == joint));
    let sorted = joints.sorted(of_joint, |parameter| &parameter.name);
    let is_warned = |name: &String| {
        let mut warnings = result.warnings.iter();
        warnings.any(|finding| finding.parameters.contains(name))
    };
    let mut table = rows(sorted.iter().copied())
        .text("Parameter", labelled)
        .number(format!("{} ± s.e.", result.estimator), |parameter| {
            let bound = identification.bound(&parameter.name);
            bound
                .filter(|_| parameter.value.is_none())
                .unwrap_or_else(|| value(parameter))
        })
        .text("Unit", |parameter| &parameter.unit)
        .number("± % (95 %)", |parameter| {
            or_dash(half_width(parameter).map(|half| 100.0 * half), 2)
        })
        .marked(|parameter| is_warned(&parameter.name));
    if let Some(truth) = truth {
        table = with_reference(table, ["True", "error %"], |parameter| {
            truth.get(&parameter.name).copied()
        });
    }
    if result.parameters.iter().any(|p| p.nominal.is_some()) {
        table = with_reference(table, ["Nominal", "from nominal %"], |parameter| {
            parameter.nominal
        });
    }
    let has_moved = result.parameters.iter().any(has_moved);
    if has_moved {
        table = table.number("Possible", |parameter| given(parameter.physical));
    }
    let possible = if has_moved {
        " The possible values are those of bodies and drives that can exist, nearest to the estimate."
    } else {
        ""
    };
    let headings = match joint {
        None => joints.headings(sorted.iter().map(|parameter| parameter.name.as_str())),
        Some(_) => Vec::new(),
    };
    Some(Table {
        headings,
        ..table.table(format!(
            "Parameters by {}. Notes or warnings concern the marked rows. A dash means that the log \
             does not determine the value, or that the value was not given.{possible}",
            result.estimator
        ))
    })
}

/// Adds columns of known values, and of the deviations from them.
fn with_reference<'a>(
    table: Rows<&'a ParameterEstimate>,
    [heading, of_deviation]: [&str; 2],
    known: impl Fn(&'a ParameterEstimate) -> Option<f64>,
) -> Rows<&'a ParameterEstimate> {
    table
        .number(heading, |parameter| given(known(parameter)))
        .number(of_deviation, |parameter| {
            deviation(parameter.value, known(parameter))
        })
}

/// Returns a table of the values of all estimators with their deviations from the true or nominal
/// values; `None` for a single estimator.
pub(super) fn estimators(
    identification: &Identification,
    truth: Option<&BTreeMap<String, f64>>,
) -> Option<Table> {
    let results = &identification.results;
    if results.len() < 2 {
        return None;
    }
    let shown: Vec<Vec<ParameterEstimate>> = results
        .iter()
        .map(EstimateResult::shown_parameters)
        .collect();
    let known = |parameter: &ParameterEstimate| match truth {
        Some(truth) => truth.get(&parameter.name).copied(),
        None => parameter.nominal,
    };
    let heading = if truth.is_some() {
        "error %"
    } else {
        "from nominal %"
    };
    let mut table = rows(shown.first()?)
        .text("Parameter", labelled)
        .text("Unit", |parameter| &parameter.unit);
    for (result, parameters) in results.iter().zip(&shown) {
        let of = |parameter: &ParameterEstimate| {
            parameters.iter().find(|one| one.name == parameter.name)
        };
        table = table
            .number(format!("{} ± s.e.", result.estimator), |parameter| {
                dash_if_none(of(parameter).map(value))
            })
            .number(heading, |parameter| {
                let value = of(parameter).and_then(|estimate| estimate.value);
                deviation(value, known(parameter))
            });
    }
    Some(table.table("Values of all estimators."))
}

fn labelled(parameter: &ParameterEstimate) -> String {
    symbol_and_name(&parameter.symbol, &parameter.label())
}

pub(super) fn symbol_and_name(symbol: &str, name: &str) -> String {
    format!("{}\u{a0}{name}", symbol.replace("theta", "θ"))
}

/// Returns the name of a row of the equations without its unit.
pub(super) fn row_name(row: &str) -> &str {
    row.trim_end_matches("_nm").trim_end_matches("_n")
}

/// Returns a table that compares each motor row alone with the estimate from all rows.
pub(super) fn motor_rows(identification: &Identification) -> Option<Table> {
    let result = identification
        .results
        .iter()
        .find(|r| !r.motor_rows.is_empty())?;
    let table = rows(result.motor_rows.iter().flat_map(|row| &row.parameters))
        .text("Parameter", |alone| &alone.name)
        .text("Unit", |alone| &alone.unit)
        .number(format!("{} ± s.e.", result.estimator), |alone| {
            result
                .parameter(&alone.name)
                .map_or_else(String::new, value)
        })
        .number("Motor row alone ± s.e.", value);
    Some(table.table(format!(
        "{} from all rows, compared with least squares on the motor row of each joint alone.",
        result.estimator
    )))
}

/// Returns a table that compares the cross-checks with the estimate that they check.
pub(super) fn cross_checks(identification: &Identification) -> Option<Table> {
    let result = identification
        .results
        .iter()
        .find(|r| !r.cross_checks.is_empty())?;
    let mut table = rows(&result.parameters)
        .text("Parameter", |parameter| &parameter.name)
        .text("Unit", |parameter| &parameter.unit)
        .number(format!("{} ± s.e.", result.estimator), value);
    for check in &result.cross_checks {
        table = table.number(&check.method, |parameter| {
            or_dash(check.values.get(&parameter.name), 5)
        });
    }
    Some(table.table(format!(
        "{}, and the cross-checks by other methods.",
        result.estimator
    )))
}

/// Returns the unit of the rows: N·m for revolute joints, N for prismatic joints, or both.
fn torque_unit(identification: &Identification) -> &'static str {
    let rows = || {
        let first = identification.results.first().into_iter();
        first.flat_map(|result| result.residual_rms.iter())
    };
    let sliding = rows().filter(|(name, _)| name.ends_with("_n")).count();
    match sliding {
        0 => "N·m",
        all if all == rows().count() => "N",
        _ => "N·m (N)",
    }
}

/// Returns a table of the residuals of every row.
pub(super) fn residuals(identification: &Identification) -> Table {
    let unit = torque_unit(identification);
    let first = identification.results.first().into_iter();
    let names = first.flat_map(|result| result.residual_rms.iter());
    let mut table = rows(names.map(|(row, _)| row)).text("Row", row_name);
    for result in &identification.results {
        table = table
            .number(format!("{} [{unit}]", result.estimator), |row| {
                or_dash(result.residual_rms.get(row), 3)
            })
            .number("% of torque", |row| {
                percent_or_dash(result.relative_residual.get(row))
            });
    }
    table.table("Residuals of the filtered regression.")
}

/// Returns a table of the torque that each parameter causes in the log.
pub(super) fn excitation(identification: &Identification) -> Option<Table> {
    let result = identification.results.first()?;
    let is_large = |share: f64| share >= SMALL_TORQUE_SHARE;
    let unit = torque_unit(identification);
    let table = rows(&result.parameters)
        .text("Parameter", |parameter| &parameter.name)
        .number(format!("Torque [{unit}]"), |parameter| {
            or_dash(parameter.torque_rms_nm, 3)
        })
        .number("% of the largest", |parameter| {
            percent_or_dash(parameter.torque_share)
        })
        .marked(|parameter| !parameter.torque_share.is_some_and(is_large));
    Some(table.table(format!(
        "Root mean square torque of each parameter in the log ({}). Marked parameters have less \
         than {:.0} % of the largest torque of their row.",
        result.estimator,
        100.0 * SMALL_TORQUE_SHARE
    )))
}

/// A parameter with less than this share of the largest torque of its row is marked.
const SMALL_TORQUE_SHARE: f64 = 0.01;
