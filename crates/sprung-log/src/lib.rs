//! Measured logs, read and written block by block in SI units.
//!
//! A log of any length is read in blocks of bounded size.
//!
//! - `columns`: assigns columns to quantities ([`Channels`]) and converts rows to SI units;
//! - `formats`: recognises a file by its first bytes and turns it into rows of numbers;
//! - `clock`: finds when samples were taken, and resamples uneven samples onto an even grid;
//! - `select`: selects the samples of a window;
//! - `mend`: interpolates wrong samples or leaves them out;
//! - `reader`: combines the modules above in `LogReader`;
//! - `survey`: finds the columns of an unknown log;
//! - `figures`: gathers statistics of each channel in `Summary`, from which [`check`] makes
//!   findings.
//!
//! This crate is internal to `sprung`. Its items may change in any version; use the crate `sprung`, which re-exports the
//! public names.

mod arrays;
mod block;
mod clock;
mod columns;
mod error;
mod figures;
mod formats;
mod input;
mod mend;
mod meter;
mod miss;
mod reader;
mod select;
mod source;
mod survey;
mod write;

use sprung_base::{finding, foreign, limits as input_limits, named, numbers};
use sprung_robot as description;

pub use arrays::{Array, Arrays, ArraysError};
pub use block::LogBlock;
pub use clock::{Jitter, Sampling, Timing};
pub use clock::{TIME_UNIT, check_timing, time_unit};
pub use columns::Mix;
pub use columns::{Channel, Origin, TimeOrigin, TimeSource};
pub use columns::{ChannelError, Channels, CovariateOfJoint};
pub use columns::{InertialSensor, InertialSensors, LinkMotion};
pub use error::{LogError, Place};
pub use figures::{Figures, Overview, Summary};
pub use figures::{LOOKS_LIKE_DEGREES, LOOKS_LIKE_RADIANS, rounded, slope_remedy};
pub use figures::{SPIKES, STUCK_SAMPLES, Sizes, check, longer_part};
pub use formats::panics_are_caught;
pub use input::{Input, LogFile};
pub use input::{awaited, format_of, is_shared};
pub use mend::Mended;
pub use miss::Miss;
pub use reader::LogReader;
pub use select::Beyond;
pub use source::{LogSource, Opener};
pub use survey::ChooseError;
pub use survey::{Survey, choose, joint_count, joint_names};
pub use write::LogWriter;
pub use write::SampleWriter;

pub use crate::description::Quantity;
pub use crate::description::{Measures, Signal};
