//! What is wrong with a log, before anything is identified from it.
//!
//! [`check`] reads logs once, in bounded memory, and says what it found; an
//! identification asks [`examine`] with the figures of its own pass. What one
//! column shows by itself is judged in [`crate::log`]; here stands what takes the
//! robot's equations or the settings: whether the torque explains the motion, which
//! channel is late, what the filters take away. For these the beginning of the first
//! log is looked at, an `Excerpt`.

mod columns;
mod examine;
mod filters;
mod joints;
mod look;
mod offset;
mod pass;
mod refusal;
mod relative;
mod resolution;
mod result;
mod run;
mod tell;

pub use columns::reversed_torque;
pub use examine::examine;
pub use refusal::Refusal;
pub(crate) use resolution::{UNEXPLAINED, beyond_resolution};
pub use result::{
    CheckReport, Checked, CheckedLog, ColumnFigures, DelayFigures, JointFigures, LikelyDelay, Place,
};
pub use run::check;

#[doc(inline)]
pub use crate::prepare::PrepareError;
