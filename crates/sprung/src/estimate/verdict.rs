//! How far to trust a result, as one word.

use serde::{Deserialize, Serialize};

use crate::finding::{Finding, Severity};

/// How far to trust a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// No warnings.
    Good,
    /// Some numbers carry a warning.
    Doubtful,
    /// An inertia or a stiffness is impossible or unknown.
    Unusable,
}

impl Verdict {
    /// Returns the verdict that findings lead to: one that is serious makes a
    /// result unusable, a warning makes it doubtful.
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
