//! Measured logs: read and written block by block, in SI units.
//!
//! A log of any length is read in blocks of bounded size. [`Channels`] says
//! which columns hold what and converts them to radians and newton metres on
//! the output side; [`CsvLog`] reads them; [`Clock`] insists on even sampling;
//! [`Summary`] gathers what [`check`] judges.

mod channels;
mod check;
mod clock;
mod csv_log;
mod source;
mod summary;
mod write;

pub use channels::{Channel, ChannelError, Channels, Mix, Quantity};
pub use check::check;
pub use clock::{Clock, Gaps, JITTER_LIMIT};
pub use csv_log::CsvLog;
pub use source::LogSource;
pub use summary::Summary;
pub use write::LogWriter;

/// Samples in a block, at most.
pub const BLOCK: usize = 2048;

/// Consecutive samples of a log; channels in the order of [`Channels::all`].
#[derive(Clone, Debug, Default)]
pub struct LogBlock {
    /// Time, s.
    pub time: Vec<f64>,
    /// One vector per channel: rad (m) or N·m (N), as its factor makes them.
    pub values: Vec<Vec<f64>>,
    /// Samples of the block that come after a gap.
    pub gaps: Vec<usize>,
}

impl LogBlock {
    /// Returns an empty block for `channels` channels.
    #[must_use]
    pub fn new(channels: usize) -> Self {
        Self {
            time: Vec::with_capacity(BLOCK),
            values: (0..channels).map(|_| Vec::with_capacity(BLOCK)).collect(),
            gaps: Vec::new(),
        }
    }

    /// Returns the number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Returns whether the block has no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// Appends a part of another block to this one, without its gaps.
    pub fn extend(&mut self, other: &Self, part: std::ops::Range<usize>) {
        self.time.extend_from_slice(&other.time[part.clone()]);
        for (own, values) in self.values.iter_mut().zip(&other.values) {
            own.extend_from_slice(&values[part.clone()]);
        }
    }

    /// Removes all samples.
    pub fn clear(&mut self) {
        self.time.clear();
        self.values.iter_mut().for_each(Vec::clear);
        self.gaps.clear();
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
    /// A line is not CSV.
    #[error("{file}: {message}")]
    Csv {
        /// Name of the file.
        file: String,
        /// What is wrong, with the line.
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
    #[error("line {line} of {file} has {found} cells, the header has {expected}")]
    Width {
        /// Name of the file.
        file: String,
        /// Line, from 1.
        line: u64,
        /// Cells of the header.
        expected: u64,
        /// Cells of the line.
        found: u64,
    },
    /// A cell is not a number.
    #[error("line {line} of {file}, column \"{column}\": \"{cell}\" is not a number{hint}")]
    NotANumber {
        /// Name of the file.
        file: String,
        /// Line, from 1.
        line: u64,
        /// Name of the column.
        column: String,
        /// Text of the cell.
        cell: String,
        /// What to do.
        hint: &'static str,
    },
    /// A cell is a number that no sensor gives.
    #[error(
        "line {line} of {file}, column \"{column}\": the value is {value}; every sample must be a \
         finite number"
    )]
    NotFinite {
        /// Name of the file.
        file: String,
        /// Line, from 1.
        line: u64,
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
        "line {line} of {file}: time goes from {before} s to {after} s; samples must be in order, \
         each with its own time"
    )]
    TimeNotIncreasing {
        /// Name of the file.
        file: String,
        /// Line, from 1.
        line: u64,
        /// Time of the sample before, s.
        before: f64,
        /// Time of this sample, s.
        after: f64,
    },
    /// Sampling is uneven.
    #[error(
        "line {line} of {file}: {step_ms:.4} ms since the sample before, the period is \
         {period_ms:.4} ms ({percent:.0} % off, 10 % is tolerated: beyond it the error of the \
         velocities exceeds that of an encoder); resample the log evenly"
    )]
    Uneven {
        /// Name of the file.
        file: String,
        /// Line, from 1.
        line: u64,
        /// Time since the sample before, ms.
        step_ms: f64,
        /// Period of the log, ms.
        period_ms: f64,
        /// Deviation from the period, percent.
        percent: f64,
    },
    /// The values of a column cannot be those of a moving robot.
    #[error("{message}")]
    Implausible {
        /// What is wrong with which column, what it likely means, what to do.
        message: String,
    },
}
