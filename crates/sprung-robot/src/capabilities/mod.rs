//! What works with what: features of robots and logs, tasks and languages.
//!
//! [`table`] is the only place that refuses a combination. The errors of the library, of the command
//! line and of Python, and the page of the reference, are made from it.

mod experiment;
mod feature;
mod page;
mod refusals;
mod table;
mod task;

pub(crate) use experiment::payload_feature;
pub use experiment::refuse_task;
pub use feature::Feature;
pub use page::what_works;
pub use refusals::refusals;
pub use table::refuse;
pub(crate) use table::together;
pub use task::Task;
pub use task::{Language, OwnCall};

/// A combination that does not work: of a feature of the robot or its logs with a task, or of two
/// features. Only the table of this module makes it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", self.0)]
pub struct NotSupported(Box<Refusal>);

/// The parts of a refusal.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{of} {has}{with}: {why}; {instead}")]
struct Refusal {
    code: &'static str,
    of: String,
    has: &'static str,
    with: String,
    why: &'static str,
    instead: &'static str,
}

impl NotSupported {
    /// Returns the code of the refusal, for scripts.
    #[must_use]
    pub fn code(&self) -> &'static str {
        self.0.code
    }

    /// Returns what to use instead.
    #[must_use]
    pub fn instead(&self) -> &'static str {
        self.0.instead
    }
}
