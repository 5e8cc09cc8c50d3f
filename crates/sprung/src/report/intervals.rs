//! Rows of values with their intervals, each row with its own scale.

use super::document::{IntervalRow, Mark};
use super::numbers::significant;
use crate::model::short;

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
    }
}

/// Returns the row of a parameter. Half its width is given in percent of the centre.
pub(super) fn of_parameter(
    (name, unit): (&str, &str),
    centre: f64,
    values: &[Option<Ranged>],
) -> IntervalRow {
    row(short(name), centre, values, percent_of(centre, unit))
}

/// Returns a text for half the width: in percent of the centre, or in the unit if the centre is
/// zero.
fn percent_of(centre: f64, unit: &str) -> impl FnOnce(f64) -> String {
    move |half| {
        if centre == 0.0 {
            format!("± {} {unit}", significant(half, 2))
        } else {
            format!("± {} %", significant(100.0 * half / centre.abs(), 2))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
