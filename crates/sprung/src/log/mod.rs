//! Measured logs: read and written block by block, in SI units.
//!
//! A log of any length is read in blocks of bounded size.
//!
//! - [`columns`]: which columns hold what ([`Channels`]), and rows of them in SI units;
//! - [`formats`]: a file is known by its first bytes and turned into rows of numbers;
//! - [`clock`]: when samples were taken, and even samples of uneven ones;
//! - [`reader`]: all together, [`LogReader`];
//! - [`figures`]: what each channel did, [`Summary`], and what [`check`] says of it.

mod arrays;
mod block;
mod clock;
mod columns;
mod error;
mod figures;
mod formats;
mod input;
mod reader;
mod source;
mod write;

pub use arrays::{Array, Arrays, ArraysError};
pub use block::{BLOCK, LogBlock};
pub use clock::{Count, Evidence, Gaps, JITTER_LIMIT, Sampling, Timing, check_timing, time_unit};
pub use columns::{Channel, ChannelError, Channels, Mix, Origin, Pick, Start, Stream, TimeOrigin};
pub use error::{LogError, Place};
pub use figures::{
    Event, Extent, Extreme, Figures, Line, Overview, Sizes, Stretch, Summary, check,
};
pub use formats::panics_are_caught;
pub use input::{Input, LogFile};
pub use reader::LogReader;
pub use source::{LogSource, Opener};
pub use write::LogWriter;

pub use crate::description::{Measures, Quantity, Signal};
