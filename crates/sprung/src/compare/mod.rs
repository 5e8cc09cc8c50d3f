//! Compares results of several estimators, settings, runs or robots.

mod agreement;
mod combined;
mod labels;
mod promises;
mod result;
mod table;

pub(crate) use agreement::SIGNIFICANCE;
pub use promises::ComparedPromise;
pub(crate) use result::RUNS_DISAGREE;
pub use result::{
    CombinedParameter, CombinedResult, ComparedParameter, ComparedResult, ComparedValue, Comparison,
};
pub use table::{CompareError, Compared, ComparedValidation, compare};
