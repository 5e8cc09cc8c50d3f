//! Turns log samples into positions and velocities for the regressor.
//!
//! `Aligner` undoes delays and forms link positions; `Smoother` filters positions without phase
//! shift and differentiates them. Both process block after block; their memory does not grow with
//! the log.

// The compiler names each place that must handle a new law, parameter, quantity or format.
#![warn(clippy::wildcard_enum_match_arm)]

mod align;
mod decimate;
mod deflections;
mod high_pass;
mod raw_block;
mod smooth;
mod zero_phase;

pub(crate) use align::Aligner;
pub(crate) use decimate::Decimator;
pub(crate) use high_pass::{HighPass, Stage};
pub use raw_block::RawBlock;
pub use smooth::SignalBlock;
pub(crate) use smooth::Smoother;
pub use zero_phase::{Butterworth, FilterDesignError, ZeroPhase};
