//! Errors of logs, with the place in the file.

use std::fmt;

use super::miss::Miss;
use crate::description::Window;
use crate::numbers::Shown;

/// A position in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line, from 1.
    Line(u64),
    /// A row of an array or a table, from 1.
    Row(u64),
    /// Number of a message within its topic, from 1.
    Message(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(number) => write!(f, "line {number}"),
            Self::Row(number) => write!(f, "row {number}"),
            Self::Message(number) => write!(f, "message {number}"),
        }
    }
}

/// An error of a log.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LogError {
    /// The file cannot be read.
    #[error("cannot read {file}: {source}")]
    Io {
        /// Name of the file.
        file: String,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The file is damaged or has another format than expected.
    #[error("{file}{message}")]
    Format {
        /// Name of the file.
        file: String,
        /// Fault, place and remedy; begins with a blank or a colon.
        message: String,
    },
    /// The file has no column of this name.
    #[error("{file} has no column \"{column}\"{hint}")]
    NoColumn {
        /// Name of the file.
        file: String,
        /// Name of the requested column.
        column: String,
        /// The nearest name, or the list of names.
        hint: String,
    },
    /// The header contains a column twice.
    #[error("{file} has two columns \"{column}\"; give one of them another name")]
    TwoColumns {
        /// Name of the file.
        file: String,
        /// Name of the column.
        column: String,
    },
    /// A line and the header differ in their number of cells.
    #[error("{place} of {file} has {found} cells, {above} {expected}")]
    Width {
        /// Name of the file.
        file: String,
        /// Place in the file.
        place: Place,
        /// Reference for the number of cells: the header, or other lines.
        above: &'static str,
        /// Number of cells of the reference.
        expected: u64,
        /// Number of cells of the line.
        found: u64,
    },
    /// A cell is not a number.
    #[error("{place} of {file}, column \"{column}\": \"{cell}\" is not a number{hint}")]
    NotANumber {
        /// Name of the file.
        file: String,
        /// Place in the file.
        place: Place,
        /// Name of the column.
        column: String,
        /// Text of the cell.
        cell: String,
        /// Remedy.
        hint: &'static str,
    },
    /// A cell is NaN or infinite.
    #[error(
        "{place} of {file}, column \"{column}\": the value is {value}; every sample must be a \
         finite number{}",
        if value.is_nan() { "; nan = \"gap\" in [log] leaves samples without a value out" } else { "" }
    )]
    NotFinite {
        /// Name of the file.
        file: String,
        /// Place in the file.
        place: Place,
        /// Name of the column.
        column: String,
        /// The value.
        value: f64,
    },
    /// There are too few samples.
    #[error("{file} has {found} samples, at least {needed} are needed: {why}")]
    TooShort {
        /// Name of the file.
        file: String,
        /// Number of samples found.
        found: u64,
        /// Number of samples needed.
        needed: u64,
        /// Computation that needs the samples.
        why: String,
    },
    /// No sample lies in the window of the log.
    #[error(
        "no sample of {file} lies in its window, {window}: {log}; correct the window under file in the \
         experiment file"
    )]
    EmptyWindow {
        /// Name of the file.
        file: String,
        /// The window.
        window: Box<Window>,
        /// Position of the log relative to the window.
        log: Miss,
    },
    /// The time does not increase.
    #[error(
        "{place} of {file}: time goes from {} s to {} s; samples must be in order, \
         each with its own time{remedy}",
        Shown(*before), Shown(*after)
    )]
    TimeNotIncreasing {
        /// Name of the file.
        file: String,
        /// Place in the file.
        place: Place,
        /// Time of the preceding sample, s.
        before: f64,
        /// Time of this sample, s.
        after: f64,
        /// Remedy; empty, or begins with a semicolon.
        remedy: &'static str,
    },
    /// The values of a column are impossible for a moving robot.
    #[error("{message}")]
    Implausible {
        /// Column, fault, likely cause and remedy.
        message: String,
    },
}

impl LogError {
    /// Returns the error of a file that is damaged or has another format than expected.
    pub(super) fn format(file: &str, message: impl fmt::Display) -> Self {
        Self::Format {
            file: file.to_owned(),
            message: message.to_string(),
        }
    }

    /// Returns the error of a failed read. Errors of decoders mean a damaged file; other errors
    /// come from the operating system.
    ///
    /// - `what`: the part of the file that was read.
    pub(super) fn read(file: &str, what: &str, source: std::io::Error) -> Self {
        use std::io::ErrorKind::{InvalidData, InvalidInput, Other, UnexpectedEof};
        match source.kind() {
            UnexpectedEof => Self::format(
                file,
                format!(" ends in the middle of {what}: it was cut off; copy or record it again"),
            ),
            InvalidData | InvalidInput | Other => Self::format(
                file,
                format!(": {what} is damaged ({source}); copy or record it again"),
            ),
            _ => Self::Io {
                file: file.to_owned(),
                source,
            },
        }
    }
}
