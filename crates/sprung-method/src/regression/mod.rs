//! Forms a linear system in the parameters from signals and reduces it while the log streams.
//!
//! [`Reduction`] forms and filters the regressor and folds the rows of any number of samples into
//! small triangular factors. `System` holds the reduced logs, and `Solution` solves them.
//! [`FilteredRegression`] forms the same regression one sample at a time.

// The compiler names each place that must handle a new law, parameter, quantity or format.
#![warn(clippy::wildcard_enum_match_arm)]

mod batch;
mod filtered;
mod high_pass;
mod householder;
mod joined;
mod logs;
mod pass;
mod probes;
mod reading;
mod reduction;
mod row_factors;
mod row_reduction;
mod solution;
mod system;
mod triangle;
mod weights;

pub use filtered::FilteredRegression;
pub(crate) use logs::{LogFigures, read_through};
pub(crate) use pass::{Observer, Restart, observed_signals, reduce_signals, shortest_segment};
pub use pass::{PassError, signals};
pub(crate) use probes::Probe;
pub use reading::Reading;
pub use reduction::Reduction;
pub use solution::solve;
pub(crate) use solution::{Solution, SystemPart, solve_quickly};
pub(crate) use system::System;
pub(crate) use triangle::Triangle;
pub(crate) use weights::{TransitionWeights, VelocityNoise};
