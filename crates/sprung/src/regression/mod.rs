//! From signals to a linear system in the parameters, reduced as it streams.
//!
//! [`FilteredRegression`] forms the filtered regressor of one sample,
//! [`Reduction`] folds the rows of any number of samples into small triangular
//! factors, [`System`] is what remains of the log, and [`Solution`] solves it.

mod base_parameters;
mod filtered;
mod pass;
mod reduction;
mod solution;
mod triangle;

pub use base_parameters::BaseParameters;
pub use filtered::{FilteredRegression, FilteredSample};
pub use pass::{Observer, PassError, Passed, Reading, Stages, read_through};
pub use reduction::{Reduction, System};
pub use solution::{Solution, SystemPart, solve, solve_quickly};
pub use triangle::Triangle;
