//! Validates a model on logs: on the identification log itself and on others.

// The compiler names each place that must handle a new law, parameter, quantity or format.
#![warn(clippy::wildcard_enum_match_arm)]

mod candidate;
mod changes;
mod comparison;
mod error;
mod explained;
mod findings;
mod metrics;
mod proof;
mod result;
mod run;
mod sentence;

pub use candidate::ParameterSet;
pub(crate) use changes::{Logs, OfSet, changed};
pub use error::ValidateError;
pub use metrics::{Rms, Spread};
pub(crate) use proof::worst;
pub use proof::{JointProof, QuantityProof};
pub use result::{Outcome, RootMeanSquares, RunResult, SetResult, Validation};
pub use run::{ChosenFor, Validated, validate};
pub(crate) use run::{KnownLogs, channel_delays};
