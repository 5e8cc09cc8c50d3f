//! Measured logs: read and written block by block, in SI units.
//!
//! A log of any length is read in blocks of bounded size. [`Channels`] says
//! which columns hold what; `formats` knows a file by its first bytes and reads
//! numbers from it; `rows` unwraps, checks and scales them; `grid` finds out when samples
//! were taken and makes them even; `follow` brings other files and topics onto
//! these times; [`LogReader`] puts all together; [`Timing`] and [`Summary`] gather
//! what [`check`] judges.

mod channels;
mod check;
mod check_timing;
mod clock;
mod error;
mod evidence;
mod faults;
mod figures;
mod follow;
mod formats;
mod grid;
mod input;
mod names;
mod origin;
mod quantities;
mod reader;
mod resample;
mod rows;
mod sizes;
mod source;
mod summary;
mod timing;
mod watch;
mod write;

pub use channels::{Channel, ChannelError, Channels, Mix, Quantity};
pub use check::check;
pub use check_timing::{check_timing, time_unit};
pub use clock::JITTER_LIMIT;
pub use error::{LogError, Place};
pub use figures::{Event, Extent, Extreme, Figures, Overview, Stretch};
pub use formats::panics_are_caught;
pub use input::{Input, LogFile};
pub use origin::{Origin, Pick, Start, Stream, TimeOrigin};
pub use reader::LogReader;
pub use sizes::Sizes;
pub use source::{LogSource, Opener};
pub use summary::{Line, Summary};
pub use timing::{Count, Evidence, Gaps, Sampling, Timing};
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
