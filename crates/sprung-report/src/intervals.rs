//! Rows of values with their intervals: each row with its own scale, or all parameters of a result on
//! one scale relative to their values.

use std::collections::BTreeMap;

use super::document::{IntervalRow, Intervals, Mark, Tone};
use super::groups::Joints;
use super::numbers::{percent, significant};
use crate::estimate::{EstimateResult, Identification, NORMAL_95, ParameterEstimate};

/// The common scale shows at least this fraction of the intervals whole.
const SHOWN_WHOLE: f64 = 0.8;

/// The common scale grows up to this factor if that shows all intervals whole.
const GROWTH_FOR_ALL: f64 = 2.5;

/// More parameters than this are sorted by their intervals and folded.
const MOST_OPEN: usize = 40;

/// Limits of the groups of many parameters: half the width of an interval relative to its value.
const BANDS: [(f64, &str); 3] = [
    (0.01, "within 1 %"),
    (0.1, "within 10 %"),
    (1.0, "within 100 %"),
];

/// The last group.
const NO_BAND: &str = "wider, or without interval";

/// An interval above this multiple of its value has no number.
const MAX_RELATIVE: f64 = 10.0;

/// A value, and the ends of its interval if it has one.
pub(super) type Ranged = (f64, Option<[f64; 2]>);

/// Returns a row of values and intervals around `centre`, scaled so that the farthest end lies at
/// the end of the row.
///
/// - `values`: one per source; `None` if the source has no value.
/// - `scale`: returns a text for half the width of the row, given in the unit of the values.
pub(super) fn row(
    label: impl Into<String>,
    centre: f64,
    values: &[Option<Ranged>],
    scale: impl FnOnce(f64) -> String,
) -> IntervalRow {
    let ends = |(value, interval): &Ranged| {
        let ends = interval.iter().flatten().copied().collect::<Vec<f64>>();
        std::iter::once(*value).chain(ends)
    };
    let farthest = (values.iter().flatten().flat_map(ends))
        .map(|x| (x - centre).abs())
        .filter(|x| x.is_finite())
        .fold(0.0, f64::max);
    let half = if farthest > 0.0 { farthest } else { 1.0 };
    let place = |x: f64| (x - centre) / half;
    IntervalRow {
        label: label.into(),
        scale: if farthest > 0.0 {
            scale(half)
        } else {
            "equal".to_owned()
        },
        marks: (values.iter())
            .map(|value| {
                value.map(|(value, interval)| Mark {
                    at: place(value),
                    interval: interval.map(|ends| ends.map(place)),
                })
            })
            .collect(),
        ..IntervalRow::default()
    }
}

/// Returns the row of a parameter. Half its width is given in percent of the centre.
pub(super) fn of_parameter(
    (name, unit): (&str, &str),
    centre: f64,
    values: &[Option<Ranged>],
) -> IntervalRow {
    row(name, centre, values, percent_of(centre, unit))
}

/// Returns the row of the estimate of a parameter with those from parts of the logs alone; `None` without an estimate or
/// without any of a part.
///
/// - `parts`: values with their standard errors.
pub(super) fn around(
    parameter: &ParameterEstimate,
    parts: Vec<Option<(f64, f64)>>,
) -> Option<IntervalRow> {
    let centre = parameter.value?;
    parts.iter().any(Option::is_some).then_some(())?;
    let with_interval = |(value, error): (f64, f64)| {
        let half = NORMAL_95 * error;
        (value, Some([value - half, value + half]))
    };
    let mut values: Vec<Option<Ranged>> = vec![Some((centre, parameter.ci95))];
    values.extend(parts.into_iter().map(|part| part.map(with_interval)));
    let named = (parameter.name.as_str(), parameter.unit.as_str());
    Some(of_parameter(named, centre, &values))
}

/// Returns a text for half the width: in percent of the centre, or in the unit if the centre is
/// zero.
fn percent_of(centre: f64, unit: &str) -> impl FnOnce(f64) -> String {
    move |half| {
        if centre == 0.0 {
            format!("± {} {unit}", significant(half, 2))
        } else {
            format!("± {}", percent(half / centre.abs(), 2))
        }
    }
}

/// Returns the intervals of all parameters of the first result, relative to their values, on one
/// scale and grouped by joint; `None` without a result.
///
/// - `truth`: true values of a simulated robot, by name.
pub(super) fn relative(
    identification: &Identification,
    truth: Option<&BTreeMap<String, f64>>,
) -> Option<Intervals> {
    let result = identification.results.first()?;
    let joints = Joints::of(identification);
    let half = relative_scale(result);
    let shown = result.shown_parameters();
    let folded = shown.len() > MOST_OPEN;
    let row = |parameter: &ParameterEstimate| IntervalRow {
        group: if folded {
            band(parameter).to_owned()
        } else {
            joints.group(&parameter.name).to_owned()
        },
        label: if folded {
            parameter.name.clone()
        } else {
            joints.within(&parameter.name).to_owned()
        },
        scale: size(parameter),
        marks: {
            let mark = relative_mark(parameter, half);
            let known = truth.map(|truth| {
                let value = parameter.value.filter(|value| *value != 0.0)?;
                let at = (truth.get(&parameter.name)? / value - 1.0) / half;
                Some(Mark { at, interval: None })
            });
            std::iter::once(mark).chain(known).collect()
        },
        tone: if result.decision.parameters.contains(&parameter.name) {
            Tone::Doubtful
        } else {
            Tone::Neutral
        },
    };
    let mut sorted = joints.sorted(&shown, |parameter| &parameter.name);
    if folded {
        let width =
            |estimate: &ParameterEstimate| relative_width(estimate).unwrap_or(f64::INFINITY);
        sorted.sort_by(|a, b| width(a).total_cmp(&width(b)));
    }
    let mut names = vec![format!("{} with its 95 % interval", result.estimator)];
    names.extend(truth.map(|_| "true value".to_owned()));
    let end = percent(half, 1);
    Some(Intervals {
        caption: format!(
            "Each interval relative to its value, on one scale; the number is half its width. Arrows \
             mark what lies outside the scale.{}",
            if result.decision.parameters.is_empty() {
                ""
            } else {
                " The verdict has reservations about the marked parameters."
            }
        ),
        names,
        ticks: vec![
            (-1.0, format!("−{end}")),
            (0.0, "0".to_owned()),
            (1.0, format!("+{end}")),
        ],
        rows: sorted.into_iter().map(row).collect(),
        folded,
    })
}

/// Returns half the width of an interval relative to its value; zero for a given value.
fn relative_width(parameter: &ParameterEstimate) -> Option<f64> {
    if parameter.fixed {
        Some(0.0)
    } else {
        half_width(parameter)
    }
}

/// Returns the group of a parameter among many.
fn band(parameter: &ParameterEstimate) -> &'static str {
    let band =
        relative_width(parameter).and_then(|width| BANDS.iter().find(|(limit, _)| width <= *limit));
    band.map_or(NO_BAND, |(_, name)| name)
}

/// Returns half the width of a parameter's interval, relative to its value.
pub(super) fn half_width(parameter: &ParameterEstimate) -> Option<f64> {
    let [low, high] = parameter.ci95?;
    let half = 0.5 * (high - low) / parameter.value?.abs();
    half.is_finite().then_some(half)
}

/// Returns half the width of the scale on which all intervals of a result are drawn relative to their values: 0.05 stands for
/// 5 %. Intervals of parameters near zero are longer.
#[must_use]
pub fn relative_scale(result: &EstimateResult) -> f64 {
    common_scale(result.parameters.iter().filter_map(half_width).collect())
}

/// Returns the value that half the width of a common scale represents: one, two or five times a
/// power of ten, at most 1.
fn common_scale(mut half_widths: Vec<f64>) -> f64 {
    half_widths.retain(|half| *half > 0.0);
    half_widths.sort_by(f64::total_cmp);
    let Some(largest) = half_widths.last().copied() else {
        return 1.0;
    };
    let enough = (SHOWN_WHOLE * half_widths.len() as f64).ceil() as usize;
    let most = round_up(half_widths[enough.saturating_sub(1).min(half_widths.len() - 1)]);
    let all = round_up(largest);
    let scale = if all <= GROWTH_FOR_ALL * most {
        all
    } else {
        most
    };
    scale.min(1.0)
}

/// Returns the next number that is one, two or five times a power of ten.
pub(super) fn round_up(value: f64) -> f64 {
    let power = 10_f64.powf(value.log10().floor());
    let steps = [1.0, 2.0, 5.0].map(|step| step * power);
    let reached = steps.into_iter().find(|step| *step >= value);
    reached.unwrap_or(10.0 * power)
}

fn relative_mark(parameter: &ParameterEstimate, half: f64) -> Option<Mark> {
    let value = parameter.value.filter(|value| *value != 0.0)?;
    let place = |x: f64| (x / value - 1.0) / half;
    let interval = parameter.ci95.map(|ends| {
        let [one, other] = ends.map(place);
        [one.min(other), one.max(other)]
    });
    Some(Mark { at: 0.0, interval })
}

/// Returns half the width of a parameter's interval in words.
fn size(parameter: &ParameterEstimate) -> String {
    if parameter.fixed {
        return "given".to_owned();
    }
    let (Some(_), Some([low, high])) = (parameter.value, parameter.ci95) else {
        return "not determined".to_owned();
    };
    if let Some(most) = parameter.at_most() {
        return format!("< {}", significant(most, 2));
    }
    match half_width(parameter) {
        Some(half) if half <= MAX_RELATIVE => format!("± {}", percent(half, 2)),
        Some(_) => format!("> {}", percent(MAX_RELATIVE, 1)),
        None => format!(
            "± {} {}",
            significant(0.5 * (high - low), 2),
            parameter.unit
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_common_scale_shows_most_intervals_and_cuts_the_rest() {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        near(common_scale(vec![0.011, 0.012, 0.013, 0.015, 0.9]), 0.02);
        // All intervals are shown if that costs little.
        near(common_scale(vec![0.011, 0.012, 0.013, 0.015, 0.04]), 0.05);
        near(common_scale(vec![7.0, f64::NAN]), 1.0);
        near(common_scale(Vec::new()), 1.0);
        near(round_up(0.002), 0.002);
    }

    #[test]
    fn the_farthest_end_is_at_the_end_of_the_row() {
        let values = [
            Some((10.0, Some([9.0, 11.0]))),
            None,
            Some((12.0, Some([10.0, 14.0]))),
        ];
        let row = row("k", 10.0, &values, percent_of(10.0, "N·m/rad"));
        assert_eq!(row.scale, "± 40 %");
        let [first, none, last] = row.marks[..] else {
            panic!("three marks")
        };
        assert_eq!(none, None);
        let near = |x: f64, y: f64| assert!((x - y).abs() < 1e-12, "{x} {y}");
        near(first.unwrap().at, 0.0);
        near(first.unwrap().interval.unwrap()[0], -0.25);
        near(last.unwrap().interval.unwrap()[1], 1.0);
    }

    #[test]
    fn equal_values_and_a_centre_of_zero_need_no_division() {
        let equal = row("k", 3.0, &[Some((3.0, None))], percent_of(3.0, "N·m"));
        assert_eq!(
            (equal.scale.as_str(), equal.marks[0].unwrap().at),
            ("equal", 0.0)
        );
        let zero = row("f", 0.0, &[Some((0.5, None))], percent_of(0.0, "N·m"));
        assert_eq!(zero.scale, "± 0.50 N·m");
    }
}
