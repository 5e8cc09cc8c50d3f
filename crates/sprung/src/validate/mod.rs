//! Validates a model on logs: on the identification log itself and on others.

mod candidate;
mod comparison;
mod error;
mod findings;
mod metrics;
mod result;
mod run;

pub use candidate::ParameterSet;
pub use error::ValidateError;
pub use metrics::{Rms, Spread};
pub use result::{Outcome, RootMeanSquares, RunResult, SetResult, Validation};
pub use run::{ChosenFor, Validated, validate};
