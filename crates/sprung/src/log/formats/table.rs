//! What every format hands on: rows of numbers.

use super::number::Reading;
use crate::description::CsvForm;
use crate::log::columns::origin::Pick;
use crate::log::error::{LogError, Place};
use crate::log::input::Input;

/// Integers beyond this are counted from the first one: floating point numbers
/// of this size skip some.
const MAX_EXACT_INTEGER: u64 = 1 << 53;

/// Readings of one column, without their common origin.
#[derive(Clone, Debug, Default)]
pub(in crate::log) struct Readings {
    /// Readings less the origin.
    pub(in crate::log) values: Vec<f64>,
    /// The first reading of a column of large integers, otherwise 0.
    pub(in crate::log) origin: i64,
    started: bool,
}

impl Readings {
    /// Appends a floating point number.
    pub(in crate::log) fn push(&mut self, value: f64) {
        self.started = true;
        self.values.push(value - self.origin as f64);
    }

    /// Appends a number as it was stored.
    pub(super) fn push_reading(&mut self, reading: Reading) {
        match reading {
            Reading::Float(value) => self.push(value),
            Reading::Integer(value) => self.push_integer(value),
        }
    }

    /// Appends an integer exactly.
    pub(in crate::log) fn push_integer(&mut self, value: i64) {
        if !std::mem::replace(&mut self.started, true) && value.unsigned_abs() > MAX_EXACT_INTEGER {
            self.origin = value;
        }
        // Differences that overflow are no times; as floats they are still right.
        let value = value
            .checked_sub(self.origin)
            .map_or(value as f64 - self.origin as f64, |value| value as f64);
        self.values.push(value);
    }
}

/// Rows of numbers.
pub(in crate::log) trait Table: Send {
    /// Appends the next rows, at most `limit`, one reading to each of `out`;
    /// returns how many, 0 at the end.
    ///
    /// # Errors
    ///
    /// [`LogError`] with the place of what cannot be read.
    fn read(&mut self, limit: usize, out: &mut [Readings]) -> Result<usize, LogError>;

    /// Returns where the `i`th row of the last block stands.
    fn place(&self, i: usize) -> Place;
}

/// What is wanted of a file.
pub(in crate::log) struct Request<'a> {
    /// Name of the file, for messages.
    pub(in crate::log) file: &'a str,
    /// Columns.
    pub(in crate::log) picks: &'a [Pick],
    /// Index of the column in which integers and dates are times.
    pub(in crate::log) time: Option<usize>,
    /// Whether times are dates.
    pub(in crate::log) dates: bool,
    /// Topic of a bag.
    pub(in crate::log) topic: Option<&'a str>,
    /// How CSV is written.
    pub(in crate::log) csv: &'a CsvForm,
}

/// A file that is open.
pub(in crate::log) struct Opened {
    /// Its rows, with a column for each pick.
    pub(in crate::log) table: Box<dyn Table>,
    /// Names of these columns in the file.
    pub(in crate::log) names: Vec<String>,
    /// Size of the time's unit in s, if the file says it.
    pub(in crate::log) time_unit: Option<f64>,
}

/// Opens a file again at its beginning.
pub(in crate::log) type Reopen<'a> = &'a mut dyn FnMut() -> Result<Box<dyn Input>, LogError>;
