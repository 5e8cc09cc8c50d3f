//! Measured logs, read and written block by block in SI units.
//!
//! A log of any length is read in blocks of bounded size.
//!
//! - `columns`: assigns columns to quantities ([`Channels`]) and converts rows to SI units;
//! - `formats`: recognises a file by its first bytes and turns it into rows of numbers;
//! - `clock`: finds when samples were taken, and resamples uneven samples onto an even grid;
//! - `select`: selects the samples of a window;
//! - `reader`: combines the modules above in `LogReader`;
//! - `survey`: finds the columns of a log of which nothing is known;
//! - `figures`: gathers statistics of each channel in `Summary`, from which [`check`] makes
//!   findings.

mod arrays;
mod block;
mod clock;
mod columns;
mod error;
mod figures;
mod formats;
mod input;
mod meter;
mod miss;
mod reader;
mod select;
mod source;
mod survey;
mod write;

pub use arrays::{Array, Arrays, ArraysError};
pub use block::LogBlock;
pub use clock::{Sampling, Timing};
pub(crate) use clock::{check_timing, time_unit};
pub(crate) use columns::Mix;
#[cfg(test)]
pub(crate) use columns::{Channel, Origin, TimeOrigin};
pub use columns::{ChannelError, Channels};
pub(crate) use columns::{Gyroscope, Gyroscopes};
pub use error::{LogError, Place};
pub(crate) use figures::{Figures, Overview, Summary};
pub(crate) use figures::{LOOKS_LIKE_DEGREES, rounded, slope_remedy};
pub use figures::{Sizes, check};
pub use formats::panics_are_caught;
pub(crate) use input::format_of;
pub use input::{Input, LogFile};
pub use miss::Miss;
pub(crate) use reader::LogReader;
pub use select::Beyond;
pub use source::{LogSource, Opener};
pub use survey::ChooseError;
pub(crate) use survey::{Survey, choose, joint_count};
pub use write::LogWriter;
pub(crate) use write::SampleWriter;

pub(crate) use crate::description::Quantity;
pub(crate) use crate::description::{Measures, Signal};
