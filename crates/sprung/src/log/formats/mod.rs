//! Formats of logs: each turns a file into rows of numbers.
//!
//! What a file is shows in its first bytes; its name says nothing. A format
//! reads the wanted columns in blocks, and knows neither units nor joints.

mod arrays;
#[cfg(feature = "arrow")]
mod arrow;
mod arrow_claims;
mod bag;
mod cdr;
mod csv;
mod db3;
mod definition;
mod delimited;
mod mat;
#[cfg(feature = "mat73")]
mod mat73;
mod matlab;
#[cfg(feature = "mcap")]
mod mcap;
mod npy;
mod number;
mod sqlite;
mod strips;
mod zip;

use std::cell::Cell;
use std::io::Read;

use self::number::Reading;
use super::input::{Input, Kind, kind_of, peek};
use super::origin::Pick;
use super::{LogError, Place};
use crate::description::CsvForm;

/// Integers beyond this are counted from the first one: floating point numbers
/// of this size skip some.
const EXACT: u64 = 1 << 53;

/// Readings of one column, without their common origin.
#[derive(Clone, Debug, Default)]
pub(super) struct Readings {
    /// Readings less the origin.
    pub(super) values: Vec<f64>,
    /// The first reading of a column of large integers, otherwise 0.
    pub(super) origin: i64,
    started: bool,
}

impl Readings {
    /// Appends a floating point number.
    pub(super) fn push(&mut self, value: f64) {
        self.started = true;
        self.values.push(value - self.origin as f64);
    }

    /// Appends a number as it was stored.
    fn push_reading(&mut self, reading: Reading) {
        match reading {
            Reading::Float(value) => self.push(value),
            Reading::Integer(value) => self.push_integer(value),
        }
    }

    /// Appends an integer exactly.
    pub(super) fn push_integer(&mut self, value: i64) {
        if !std::mem::replace(&mut self.started, true) && value.unsigned_abs() > EXACT {
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
pub(super) trait Table: Send {
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
pub(super) struct Request<'a> {
    /// Name of the file, for messages.
    pub(super) file: &'a str,
    /// Columns.
    pub(super) picks: &'a [Pick],
    /// Index of the column in which integers and dates are times.
    pub(super) time: Option<usize>,
    /// Whether times are dates.
    pub(super) dates: bool,
    /// Topic of a bag.
    pub(super) topic: Option<&'a str>,
    /// How CSV is written.
    pub(super) csv: &'a CsvForm,
}

/// A file that is open.
pub(super) struct Opened {
    /// Its rows, with a column for each pick.
    pub(super) table: Box<dyn Table>,
    /// Names of these columns in the file.
    pub(super) names: Vec<String>,
    /// Size of the time's unit in s, if the file says it.
    pub(super) time_unit: Option<f64>,
}

/// Opens a file again at its beginning.
pub(super) type Reopen<'a> = &'a mut dyn FnMut() -> Result<Box<dyn Input>, LogError>;

thread_local! {
    static GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// Returns whether a panic of this thread will come out as an error: while a
/// file is read by a crate that panics on some damaged ones.
#[must_use]
pub fn panics_are_caught() -> bool {
    GUARDED.get()
}

/// Reads with a crate that panics on some damaged files.
#[cfg(any(feature = "arrow", feature = "mcap", feature = "mat73"))]
fn guarded<T>(file: &str, read: impl FnOnce() -> Result<T, LogError>) -> Result<T, LogError> {
    let before = GUARDED.replace(true);
    let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(read));
    GUARDED.set(before);
    result.unwrap_or_else(|_| {
        Err(LogError::format(
            file,
            " is damaged: what it says of itself does not hold; copy or write it again",
        ))
    })
}

/// Opens a file as what it is.
///
/// # Errors
///
/// [`LogError`] if it is nothing that is read, or lacks a column.
pub(super) fn open(request: &Request<'_>, reopen: Reopen<'_>) -> Result<Opened, LogError> {
    let file = request.file;
    let (start, whole, read) = peek(file, "its beginning", reopen()?)?;
    match kind_of(&start) {
        Kind::Gzip => {
            let inner = flate2::read::MultiGzDecoder::new(read);
            compressed(request, "gzip", inner)
        }
        Kind::Zstd => {
            let inner = zstd::stream::read::Decoder::new(read)
                .map_err(|error| LogError::read(file, "the zstd stream", error))?;
            compressed(request, "zstd", inner)
        }
        Kind::Text | Kind::Empty => csv::open(request, "its text", &start, whole, Box::new(read)),
        Kind::Npy => arrays::open_npy(request, reopen),
        Kind::Zip => arrays::open_npz(request, reopen),
        #[cfg(feature = "arrow")]
        kind @ (Kind::Parquet | Kind::ArrowFile | Kind::ArrowStream) => {
            arrow::open(request, kind, reopen)
        }
        #[cfg(feature = "mcap")]
        Kind::Mcap => mcap::open(request, Box::new(read)),
        Kind::Sqlite => db3::open(request, reopen()?),
        Kind::Mat5 => matlab::open(request, reopen),
        #[cfg(feature = "mat73")]
        Kind::Mat73 => mat73::open(request, reopen),
        #[cfg(not(feature = "mat73"))]
        Kind::Mat73 => Err(LogError::format(
            file,
            " is a MATLAB file of version 7.3 (HDF5), which this build of sprung does not read; save it \
             with save(…, \"-v7\"), or install sprung with it: cargo install --path crates/sprung-cli \
             --features mat73",
        )),
        Kind::Other(what) => Err(LogError::format(file, format!(" {what}"))),
        #[cfg(not(all(feature = "arrow", feature = "mcap")))]
        kind => Err(LogError::format(
            file,
            format!(
                " is {}, which this build of sprung does not read; build it with its default features",
                kind.name()
            ),
        )),
    }
}

/// Opens what a compressed file holds.
fn compressed<R: Read + Send + 'static>(
    request: &Request<'_>,
    method: &str,
    inner: R,
) -> Result<Opened, LogError> {
    let what = format!("its {method} stream");
    let (start, whole, read) = peek(request.file, &what, inner)?;
    match kind_of(&start) {
        Kind::Text | Kind::Empty => csv::open(request, &what, &start, whole, Box::new(read)),
        kind => Err(LogError::format(
            request.file,
            format!(
                " is {} compressed with {method}; decompress it, for it cannot be read in one go",
                kind.name()
            ),
        )),
    }
}
