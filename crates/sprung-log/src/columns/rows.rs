//! Rows of one stream in SI units: the readings are checked, unwrapped, shifted and scaled.

use std::ops::Range;

use super::channel::Channel;
use super::origin::Start;
use crate::description::MissingValues;
use crate::error::{LogError, Place};
use crate::formats::table::{Opened, Readings, Table};

/// Source of a stream's time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum TimeOfRows {
    /// The first column; the value is its factor to s.
    Column(f64),
    /// A constant period between rows, s.
    Period(f64),
    /// The stream has no time; its rows match those of another stream.
    None,
}

/// Conversion of readings to a quantity.
#[derive(Clone, Debug)]
struct Conversion {
    column: usize,
    factor: f64,
    offset: f64,
    unwrap: Option<Unwrap>,
    start: StartState,
}

#[derive(Clone, Copy, Debug)]
struct Unwrap {
    after: f64,
    last: f64,
    turns: f64,
}

#[derive(Clone, Copy, Debug)]
enum StartState {
    /// Readings are absolute.
    Absolute,
    /// The first value will be this number, or the first value of this column.
    Known(f64),
    Column(usize),
    /// First reading, and the value assigned to it.
    Begun(f64, f64),
}

/// Rows whose faults are errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tolerance {
    /// All rows.
    Strict,
    /// The rows that [`Rows::check`] examines, because others lie outside a window.
    OfWindow,
}

/// Rows of one stream.
pub(crate) struct Rows {
    file: String,
    table: Box<dyn Table>,
    names: Vec<String>,
    time: TimeOfRows,
    conversions: Vec<Conversion>,
    readings: Vec<Readings>,
    // Number of rows before those in memory.
    before: u64,
    tolerance: Tolerance,
    nan: MissingValues,
    // A row in memory that could not be read, and its error.
    fault: Option<(usize, LogError)>,
    // Error of the part that follows the rows in memory.
    later: Option<LogError>,
    // Times, s, relative to the origin.
    pub(crate) times: Vec<f64>,
    // One vector per channel of this stream.
    pub(crate) values: Vec<Vec<f64>>,
}

impl Rows {
    /// - `time`: source of the time; a time column is the first column.
    /// - `channels`: the channels of the columns that follow.
    /// - `starts`: indices of the columns with first values, which come last.
    /// - `tolerance`, `nan`: rows whose faults are errors, and treatment of rows without a value.
    pub(crate) fn new(
        file: &str,
        opened: Opened,
        time: TimeOfRows,
        channels: &[&Channel],
        starts: &[Option<usize>],
        (tolerance, nan): (Tolerance, MissingValues),
    ) -> Self {
        let time = match (time, opened.time_unit) {
            (TimeOfRows::Column(_), Some(unit)) => TimeOfRows::Column(unit),
            _ => time,
        };
        let first = usize::from(matches!(time, TimeOfRows::Column(_)));
        let conversions = (channels.iter().zip(starts).enumerate())
            .map(|(i, (channel, start))| Conversion {
                column: first + i,
                factor: channel.factor,
                offset: channel.origin.offset,
                unwrap: channel.origin.wrap.map(|after| Unwrap {
                    after,
                    last: f64::NAN,
                    turns: 0.0,
                }),
                start: match (&channel.origin.start, start) {
                    (Some(Start::At(value)), _) => StartState::Known(*value),
                    (Some(Start::Of(_)), Some(column)) => StartState::Column(*column),
                    _ => StartState::Absolute,
                },
            })
            .collect();
        Self {
            file: file.to_owned(),
            table: opened.table,
            readings: vec![Readings::default(); opened.names.len()],
            names: opened.names,
            time,
            conversions,
            before: 0,
            tolerance,
            nan,
            fault: None,
            later: None,
            times: Vec::new(),
            values: vec![Vec::new(); channels.len()],
        }
    }

    /// Returns the name in the file of the column of channel `i` of this stream.
    pub(crate) fn name(&self, i: usize) -> &str {
        &self.names[self.conversions[i].column]
    }

    /// Replaces the rows in memory by the next ones, at most `limit`. Returns their number, 0 at
    /// the end.
    ///
    /// # Errors
    ///
    /// [`LogError`] with the place of the fault.
    pub(crate) fn read(&mut self, limit: usize) -> Result<usize, LogError> {
        self.before += self.len() as u64;
        for readings in &mut self.readings {
            readings.values.clear();
        }
        self.times.clear();
        for values in &mut self.values {
            values.clear();
        }
        let count = self.read_readings(limit)?;
        if self.tolerance == Tolerance::Strict {
            self.check(0..count)?;
        }
        match self.time {
            TimeOfRows::Column(factor) => {
                let readings = self.readings[0].values.iter();
                self.times.extend(readings.map(|reading| reading * factor));
            }
            TimeOfRows::Period(period) => {
                let rows = self.before..self.before + count as u64;
                self.times.extend(rows.map(|row| row as f64 * period));
            }
            TimeOfRows::None => {}
        }
        for i in 0..self.conversions.len() {
            self.convert(i);
        }
        Ok(count)
    }

    fn len(&self) -> usize {
        self.readings.first().map_or(0, |first| first.values.len())
    }

    /// Returns the place of the `i`th row in memory.
    pub(crate) fn place(&self, i: usize) -> Place {
        self.table.place(i)
    }

    /// Returns the place in the middle of which the stream ends, if it was cut off.
    pub(crate) fn cut(&self) -> Option<Place> {
        self.table.cut()
    }

    /// Returns the origin of the times, ns.
    pub(crate) fn origin(&self) -> i128 {
        match self.time {
            TimeOfRows::Column(factor) => {
                i128::from(self.readings[0].origin) * (factor * 1e9).round() as i128
            }
            TimeOfRows::Period(_) | TimeOfRows::None => 0,
        }
    }

    /// Reads the next readings, at most `limit` of each column; returns their number.
    fn read_readings(&mut self, limit: usize) -> Result<usize, LogError> {
        self.fault = None;
        if let Some(error) = self.later.take() {
            return Err(error);
        }
        match self.table.read(limit, &mut self.readings) {
            Err(error) if self.tolerance == Tolerance::OfWindow => self.complete_rows(error),
            read => read,
        }
    }

    /// Keeps the rows before an error; returns their number. An unreadable row counts as a row if
    /// the rows after it can be read.
    fn complete_rows(&mut self, error: LogError) -> Result<usize, LogError> {
        let lengths = self.readings.iter().map(|readings| readings.values.len());
        let (rows, most) = (
            lengths.clone().min().unwrap_or(0),
            lengths.max().unwrap_or(0),
        );
        let of_row = matches!(error, LogError::NotANumber { .. } | LogError::Width { .. });
        if of_row && most <= rows + 1 {
            for readings in &mut self.readings {
                readings.values.resize(rows + 1, f64::NAN);
            }
            self.fault = Some((rows, error));
            return Ok(rows + 1);
        }
        if rows == 0 {
            return Err(error);
        }
        for readings in &mut self.readings {
            readings.values.truncate(rows);
        }
        self.later = Some(error);
        Ok(rows)
    }

    /// Returns the error of the part that follows the rows in memory, if it cannot be read.
    pub(crate) fn later(&mut self) -> Option<LogError> {
        self.later.take()
    }

    /// Returns whether the `i`th row in memory lacks a value and is to be left out.
    pub(crate) fn lacks(&self, i: usize) -> bool {
        self.nan == MissingValues::Gap
            && (self.readings.iter()).any(|readings| readings.values[i].is_nan())
    }

    /// Checks that rows in memory contain finite numbers, or no value if such rows are left out.
    ///
    /// # Errors
    ///
    /// [`LogError`] with the place of the first fault.
    pub(crate) fn check(&mut self, rows: Range<usize>) -> Result<(), LogError> {
        let fault = self.fault.as_ref().map(|(row, _)| *row);
        let fault = fault.filter(|row| rows.contains(row));
        let readable = rows.start..fault.unwrap_or(rows.end);
        for (readings, name) in self.readings.iter().zip(&self.names) {
            let values = &readings.values[readable.clone()];
            if let Some(i) = values.iter().position(|value| !self.may_be(*value)) {
                return Err(LogError::NotFinite {
                    file: self.file.clone(),
                    place: self.place(readable.start + i),
                    column: name.clone(),
                    value: values[i],
                });
            }
        }
        match self.fault.take_if(|_| fault.is_some()) {
            Some((_, error)) => Err(error),
            None => Ok(()),
        }
    }

    fn may_be(&self, value: f64) -> bool {
        value.is_finite() || self.nan == MissingValues::Gap && value.is_nan()
    }

    fn convert(&mut self, i: usize) {
        let conversion = &mut self.conversions[i];
        let readings = &self.readings[conversion.column];
        let (origin, factor) = (readings.origin as f64, conversion.factor);
        let shift = origin + conversion.offset;
        let out = &mut self.values[i];
        let unwrap = &mut conversion.unwrap;
        let mut unwrapped = readings.values.iter().map(|&reading| match unwrap {
            None => reading,
            Some(unwrap) => unwrap.next(reading),
        });
        let value_at = |i: usize| match conversion.start {
            StartState::Column(column) => {
                self.readings[column].values[i] + self.readings[column].origin as f64
            }
            StartState::Known(value) => value,
            StartState::Absolute | StartState::Begun(..) => f64::NAN,
        };
        // Unreadable rows before a window have no value.
        let first = (readings.values.iter().enumerate())
            .map(|(i, &reading)| (reading, value_at(i)))
            .find(|(reading, value)| reading.is_finite() && value.is_finite());
        if let StartState::Known(_) | StartState::Column(_) = conversion.start
            && let Some((first, value)) = first
        {
            conversion.start = StartState::Begun(first, value);
        }
        match conversion.start {
            StartState::Begun(first, value) => {
                out.extend(unwrapped.by_ref().map(|x| value + factor * (x - first)));
            }
            // Without offset, the reading is only multiplied, so that no rounding is added.
            _ if shift.to_bits() == 0 => out.extend(unwrapped.by_ref().map(|x| x * factor)),
            StartState::Absolute | StartState::Known(_) | StartState::Column(_) => {
                out.extend(unwrapped.by_ref().map(|x| (x + shift) * factor));
            }
        }
    }
}

impl Unwrap {
    fn next(&mut self, reading: f64) -> f64 {
        if reading.is_nan() {
            return reading;
        }
        if !self.last.is_nan() {
            self.turns -= ((reading - self.last) / self.after).round();
        }
        self.last = reading;
        reading + self.turns * self.after
    }
}
