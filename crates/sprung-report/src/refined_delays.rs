//! Delays by likelihood: intervals and table.

use super::document::{Intervals, Table};
use super::intervals;
use super::numbers::{dash_if_none, significant};
use super::rows::rows;
use crate::estimate::{NORMAL_95, RefinedDelay};

/// A delay is marked if it differs from the used value by more than this number of standard errors.
const MARKED_STANDARD_ERRORS: f64 = 4.0;

/// Returns the name and the size of a suitable unit for the delays.
fn time_unit(delays: &[RefinedDelay]) -> (&'static str, f64) {
    let size = |delay: &RefinedDelay| {
        let error = delay.standard_error_s.unwrap_or(0.0);
        delay.delay_s.abs().max(delay.used_s.abs()).max(error)
    };
    match delays.iter().map(size).fold(0.0, f64::max) {
        longest if longest < 1e-3 => ("µs", 1e6),
        _ => ("ms", 1e3),
    }
}

/// Returns the remaining delay of each column, beyond the delay used for the parameters.
pub(super) fn delay_intervals(delays: &[RefinedDelay]) -> Option<Intervals> {
    let (unit, size) = time_unit(delays);
    let rows: Vec<_> = (delays.iter())
        .filter_map(|delay| {
            let beyond = size * (delay.delay_s - delay.used_s);
            let half = NORMAL_95 * size * delay.standard_error_s?;
            let value = [Some((beyond, Some([beyond - half, beyond + half])))];
            let scale = |half: f64| format!("± {} {unit}", significant(half, 2));
            Some(intervals::row(delay.column.clone(), 0.0, &value, scale))
        })
        .collect();
    (!rows.is_empty()).then(|| Intervals {
        caption: "Remaining delay of each column relative to the other columns, with its 95 % \
                  interval. The line in the middle is the delay used for the parameters. The number \
                  at the right is half the width of the row."
            .to_owned(),
        names: vec!["delay by likelihood".to_owned()],
        rows,
..Intervals::default()
})
}

/// Returns the table of the delays; `None` without delays.
pub(super) fn delay_table(delays: &[RefinedDelay]) -> Option<Table> {
    let (unit, size) = time_unit(delays);
    let away = |delay: &RefinedDelay| {
        let beyond = delay.delay_s - delay.used_s;
        delay.standard_error_s.map(|error| beyond / error)
    };
    rows(delays)
        .text("Column", |delay| &delay.column)
        .number(format!("Used [{unit}]"), |delay| {
            significant(size * delay.used_s, 4)
        })
        .number(format!("By likelihood ± 95 % [{unit}]"), |delay| {
            let Some(error) = delay.standard_error_s else {
                return "not determined".to_owned();
            };
            let half = NORMAL_95 * size * error;
            let value = as_exact(size * delay.delay_s, half);
            format!("{value} ± {}", significant(half, 2))
        })
        .number("Difference in s.e.", |delay| {
            dash_if_none(away(delay).map(|x| format!("{x:+.1}")))
        })
        .number("Increase of log-likelihood", |delay| {
            dash_if_none(away(delay).map(|x| format!("{:.1}", 0.5 * x * x)))
        })
        .marked(|delay| away(delay).is_some_and(|x| x.abs() > MARKED_STANDARD_ERRORS))
        .table_if_any(format!(
            "Delays. Marked delays differ from the used value by more than {MARKED_STANDARD_ERRORS} standard errors. \
             A late column can also make the other columns of its joint appear late. If several \
             columns are marked, the column with the largest increase of the log-likelihood is the \
             likeliest."
        ))
}

/// Returns a value with as many decimals as two digits of its error have.
pub(super) fn as_exact(value: f64, error: f64) -> String {
    let text = significant(error, 2);
    let decimals = text.split_once('.').map_or(0, |(_, digits)| digits.len());
    if text.contains('e') {
        significant(value, 4)
    } else {
        format!("{value:.decimals$}")
    }
}
