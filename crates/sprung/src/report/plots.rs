//! Composes the figures of a report.

use std::collections::BTreeMap;

use super::document::{Figure, Layout, Panel, Series, Style};
use crate::curves::{CurveSet, Curves};
use crate::estimate::Identification;
use crate::model::short;
use crate::validate::RunResult;

const STYLES: [Style; 3] = [Style::First, Style::Second, Style::Third];

/// Returns a figure of every parameter over time, one panel per parameter.
pub(super) fn traces(
    identification: &Identification,
    trace: &Curves,
    truth: Option<&BTreeMap<String, f64>>,
) -> Figure {
    let Some(first) = identification.results.first() else {
        return Figure::default();
    };
    // A panel has one time axis, so all sets use that of the first set.
    let time = trace
        .sets
        .first()
        .map(|set| set.time.clone())
        .unwrap_or_default();
    let panels = first
        .parameters
        .iter()
        .enumerate()
        .map(|(i, parameter)| {
            let mut series: Vec<Series> = trace
                .sets
                .iter()
                .zip(STYLES)
                .map(|(set, style)| Series {
                    name: set.label.clone(),
                    values: sampled(set, i, &time),
                    style,
                })
                .collect();
            let reference = match truth {
                Some(truth) => truth.get(&parameter.name).map(|v| ("true", *v)),
                None => parameter.nominal.map(|v| ("nominal", v)),
            };
            if let Some((name, value)) = reference {
                series.push(Series {
                    name: name.to_owned(),
                    values: vec![Some(value); time.len()],
                    style: Style::Reference,
                });
            }
            drop_start(&mut series);
            Panel {
                y_label: format!("{} [{}]", short(&parameter.name), parameter.unit),
                x: time.clone(),
                series,
            }
        })
        .collect();
    Figure {
        id: "traces".to_owned(),
        caption: "Estimates over time. Values at the start are omitted if they would dominate the \
                  scale."
            .to_owned(),
        x_label: "time [s]".to_owned(),
        layout: Layout::Grid,
        panels,
    }
}

/// Returns a column of a set at the samples nearest to the given times.
fn sampled(set: &CurveSet, column: usize, time: &[f64]) -> Vec<Option<f64>> {
    let values = set.values.get(column).map_or(&[][..], Vec::as_slice);
    time.iter()
        .map(|t| {
            let after = set.time.partition_point(|other| other < t);
            let nearest = match (after.checked_sub(1), set.time.get(after)) {
                (Some(before), Some(next)) if t - set.time[before] < next - t => before,
                (Some(before), None) => before,
                _ => after,
            };
            *values.get(nearest)?
        })
        .collect()
}

/// Removes values far outside the range of the second half, because the first estimates rest on
/// very few samples.
fn drop_start(series: &mut [Series]) {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for one in &*series {
        for value in one.values[one.values.len() / 2..].iter().flatten() {
            low = low.min(*value);
            high = high.max(*value);
        }
    }
    let margin = (high - low).max(0.05 * high.abs());
    for one in series {
        for value in &mut one.values {
            if value.is_some_and(|v| v < low - margin || v > high + margin) {
                *value = None;
            }
        }
    }
}

/// Returns figures of the measured and simulated positions and torques, with their errors.
pub(super) fn validation(run: &RunResult, curves: &Curves) -> Vec<Figure> {
    let prefix = format!("{}/", run.name);
    let own: Vec<&CurveSet> = curves
        .sets
        .iter()
        .filter(|set| set.label.starts_with(&prefix))
        .collect();
    let Some((measured, simulated)) = own.split_first() else {
        return Vec::new();
    };
    let figure = |id: &str, caption: String, wanted: &[&str]| {
        let panels = curves
            .columns
            .iter()
            .enumerate()
            .filter(|(_, column)| wanted.iter().any(|suffix| column.ends_with(suffix)))
            .flat_map(|(i, column)| with_error(measured, simulated, i, column, &prefix))
            .collect();
        Figure {
            id: format!("{id}-{}", slug(&run.name)),
            caption,
            x_label: "time [s]".to_owned(),
            layout: Layout::Stack,
            panels,
        }
    };
    vec![
        figure(
            "positions",
            format!(
                "{}: measured and simulated positions, and their errors.",
                run.name
            ),
            &[
                "link_position_rad",
                "motor_position_rad",
                "link_position_m",
                "motor_position_m",
            ],
        ),
        figure(
            "torques",
            format!(
                "{}: measured and simulated motor torques, and their errors.",
                run.name
            ),
            &["motor_torque_nm", "motor_force_n"],
        ),
    ]
}

/// Returns a figure of the measured and fitted filtered torques, with the residuals.
pub(super) fn fit(identification: &Identification, fit: &Curves) -> Figure {
    let panels = match fit.sets.split_first() {
        None => Vec::new(),
        Some((measured, fitted)) => {
            let fitted: Vec<&CurveSet> = fitted.iter().collect();
            (fit.columns.iter().enumerate())
                .filter(|(_, column)| column.ends_with("motor_nm") || column.ends_with("motor_n"))
                .flat_map(|(i, column)| with_error(measured, &fitted, i, column, ""))
                .collect()
        }
    };
    Figure {
        id: "fit".to_owned(),
        caption: format!("Filtered motor torques of {}.", identification.files()),
        x_label: "time [s]".to_owned(),
        layout: Layout::Stack,
        panels,
    }
}

/// Returns a panel with all curves, and a panel with their differences from the measured curve.
fn with_error(
    measured: &CurveSet,
    others: &[&CurveSet],
    column: usize,
    name: &str,
    prefix: &str,
) -> [Panel; 2] {
    let label = |set: &CurveSet| set.label.trim_start_matches(prefix).to_owned();
    let (what, unit) = name.rsplit_once('_').unwrap_or((name, ""));
    let what = what.replace('_', " ");
    let unit = match unit {
        "nm" => "N·m",
        "n" => "N",
        other => other,
    };
    let truth = &measured.values[column];
    let mut curves = vec![Series {
        name: "measured".to_owned(),
        values: truth.clone(),
        style: Style::Measured,
    }];
    let mut errors = Vec::new();
    // If the file was edited, its sets may have different times. Such sets are left out.
    let fitting = others.iter().filter(|set| set.time == measured.time);
    for (set, style) in fitting.zip(STYLES) {
        curves.push(Series {
            name: label(set),
            values: set.values[column].clone(),
            style,
        });
        errors.push(Series {
            name: label(set),
            values: (truth.iter().zip(&set.values[column]))
                .map(|(a, b)| Some((*a)? - (*b)?))
                .collect(),
            style,
        });
    }
    [
        Panel {
            y_label: format!("{what} [{unit}]"),
            x: measured.time.clone(),
            series: curves,
        },
        Panel {
            y_label: format!("error [{unit}]"),
            x: measured.time.clone(),
            series: errors,
        },
    ]
}

/// Replaces all characters except letters and digits by hyphens, for use as an anchor.
fn slug(name: &str) -> String {
    name.chars()
        .map(|c| {
            if c.is_ascii_alphanumeric() {
                c.to_ascii_lowercase()
            } else {
                '-'
            }
        })
        .collect()
}
