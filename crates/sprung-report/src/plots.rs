//! Composes the figures of a report.

use std::collections::BTreeMap;

use super::document::{Figure, Layout, Panel, Series, Style};
use crate::curves::{CurveSet, Curves};
use crate::estimate::Identification;
use crate::model::short;
use crate::validate::RunResult;

const STYLES: [Style; 3] = [Style::First, Style::Second, Style::Third];

/// Curves whose largest error exceeds this multiple of the best curve's do not widen the scale.
const CLIPPED_ABOVE: f64 = 3.0;

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
    let panels = first.parameters.iter().enumerate().map(|(i, parameter)| {
        let mut series: Vec<Series> = trace
            .sets
            .iter()
            .zip(STYLES)
            .map(|(set, style)| Series::new(&set.label, style, sampled(set, i, &time)))
            .collect();
        let reference = match truth {
            Some(truth) => truth.get(&parameter.name).map(|v| ("true", *v)),
            None => parameter.nominal.map(|v| ("nominal", v)),
        };
        if let Some((name, value)) = reference {
            let values = vec![Some(value); time.len()];
            series.push(Series::new(name, Style::Reference, values));
        }
        drop_start(&mut series);
        Panel {
            y_label: format!("{} [{}]", short(&parameter.name), parameter.unit),
            x: time.clone(),
            series,
            ..Panel::default()
        }
    });
    Figure::over_time(
        "traces",
        "Estimates over time. Values at the start are omitted if they would dominate the scale.",
        Layout::Grid,
        panels,
    )
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

/// Removes values far outside the range of the second half, because the first estimates use very
/// few samples.
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
    let of_run: Vec<&CurveSet> = curves
        .sets
        .iter()
        .filter(|set| set.label.starts_with(&prefix))
        .collect();
    let Some((measured, simulated)) = of_run.split_first() else {
        return Vec::new();
    };
    let figure = |id: &str, caption: String, wanted: &[&str]| {
        let panels = curves
            .columns
            .iter()
            .enumerate()
            .filter(|(_, column)| wanted.iter().any(|suffix| column.ends_with(suffix)))
            .map(|(i, column)| with_errors(measured, simulated, i, column, &prefix));
        let id = format!("{id}-{}", slug(&run.name));
        Figure::over_time(id, caption, Layout::Stack, panels)
    };
    vec![
        figure(
            "positions",
            format!(
                "{}: measured and simulated positions, and their differences. {SCALE}",
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
                "{}: measured and simulated motor torques, and their differences. {SCALE}",
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
                .filter(|(_, column)| is_torque(column) || is_deflection(column))
                .map(|(i, column)| with_errors(measured, &fitted, i, column, ""))
                .collect()
        }
    };
    let caption = format!(
        "Filtered motor torques and deflections of {}, and their differences. {SCALE}",
        identification.files()
    );
    Figure::over_time("fit", caption, Layout::Stack, panels)
}

/// Explanation of the scale of panels with errors.
const SCALE: &str = "The scale is that of the best curve; triangles at the edge mark where another \
                     curve lies outside.";

/// Returns whether a column of the fit is a motor torque (force).
pub(super) fn is_torque(column: &str) -> bool {
    column.ends_with("motor_nm") || column.ends_with("motor_n")
}

/// Returns whether a column of the fit is a deflection.
pub(super) fn is_deflection(column: &str) -> bool {
    column.ends_with("deflection_rad") || column.ends_with("deflection_m")
}

/// Returns the quantity of a column and its unit, as text.
pub(super) fn quantity(column: &str) -> (String, &str) {
    let (what, unit) = column.rsplit_once('_').unwrap_or((column, ""));
    let unit = match unit {
        "nm" => "N·m",
        "n" => "N",
        other => other,
    };
    let Some((joint, what)) = what.rsplit_once('.') else {
        return (what.replace('_', " "), unit);
    };
    let what = match what {
        "motor" if unit == "N" => "motor force".to_owned(),
        "motor" => "motor torque".to_owned(),
        other => other.replace('_', " "),
    };
    (format!("{joint} {what}"), unit)
}

/// Returns a panel with all curves and their differences from the measured curve.
fn with_errors(
    measured: &CurveSet,
    others: &[&CurveSet],
    column: usize,
    name: &str,
    prefix: &str,
) -> Panel {
    let (what, unit) = quantity(name);
    let truth = &measured.values[column];
    // If the file was edited, its sets may have different times. Such sets are left out.
    let fitting = || others.iter().filter(|set| set.time == measured.time);
    let largest_error = |set: &&&CurveSet| {
        let pairs = truth.iter().zip(&set.values[column]);
        let errors = pairs.filter_map(|(a, b)| Some(((*a)? - (*b)?).abs()));
        errors.fold(0.0, f64::max)
    };
    let has_value = |set: &&&CurveSet| set.values[column].iter().any(Option::is_some);
    let best = (fitting().filter(has_value))
        .map(|set| largest_error(&set))
        .fold(f64::INFINITY, f64::min);
    let model = |(set, style): (&&CurveSet, Style)| Series {
        name: set.label.trim_start_matches(prefix).to_owned(),
        values: set.values[column].clone(),
        style,
        clipped: largest_error(&set) > CLIPPED_ABOVE * best,
    };
    Panel {
        y_label: format!("{what} [{unit}]"),
        x: measured.time.clone(),
        series: std::iter::once(measured_series(truth))
            .chain(fitting().zip(STYLES).map(model))
            .collect(),
        errors: Some(format!("difference [{unit}]")),
        ..Panel::default()
    }
}

/// Returns the series of measured values.
pub(super) fn measured_series(values: &[Option<f64>]) -> Series {
    Series::new("measured", Style::Measured, values.to_vec())
}

/// Replaces all characters except letters and digits by hyphens, for use as an anchor.
pub(super) fn slug(name: &str) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn set(label: &str, values: [f64; 3]) -> CurveSet {
        CurveSet {
            label: label.to_owned(),
            time: vec![0.0, 1.0, 2.0],
            values: vec![values.map(Some).to_vec()],
        }
    }

    #[test]
    fn the_best_curve_decides_the_scale() {
        let measured = set("run/measured", [0.0, 1.0, 0.0]);
        let (good, fair, bad) = (
            set("run/good", [0.1, 1.0, 0.0]),
            set("run/fair", [0.0, 1.0, 0.25]),
            set("run/bad", [0.0, 1.4, 0.0]),
        );
        let late = CurveSet {
            time: vec![0.0, 1.0, 3.0],
            ..set("run/late", [0.0; 3])
        };
        let others = [&bad, &late, &fair, &good];
        let panel = with_errors(&measured, &others, 0, "a.motor_torque_nm", "run/");
        let shown: Vec<(&str, bool)> = (panel.series.iter())
            .map(|series| (series.name.as_str(), series.clipped))
            .collect();
        assert_eq!(
            shown,
            [
                ("measured", false),
                ("bad", true),
                ("fair", false),
                ("good", false)
            ]
        );
        assert_eq!(panel.y_label, "a motor torque [N·m]");
        assert_eq!(panel.errors.as_deref(), Some("difference [N·m]"));
    }
}
