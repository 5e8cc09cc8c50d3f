//! Rows of numbers, the output of every format.

use super::number::Reading;
use crate::columns::origin::Pick;
use crate::description::{CsvForm, MissingValues};
use crate::error::{LogError, Place};
use crate::input::Input;

/// Larger integers are stored relative to the first one, because `f64` does not represent all of them.
const MAX_EXACT_INTEGER: u64 = 1 << 53;

/// Fields and columns whose texts name the elements of the lists in the same message or row.
#[cfg(any(feature = "arrow", feature = "db3", feature = "mcap"))]
pub(super) const NAMES: [&str; 3] = ["name", "joint_names", "names"];

/// Readings of one column, relative to a common origin.
#[derive(Clone, Debug, Default)]
pub(crate) struct Readings {
    /// Readings minus the origin.
    pub(crate) values: Vec<f64>,
    /// The first reading if it is an integer beyond 2^53, otherwise 0.
    pub(crate) origin: i64,
    started: bool,
}

impl Readings {
    /// Appends a floating point number.
    pub(crate) fn push(&mut self, value: f64) {
        self.started = true;
        self.values.push(value - self.origin as f64);
    }

    /// Appends a missing value.
    pub(crate) fn push_missing(&mut self) {
        self.values.push(f64::NAN);
    }

    /// Appends a number in the format of the file.
    pub(super) fn push_reading(&mut self, reading: Reading) {
        match reading {
            Reading::Float(value) => self.push(value),
            Reading::Integer(value) => self.push_integer(value),
        }
    }

    /// Appends an integer without rounding.
    pub(crate) fn push_integer(&mut self, value: i64) {
        if !std::mem::replace(&mut self.started, true) && value.unsigned_abs() > MAX_EXACT_INTEGER {
            self.origin = value;
        }
        // A difference beyond 64 bits is rounded; no column of times has one.
        let value = value
            .checked_sub(self.origin)
            .map_or(value as f64 - self.origin as f64, |value| value as f64);
        self.values.push(value);
    }
}

/// Rows of numbers.
pub(crate) trait Table: Send {
    /// Appends the next rows to `out`, at most `limit`; returns their number, 0 at the end.
    ///
    /// - `out`: receives one reading per row, [columns].
    ///
    /// # Errors
    ///
    /// [`LogError`] with the place that cannot be read.
    fn read(&mut self, limit: usize, out: &mut [Readings]) -> Result<usize, LogError>;

    /// Returns the place of row `i` of the last block in the file.
    fn place(&self, i: usize) -> Place;

    /// Returns the place in the middle of which the recording ends, if it was cut off and the end was reached.
    fn cut(&self) -> Option<Place> {
        None
    }
}

impl Request<'_> {
    /// Returns the name of the file without the topic, for errors about the whole file.
    pub(super) fn whole_file(&self) -> &str {
        whole_file(self.file, self.topic)
    }
}

/// Returns the name of a file without the topic.
pub(super) fn whole_file<'a>(file: &'a str, topic: Option<&str>) -> &'a str {
    let topic = topic.and_then(|topic| file.strip_prefix(topic));
    let alone = topic.and_then(|rest| rest.strip_prefix(" in "));
    alone.unwrap_or(file)
}

/// Columns to read from a file.
pub(crate) struct Request<'a> {
    /// Name of the file in errors.
    pub(crate) file: &'a str,
    /// Wanted columns.
    pub(crate) picks: &'a [Pick],
    /// Index of the time column among them.
    pub(crate) time: Option<usize>,
    /// Whether the time column contains dates.
    pub(crate) dates: bool,
    /// Topic of a bag.
    pub(crate) topic: Option<&'a str>,
    /// Form of a text, as far as the experiment gives it.
    pub(crate) csv: &'a CsvForm,
    /// Treatment of rows without a value.
    pub(crate) nan: MissingValues,
}

/// An open file.
pub(crate) struct Opened {
    /// Rows, with one column for each of [`Request::picks`].
    pub(crate) table: Box<dyn Table>,
    /// Names of these columns in errors and results.
    pub(crate) names: Vec<String>,
    /// Unit of the time column in s, if the file defines it.
    pub(crate) time_unit: Option<f64>,
    /// Names of all columns of the file; empty for a topic.
    pub(crate) all: Vec<String>,
    /// Whether the file names its columns; otherwise they only have numbers.
    pub(crate) has_names: bool,
    /// Units of all columns as the file writes them; empty if it has none.
    pub(crate) units: Vec<String>,
}

/// Opens a file at its beginning; may be called several times.
pub(crate) type Reopen<'a> = &'a mut dyn FnMut() -> Result<Box<dyn Input>, LogError>;

/// A number in the messages of a topic.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Element {
    /// Path of its field; `*` represents the index of an element of a list of messages.
    pub(crate) field: String,
    pub(crate) place: ElementPlace,
}

/// Place of a number in its field.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ElementPlace {
    /// The field is one number.
    Alone,
    /// Index in a list, from 0.
    #[cfg_attr(
        not(any(feature = "db3", feature = "mcap")),
        expect(dead_code, reason = "only messages of bags have such places")
    )]
    Index(usize),
    /// Name in a list whose elements have names.
    #[cfg_attr(
        not(any(feature = "db3", feature = "mcap")),
        expect(dead_code, reason = "only messages of bags have such places")
    )]
    Named(String),
}
