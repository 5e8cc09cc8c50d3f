//! The verdict on a result as a word, and the decision.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::finding::{Finding, Severity};

/// Decision on a result, with its evidence.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Decision {
    /// The decision in words.
    pub sentence: String,
    /// The verdict and the promised errors alone, as a sentence.
    #[serde(default)]
    pub promise: String,
    /// The reasons against the values, as clauses; empty for a good result.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub because: String,
    /// Codes of the findings that decided, the most severe first.
    pub findings: Vec<String>,
    /// Names of the parameters that cannot be trusted alone.
    pub parameters: Vec<String>,
}

/// Verdict on a result: whether it predicts a new experiment, and whether its numbers can be trusted
/// alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The result predicts held-out parts of the log, and its confidence intervals can be trusted.
    Good,
    /// The result predicts, but some parameters cannot be trusted alone.
    Doubtful,
    /// The result does not predict, or its numbers are impossible.
    Unusable,
}

impl Verdict {
    /// Returns the verdict that follows from findings. A serious finding makes a result unusable, a
    /// warning makes it doubtful.
    #[must_use]
    pub fn of<'a>(findings: impl IntoIterator<Item = &'a Finding>) -> Self {
        match findings.into_iter().map(|finding| finding.severity).max() {
            Some(Severity::Serious | Severity::Error) => Self::Unusable,
            Some(Severity::Warning) => Self::Doubtful,
            Some(Severity::Info) | None => Self::Good,
        }
    }

    /// Returns the verdict as a word.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Doubtful => "doubtful",
            Self::Unusable => "unusable",
        }
    }
}
