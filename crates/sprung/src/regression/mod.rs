//! From signals to a linear system in the parameters, reduced as it streams.
//!
//! [`Reduction`] forms and filters the regressor and folds the rows of any
//! number of samples into small triangular factors, [`System`] is what remains
//! of the logs, and [`Solution`] solves it. [`FilteredRegression`] is the same
//! regression one sample at a time.

mod batch;
mod filtered;
mod instruments;
mod nuisance_momentum;
mod pass;
mod reading;
mod reduction;
mod solution;
mod triangle;
mod weights;

pub use filtered::FilteredRegression;
pub use instruments::{CrossProducts, cross_products};
pub use pass::{
    LogFigures, Observer, PassError, Passed, Restart, read_through, reduce_blocks,
    shortest_segment, signals,
};
pub use reading::Reading;
pub use reduction::{Kept, Reduction, System};
pub use solution::{Solution, SystemPart, solve, solve_quickly};
pub use triangle::Triangle;
pub use weights::{TransitionWeights, VelocityNoise};
