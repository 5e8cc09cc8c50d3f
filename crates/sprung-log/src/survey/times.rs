//! The column of the time, and its unit.

use super::families::Family;
use super::period::period;
use super::read::{Column, Source, Survey};
use super::words::{Meaning, Sort, tokens};
use super::write::{name_of, number};
use crate::description::{ChosenLine, Unit};

/// Units of times, with the rates of samples that a log of a robot has.
const UNITS: [(&str, f64); 4] = [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)];

/// Usual rate of a log, Hz; the unit whose rate is nearest to it is the likeliest.
const USUAL_RATE: f64 = 500.0;

/// Returns the line of the time; `None` for a bag, whose messages have times.
pub(super) fn time(survey: &Survey, families: &[Family]) -> Option<ChosenLine> {
    let source = survey.sources.first()?;
    if source.topic.is_some() {
        return None;
    }
    let best = clock(source).or_else(|| {
        let rises = |column: &&Column| column.figures.rises && column.figures.even;
        let first = source.columns.iter().find(rises)?;
        Some((first, "because it rises evenly"))
    });
    let Some((column, how)) = best else {
        return Some(date(survey).unwrap_or_else(|| without_time(survey, families)));
    };
    let name = name_of(survey, column);
    let unit = column.meaning().unit;
    if unit.is_none() && column.time_unit.is_none() && column.figures.counts_rows() {
        return Some(ambiguous(survey, families, &name));
    }
    let said = unit.filter(|unit| UNITS.iter().any(|(known, _)| known == unit));
    let (unit, why) = match (column.time_unit, said) {
        (Some(_), _) => ("s", format!("The time {how}; the file defines its unit")),
        (None, Some(unit)) => (unit, String::new()),
        (None, None) => {
            let unit = likeliest(column);
            let size = Unit::try_from(unit.to_owned()).map_or(1.0, Unit::size);
            let rate = 1.0 / (size * column.figures.step);
            let why = format!(
                "The time {how}, in {unit} by its step: {:.4} Hz",
                super::write::Short(rate)
            );
            (unit, why)
        }
    };
    Some(ChosenLine::new(&format!("time_{unit}"), name, why))
}

/// Returns the column that is a time by its name or its file, and the reason. A recorder may write several clocks; the one
/// with an even step is that of the samples.
pub(super) fn clock(source: &Source) -> Option<(&Column, &'static str)> {
    let is_time = |column: &&Column| {
        let sort = column.meaning().sort;
        (sort == Some(Sort::Time) || column.time_unit.is_some()) && column.figures.rises
    };
    let all = source.columns.iter().filter(is_time);
    let best = all.max_by_key(|column| (column.figures.even, -(column.number as i64)))?;
    Some((best, "by its name"))
}

/// Returns the line of the period of a log without times.
fn without_time(survey: &Survey, families: &[Family]) -> ChosenLine {
    let counter = survey.counters.first().map_or_else(String::new, |name| {
        format!("; \"{name}\" counts the rows and is no time")
    });
    match period(survey, families) {
        Some((period, why)) => {
            ChosenLine::new("period_s", number(period), format!("{why}{counter}"))
        }
        None => ChosenLine::open(
            "period_s",
            format!("FILL IN the sampling period: the log has no column of rising times{counter}"),
        ),
    }
}

/// Returns the line of a column that is called a time and rises by one in each row.
fn ambiguous(survey: &Survey, families: &[Family], name: &str) -> ChosenLine {
    match period(survey, families) {
        Some((period, why)) if (period - 1e-3).abs() < 1e-9 => ChosenLine::new(
            "time_ms",
            name,
            format!("The time by its name, in ms. {why}"),
        ),
        Some((period, why)) => {
            let why = format!("{why}; {name} rises by one in each row, so it counts the rows");
            ChosenLine::new("period_s", number(period), why)
        }
        None => ChosenLine::open(
            "period_s",
            format!(
                "FILL IN the sampling period: {name} rises by one in each row, so it may count the rows; if it is a \
                 time in ms, write time_ms = {name} in place of this line"
            ),
        ),
    }
}

/// Returns the unit that gives a usual rate of samples.
fn likeliest(column: &Column) -> &'static str {
    let off = |size: f64| (1.0 / (size * column.figures.step) / USUAL_RATE).ln().abs();
    (UNITS.iter())
        .min_by(|a, b| off(a.1).total_cmp(&off(b.1)))
        .map_or("s", |(unit, _)| unit)
}

/// Returns the line of a column of dates, which holds texts.
fn date(survey: &Survey) -> Option<ChosenLine> {
    let is_time = |name: &&String| {
        let found = Meaning::of(&tokens(name), &[]).sort;
        found == Some(Sort::Time) || name.to_lowercase().contains("date")
    };
    let name = survey.others.iter().find(is_time)?;
    Some(ChosenLine::new(
        "time",
        format!(
            "{{ column = {}, unit = \"date\" }}",
            crate::description::quoted(name)
        ),
        "Dates and times as text",
    ))
}
