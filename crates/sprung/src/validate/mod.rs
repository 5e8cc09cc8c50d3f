//! A model against logs: the identification log itself and others.

mod candidate;
mod metrics;
mod result;
mod run;

pub use candidate::ParameterSet;
pub use metrics::{Rms, Spread};
pub use result::{Outcome, RootMeanSquares, RunResult, SetResult, Validation};
pub use run::{ValidateError, Validated, validate};
