//! What is wrong with a log, and where.

use std::fmt;

/// Where in a file something stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line, from 1.
    Line(u64),
    /// A row of an array or a table, from 1.
    Row(u64),
    /// A message of its topic, from 1.
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

/// What is wrong with a log.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LogError {
    /// The file cannot be read.
    #[error("cannot read {file}: {source}")]
    Io {
        /// Name of the file.
        file: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file is not what it seems, or is damaged.
    #[error("{file}{message}")]
    Format {
        /// Name of the file.
        file: String,
        /// What is wrong, where, and what to do; begins with a blank or a colon.
        message: String,
    },
    /// The header has no such column.
    #[error("{file} has no column \"{column}\"{hint}")]
    NoColumn {
        /// Name of the file.
        file: String,
        /// Name of the column asked for.
        column: String,
        /// The nearest name or the list of names.
        hint: String,
    },
    /// The header has a column twice.
    #[error("{file} has two columns \"{column}\"; give one of them another name")]
    TwoColumns {
        /// Name of the file.
        file: String,
        /// Name of the column.
        column: String,
    },
    /// A line has another number of cells than the header.
    #[error("{place} of {file} has {found} cells, {above} {expected}")]
    Width {
        /// Name of the file.
        file: String,
        /// Where in the file.
        place: Place,
        /// What stands above: a header or other lines.
        above: &'static str,
        /// Cells above.
        expected: u64,
        /// Cells of the line.
        found: u64,
    },
    /// A cell is not a number.
    #[error("{place} of {file}, column \"{column}\": \"{cell}\" is not a number{hint}")]
    NotANumber {
        /// Name of the file.
        file: String,
        /// Where in the file.
        place: Place,
        /// Name of the column.
        column: String,
        /// Text of the cell.
        cell: String,
        /// What to do.
        hint: &'static str,
    },
    /// A cell is a number that no sensor gives.
    #[error(
        "{place} of {file}, column \"{column}\": the value is {value}; every sample must be a \
         finite number"
    )]
    NotFinite {
        /// Name of the file.
        file: String,
        /// Where in the file.
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
        /// Samples found.
        found: u64,
        /// Samples needed.
        needed: u64,
        /// What needs them.
        why: String,
    },
    /// Time does not go forward.
    #[error(
        "{place} of {file}: time goes from {before} s to {after} s; samples must be in order, \
         each with its own time{remedy}"
    )]
    TimeNotIncreasing {
        /// Name of the file.
        file: String,
        /// Where in the file.
        place: Place,
        /// Time of the sample before, s.
        before: f64,
        /// Time of this sample, s.
        after: f64,
        /// What to do; begins with a semicolon, or empty.
        remedy: &'static str,
    },
    /// The values of a column cannot be those of a moving robot.
    #[error("{message}")]
    Implausible {
        /// What is wrong with which column, what it likely means, what to do.
        message: String,
    },
}

impl LogError {
    /// Returns the error of a file that is not what it seems.
    pub(super) fn format(file: &str, message: impl fmt::Display) -> Self {
        Self::Format {
            file: file.to_owned(),
            message: message.to_string(),
        }
    }

    /// Returns the error of reading: what decoders say is the file's fault, the
    /// rest is the system's.
    ///
    /// - `what`: which part of the file was read.
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
