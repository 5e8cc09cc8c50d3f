//! Composes the tables of an identification.

use std::collections::BTreeMap;

use super::document::{Column, Row, Table, Tone};
use super::groups::Joints;
use super::intervals::half_width;
use super::numbers::{deviation, given, or_dash, significant};
use crate::estimate::{CrossCheckResult, EstimateResult, Identification, ParameterEstimate};
use crate::finding::Finding;

pub(super) fn text(heading: &str) -> Column {
    Column {
        heading: heading.to_owned(),
        numeric: false,
    }
}

pub(super) fn number(heading: impl Into<String>) -> Column {
    Column {
        heading: heading.into(),
        numeric: true,
    }
}

fn with_error(estimate: &ParameterEstimate) -> String {
    let value = or_dash(estimate.value, 5);
    if let Some(most) = estimate.at_most() {
        return format!("{value} (< {})", significant(most, 2));
    }
    if estimate.fixed {
        return format!("{value} given");
    }
    match estimate.standard_error {
        Some(error) => format!("{value} ± {}", significant(error, 2)),
        None => value,
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
    let has_nominal = result.parameters.iter().any(|p| p.nominal.is_some());
    let mut columns = vec![
        text("Parameter"),
        number(format!("{} ± s.e.", result.estimator)),
        text("Unit"),
        number("± % (95 %)"),
    ];
    if truth.is_some() {
        columns.extend([number("True"), number("error %")]);
    }
    if has_nominal {
        columns.extend([number("Nominal"), number("from nominal %")]);
    }
    let has_moved = result.parameters.iter().any(has_moved);
    if has_moved {
        columns.push(number("Possible"));
    }
    let row = |parameter: &&ParameterEstimate| {
        let mut cells = vec![
            symbol_and_name(parameter),
            match (parameter.value, identification.bound(&parameter.name)) {
                (None, Some(bound)) => bound,
                _ => with_error(parameter),
            },
            parameter.unit.clone(),
            relative_interval(parameter),
        ];
        if let Some(truth) = truth {
            let known = truth.get(&parameter.name).copied();
            cells.extend([given(known), deviation(parameter.value, known)]);
        }
        if has_nominal {
            let nominal = parameter.nominal;
            cells.extend([given(nominal), deviation(parameter.value, nominal)]);
        }
        if has_moved {
            cells.push(given(parameter.physical));
        }
        Row {
            cells,
            tone: tone(result, &parameter.name),
        }
    };
    let shown = result.shown_parameters();
    let of_joint = (shown.iter())
        .filter(|parameter| joint.is_none_or(|joint| joints.group(&parameter.name) == joint));
    let sorted = joints.sorted(of_joint, |parameter| &parameter.name);
    let mut headings: Vec<(usize, String)> = Vec::new();
    let headed: &[_] = if joint.is_none() { &sorted } else { &[] };
    for (i, parameter) in headed.iter().enumerate() {
        let group = joints.group(&parameter.name);
        if headings.last().is_none_or(|(_, last)| last != group) {
            headings.push((i, group.to_owned()));
        }
    }
    let possible = if has_moved {
        " The possible values are those of bodies and drives that can exist, nearest to the estimate."
    } else {
        ""
    };
    Some(Table {
        caption: format!(
            "Parameters by {}. Notes or warnings concern the marked rows. A dash means that the log \
             does not determine the value, or that the value was not given.{possible}",
            result.estimator
        ),
        columns,
        rows: sorted.iter().map(row).collect(),
        headings,
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
    let mut columns = vec![text("Parameter"), text("Unit")];
    for result in results {
        columns.push(number(format!("{} ± s.e.", result.estimator)));
        columns.push(number(if truth.is_some() {
            "error %"
        } else {
            "from nominal %"
        }));
    }
    let shown: Vec<Vec<ParameterEstimate>> = results
        .iter()
        .map(EstimateResult::shown_parameters)
        .collect();
    let row = |parameter: &ParameterEstimate| {
        let mut cells = vec![symbol_and_name(parameter), parameter.unit.clone()];
        let known = match truth {
            Some(truth) => truth.get(&parameter.name).copied(),
            None => parameter.nominal,
        };
        for parameters in &shown {
            let estimate = parameters.iter().find(|one| one.name == parameter.name);
            cells.push(estimate.map_or_else(|| "–".to_owned(), with_error));
            let value = estimate.and_then(|estimate| estimate.value);
            cells.push(deviation(value, known));
        }
        Row {
            cells,
            tone: Tone::Neutral,
        }
    };
    Some(Table {
        caption: "Values of all estimators.".to_owned(),
        columns,
        rows: shown.first()?.iter().map(row).collect(),
        ..Table::default()
    })
}

fn symbol_and_name(parameter: &ParameterEstimate) -> String {
    let symbol = parameter.symbol.replace("theta", "θ");
    format!("{symbol}\u{a0}{}", parameter.label())
}

/// Returns half the width of the 95 % interval in percent of the value.
fn relative_interval(parameter: &ParameterEstimate) -> String {
    let half = half_width(parameter).map(|half| 100.0 * half);
    half.map_or_else(|| "–".to_owned(), |half| significant(half, 2))
}

fn tone(result: &EstimateResult, parameter: &String) -> Tone {
    let is_named = |finding: &Finding| finding.parameters.contains(parameter);
    if result.warnings.iter().any(is_named) {
        Tone::Doubtful
    } else {
        Tone::Neutral
    }
}

/// Returns a table that compares each motor row alone with the estimate from all rows.
pub(super) fn motor_rows(identification: &Identification) -> Option<Table> {
    let result = identification
        .results
        .iter()
        .find(|r| !r.motor_rows.is_empty())?;
    let rows = result
        .motor_rows
        .iter()
        .flat_map(|row| &row.parameters)
        .map(|alone| {
            let stacked = result.parameter(&alone.name);
            Row {
                cells: vec![
                    alone.name.clone(),
                    alone.unit.clone(),
                    stacked.map_or_else(String::new, with_error),
                    with_error(alone),
                ],
                tone: Tone::Neutral,
            }
        })
        .collect();
    Some(Table {
        caption: format!(
            "{} from all rows, compared with least squares on the motor row of each joint alone.",
            result.estimator
        ),
        columns: vec![
            text("Parameter"),
            text("Unit"),
            number(format!("{} ± s.e.", result.estimator)),
            number("Motor row alone ± s.e."),
        ],
        rows,
        ..Table::default()
    })
}

/// Returns a table that compares the cross-checks with the estimate that they check.
pub(super) fn cross_checks(identification: &Identification) -> Option<Table> {
    let result = identification
        .results
        .iter()
        .find(|r| !r.cross_checks.is_empty())?;
    let mut columns = vec![
        text("Parameter"),
        text("Unit"),
        number(format!("{} ± s.e.", result.estimator)),
    ];
    columns.extend((result.cross_checks.iter()).map(|check| number(check.method.clone())));
    let row = |parameter: &ParameterEstimate| {
        let mut cells = vec![
            parameter.name.clone(),
            parameter.unit.clone(),
            with_error(parameter),
        ];
        let of = |check: &CrossCheckResult| or_dash(check.values.get(&parameter.name), 5);
        cells.extend(result.cross_checks.iter().map(of));
        Row {
            cells,
            tone: Tone::Neutral,
        }
    };
    Some(Table {
        caption: format!(
            "{}, and the cross-checks by other methods.",
            result.estimator
        ),
        columns,
        rows: result.parameters.iter().map(row).collect(),
        ..Table::default()
    })
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
    let mut columns = vec![text("Row")];
    for result in &identification.results {
        columns.push(number(format!("{} [{unit}]", result.estimator)));
        columns.push(number("% of torque"));
    }
    let rows = identification
        .results
        .first()
        .map(|result| result.residual_rms.iter())
        .into_iter()
        .flatten()
        .map(|(row, _)| {
            let mut cells = vec![
                row.trim_end_matches("_nm")
                    .trim_end_matches("_n")
                    .to_owned(),
            ];
            for result in &identification.results {
                cells.push(or_dash(result.residual_rms.get(row), 3));
                cells.push(
                    result
                        .relative_residual
                        .get(row)
                        .map_or_else(|| "–".to_owned(), |r| format!("{:.1}", 100.0 * r)),
                );
            }
            Row {
                cells,
                tone: Tone::Neutral,
            }
        })
        .collect();
    Table {
        caption: "Residuals of the filtered regression.".to_owned(),
        columns,
        rows,
        ..Table::default()
    }
}

/// Returns a table of the torque that each parameter causes in the log.
pub(super) fn excitation(identification: &Identification) -> Option<Table> {
    let result = identification.results.first()?;
    let rows = (result.parameters.iter())
        .map(|parameter| Row {
            cells: vec![
                parameter.name.clone(),
                or_dash(parameter.torque_rms_nm, 3),
                parameter
                    .torque_share
                    .map_or_else(|| "–".to_owned(), |share| format!("{:.1}", 100.0 * share)),
            ],
            tone: match parameter.torque_share {
                Some(share) if share >= SMALL_TORQUE_SHARE => Tone::Neutral,
                _ => Tone::Doubtful,
            },
        })
        .collect();
    Some(Table {
        caption: format!(
            "Root mean square torque of each parameter in the log ({}). Marked parameters have less \
             than {:.0} % of the largest torque of their row.",
            result.estimator,
            100.0 * SMALL_TORQUE_SHARE
        ),
        columns: vec![
            text("Parameter"),
            number(format!("Torque [{}]", torque_unit(identification))),
            number("% of the largest"),
        ],
        rows,
        ..Table::default()
    })
}

/// A parameter with less than this share of the largest torque of its row is marked.
const SMALL_TORQUE_SHARE: f64 = 0.01;
