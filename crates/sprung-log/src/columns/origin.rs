//! Sources of a channel's readings, and the corrections before scaling.

use std::fmt;
use std::path::PathBuf;

use crate::description::{Column, ColumnName, StartsAt};

/// A source of rows that share one time: a file, or a topic.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Stream {
    /// File, if it is not the log's own file.
    pub file: Option<PathBuf>,
    /// Topic, if the file is a bag.
    pub topic: Option<String>,
    /// Column or field of its own time, if it has one.
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

/// Selection of a column within a stream.
#[derive(Clone, Debug, PartialEq)]
pub enum Pick {
    /// The column with this name or number.
    Column(ColumnName),
    /// One of the columns that match a pattern.
    Matching {
        /// Name with a `*`.
        pattern: String,
        /// Name of the joint.
        joint: String,
        /// Index among the matching columns, from 0.
        index: usize,
        /// Required number of matching columns.
        of: usize,
    },
    /// A field of messages, selected by joint name if the messages contain names.
    Field {
        /// Path of the field.
        field: String,
        /// Name of the joint in the messages.
        joint: String,
        /// Index in a list without names, from 0.
        index: usize,
        /// Required length of a list without names.
        of: usize,
    },
}

impl Default for Pick {
    fn default() -> Self {
        Self::Column(ColumnName::default())
    }
}

impl Pick {
    /// Returns the selection for a column of a description.
    pub(crate) fn named(name: &ColumnName, joint: &str, index: usize, of: usize) -> Self {
        match name {
            ColumnName::Name(pattern) if name.is_pattern() => Self::Matching {
                pattern: pattern.clone(),
                joint: joint.to_owned(),
                index,
                of,
            },
            ColumnName::Name(_) | ColumnName::Number(_) => Self::Column(name.clone()),
        }
    }

    /// Returns whether it is a pattern.
    pub fn is_pattern(&self) -> bool {
        matches!(self, Self::Matching { .. })
    }

    /// Returns the name of a column that this selection matches.
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

/// First value of a channel.
#[derive(Clone, Debug, PartialEq)]
pub enum Start {
    /// This value, in SI units.
    At(f64),
    /// The first value of another column of the same stream, in SI units.
    Of(Pick),
}

impl Start {
    pub(crate) fn new(start: &StartsAt, joint: &str, index: usize, of: usize) -> Self {
        match start {
            StartsAt::Position(position) => Self::At(*position),
            StartsAt::Column(name) => {
                let name = ColumnName::Name(name.clone());
                Self::Of(Pick::named(&name, joint, index, of))
            }
        }
    }
}

/// Source of a channel's readings. The default is a column of the log's own file without
/// corrections.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Origin {
    /// Stream of the column.
    pub stream: Stream,
    /// Column within the stream.
    pub pick: Pick,
    /// Offset that is added to each reading.
    pub offset: f64,
    /// Range after which the readings wrap around.
    pub wrap: Option<f64>,
    /// First value of the channel, if it is declared.
    pub start: Option<Start>,
}

/// Source of a log's time.
#[derive(Clone, Debug, PartialEq)]
pub enum TimeOrigin {
    /// A column.
    Column(ColumnName),
    /// A constant period between rows, s.
    Period(f64),
    /// The times of the messages.
    Messages,
}
