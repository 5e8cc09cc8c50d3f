//! Compares results of several estimators, settings or runs of one robot.

// The compiler names each place that must handle a new law, parameter, quantity or format.
#![warn(clippy::wildcard_enum_match_arm)]

mod agreement;
mod combined;
mod dates;
mod drift;
mod drift_result;
mod labels;
mod promises;
mod result;
mod table;
mod trend;

pub use agreement::SIGNIFICANCE;
pub use drift_result::{Drift, PARAMETER_DRIFTS, ParameterDrift};
pub use promises::ComparedPromise;
pub use result::RUNS_DISAGREE;
pub use result::{
    CombinedParameter, CombinedResult, ComparedParameter, ComparedResult, ComparedValue, Comparison,
};
pub use table::{CompareError, Compared, ComparedValidation, compare};
