//! Position of a log relative to a window that contains no sample of it.

use std::fmt;

use crate::numbers::Shown;

/// Position of a log relative to a window that contains no sample of it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Miss {
    /// The log ends before the window.
    LogEnds {
        /// Time of the last sample, s.
        time: f64,
        /// Number of samples.
        samples: u64,
    },
    /// The log begins after the window.
    LogBegins {
        /// Time of the first sample, s.
        time: f64,
    },
    /// The window lies between two consecutive samples.
    Between {
        /// Time of the sample before the window, s.
        before: f64,
        /// Time of the sample after the window, s.
        after: f64,
    },
}

impl fmt::Display for Miss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LogEnds { time, samples } => {
                write!(f, "its {samples} samples end at {} s", Shown(*time))
            }
            Self::LogBegins { time } => write!(f, "its first sample is at {} s", Shown(*time)),
            Self::Between { before, after } => {
                write!(
                    f,
                    "it has no sample between {} s and {} s",
                    Shown(*before),
                    Shown(*after)
                )
            }
        }
    }
}
