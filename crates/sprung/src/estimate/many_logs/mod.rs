//! Least squares of many logs of one robot by map and reduce: choices from one log, factors of each log,
//! parameters from all factors.

mod choices;
mod error;
mod factors;
mod identify;

pub use choices::Choices;
pub use error::FactorsError;
pub use factors::LogFactors;
pub(crate) use identify::{choices, factors, identify_factors};
