//! The verdict on a result, as one word.

use serde::{Deserialize, Serialize};

use crate::finding::{Finding, Severity};

/// Decision on a result, with its evidence.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Decision {
    /// The decision in words.
    pub sentence: String,
    /// Codes of the findings that decided, the most severe first.
    pub findings: Vec<String>,
    /// Names of the parameters that are not to be trusted alone.
    pub parameters: Vec<String>,
}

/// Verdict on a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// No warnings.
    Good,
    /// At least one number has a warning.
    Doubtful,
    /// A serious finding: for example, an inertia or a stiffness is impossible or unknown.
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
