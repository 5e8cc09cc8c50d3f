//! Validates a model on logs: on the identification log itself and on others.

// A new law, parameter, quantity or format is named wherever it is told from the others.
#![warn(clippy::wildcard_enum_match_arm)]

mod candidate;
mod changes;
mod comparison;
mod diagnosis;
mod error;
mod findings;
mod metrics;
mod proof;
mod result;
mod run;
mod sentence;

pub use candidate::ParameterSet;
pub use error::ValidateError;
pub use metrics::{Rms, Spread};
pub(crate) use proof::worst;
pub use proof::{JointProof, QuantityProof};
pub use result::{Outcome, RootMeanSquares, RunResult, SetResult, Validation};
pub use run::{ChosenFor, Validated, validate};
