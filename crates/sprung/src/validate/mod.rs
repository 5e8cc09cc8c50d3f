//! A model against logs: the identification log itself and others.

mod metrics;
mod result;
mod run;

pub use metrics::{Rms, Spread};
pub use result::{Outcome, RootMeanSquares, RunResult, SetResult, Validation};
pub use run::{ParameterSet, ValidateError, Validated, validate};
