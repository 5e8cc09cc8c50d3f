//! Checks a log before an identification.
//!
//! [`check`] reads logs once, in bounded memory, and returns findings; an identification calls
//! [`examine`] with the figures of its own pass. [`crate::log`] checks single columns. This module
//! makes the checks that need the robot's equations or the settings: whether the torque explains
//! the motion, whether a channel is late, whether the filters remove motion. These checks use the
//! beginning of the first log, an `Excerpt`.

// The compiler names each place that must handle a new law, parameter, quantity or format.
#![warn(clippy::wildcard_enum_match_arm)]

mod assemble;
mod bodies;
mod columns;
mod context;
mod degrees;
mod examine;
mod filters;
mod frequencies;
mod gears;
mod joints;
mod lines;
mod nominal;
mod order;
mod pass;
mod refusal;
mod resolution;
mod result;
mod rivals;
mod robot;
mod run;
mod scale;
mod torque_sensors;
mod trial;
mod unknowns;
mod zeros_apart;

pub use columns::reversed_torque;
pub use examine::{OfLog, examine};
pub use refusal::Refusal;
pub(crate) use resolution::{UNEXPLAINED, beyond_resolution};
pub use result::{CheckReport, Checked, CheckedLog, ColumnFigures, FindingSamples, JointFigures};
pub use run::check;
pub(crate) use unknowns::settled_or_other_meaning;

#[doc(inline)]
pub use crate::prepare::PrepareError;
