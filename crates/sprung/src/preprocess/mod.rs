//! From log samples to positions and velocities that a regressor can use.
//!
//! `Aligner` undoes delays and forms link positions; `Smoother` filters
//! positions without phase shift and differentiates them. Both work block by
//! block with memory that does not grow with the log.

mod align;
mod decimate;
mod smooth;
mod zero_phase;

pub(crate) use align::Aligner;
pub use align::RawBlock;
pub(crate) use decimate::Decimator;
pub use smooth::SignalBlock;
pub(crate) use smooth::Smoother;
pub use zero_phase::{Butterworth, FilterDesignError, ZeroPhase};
