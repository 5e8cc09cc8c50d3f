//! Where the readings of a channel come from, and how they become positions
//! or torques before they are scaled.

use std::fmt;
use std::path::PathBuf;

use crate::description::{Column, ColumnName, StartsAt};

/// Rows that share one time: those of a file, or the messages of a topic.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Stream {
    /// Another file than the log's own.
    pub file: Option<PathBuf>,
    /// Topic of a bag.
    pub topic: Option<String>,
    /// Column or field of its own time.
    pub time: Option<ColumnName>,
}

impl Stream {
    /// Returns the stream of a column.
    pub(super) fn of(column: &Column) -> Self {
        Self {
            file: column.file.clone(),
            topic: column.topic.clone(),
            time: column.time.clone(),
        }
    }
}

/// Which column of a stream.
#[derive(Clone, Debug, PartialEq)]
pub enum Pick {
    /// By its name or number.
    Column(ColumnName),
    /// One of those that a pattern matches.
    Matching {
        /// Name with a `*`.
        pattern: String,
        /// Name of the joint.
        joint: String,
        /// Place among the columns that match, from 0.
        index: usize,
        /// Columns that must match.
        of: usize,
    },
    /// A field of messages, at the joint's name where it has names.
    Field {
        /// Path of the field.
        field: String,
        /// Name of the joint in the messages.
        joint: String,
        /// Place in a list without names, from 0.
        index: usize,
        /// Length of a list without names.
        of: usize,
    },
}

impl Default for Pick {
    fn default() -> Self {
        Self::Column(ColumnName::default())
    }
}

impl Pick {
    /// Returns the column that a description names.
    pub(in crate::log) fn named(name: &ColumnName, joint: &str, index: usize, of: usize) -> Self {
        match name {
            ColumnName::Name(pattern) if name.is_pattern() => Self::Matching {
                pattern: pattern.clone(),
                joint: joint.to_owned(),
                index,
                of,
            },
            _ => Self::Column(name.clone()),
        }
    }

    /// Returns a name of a column that it would pick.
    #[must_use]
    pub fn example(&self) -> String {
        match self {
            Self::Column(name) => name.to_string(),
            Self::Matching { pattern, index, .. } => pattern.replace('*', &(index + 1).to_string()),
            Self::Field { field, joint, .. } => format!("{field}[{joint}]"),
        }
    }
}

impl fmt::Display for Pick {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Column(name) => name.fmt(f),
            Self::Matching { pattern, .. } => f.write_str(pattern),
            Self::Field { field, .. } => f.write_str(field),
        }
    }
}

/// The first value of a channel.
#[derive(Clone, Debug, PartialEq)]
pub enum Start {
    /// Known, in SI units.
    At(f64),
    /// That of another column of the same stream, in SI units.
    Of(Pick),
}

impl Start {
    pub(in crate::log) fn new(start: &StartsAt, joint: &str, index: usize, of: usize) -> Self {
        match start {
            StartsAt::Position(position) => Self::At(*position),
            StartsAt::Column(name) => {
                let name = ColumnName::Name(name.clone());
                Self::Of(Pick::named(&name, joint, index, of))
            }
        }
    }
}

/// Where the readings of a channel come from; a column of the log's own file
/// and nothing added, unless it says otherwise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Origin {
    /// Its stream.
    pub stream: Stream,
    /// Its column there.
    pub pick: Pick,
    /// What is added to each reading.
    pub offset: f64,
    /// After how much the readings start anew.
    pub wrap: Option<f64>,
    /// The first value.
    pub start: Option<Start>,
}

/// Where the time of a log comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum TimeOrigin {
    /// A column.
    Column(ColumnName),
    /// Rows follow one another so, s.
    Period(f64),
    /// The messages.
    Messages,
}
