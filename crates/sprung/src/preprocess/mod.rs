//! Turns log samples into positions and velocities for the regressor.
//!
//! `Aligner` undoes delays and forms link positions; `Smoother` filters positions without phase
//! shift and differentiates them. Both process block after block; their memory does not grow with
//! the log.

mod align;
mod decimate;
mod high_pass;
mod smooth;
mod zero_phase;

pub(crate) use align::Aligner;
pub use align::RawBlock;
pub(crate) use decimate::Decimator;
pub(crate) use high_pass::{HighPass, Stage};
pub use smooth::SignalBlock;
pub(crate) use smooth::Smoother;
pub use zero_phase::{Butterworth, FilterDesignError, ZeroPhase};
