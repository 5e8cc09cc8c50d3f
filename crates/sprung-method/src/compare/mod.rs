//! Compares results of several estimators, settings, runs or robots.

// A new law, parameter, quantity or format is named wherever it is told from the others.
#![warn(clippy::wildcard_enum_match_arm)]

mod agreement;
mod combined;
mod labels;
mod promises;
mod result;
mod table;

pub use agreement::SIGNIFICANCE;
pub use promises::ComparedPromise;
pub use result::RUNS_DISAGREE;
pub use result::{
    CombinedParameter, CombinedResult, ComparedParameter, ComparedResult, ComparedValue, Comparison,
};
pub use table::{CompareError, Compared, ComparedValidation, compare};
