//! Least squares of many logs of one robot by map and reduce: choices from one log, factors of each log,
//! parameters from all factors.

mod choices;
mod factors;
mod identify;

pub use choices::Choices;
pub use factors::LogFactors;
pub use identify::{choices, factors, identify_factors};
