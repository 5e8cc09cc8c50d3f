//! What sprung noticed and the user should know: never an error, never hidden.

use serde::{Deserialize, Serialize};

/// How much a finding matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Worth knowing; the numbers stand.
    Info,
    /// Some numbers are not to be trusted.
    Warning,
    /// The result is of no use.
    Serious,
}

/// One finding.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// Stable name for scripts, as in `negative-stiffness`.
    pub code: String,
    /// How much it matters.
    pub severity: Severity,
    /// Names of the parameters it is about.
    #[serde(default)]
    pub parameters: Vec<String>,
    /// What was seen, with values and units, and what it likely means.
    pub text: String,
    /// What to do.
    pub remedy: String,
}

impl Finding {
    /// Returns a finding about no parameter in particular.
    #[must_use]
    pub fn new(severity: Severity, code: &str, text: String, remedy: &str) -> Self {
        Self {
            code: code.to_owned(),
            severity,
            parameters: Vec::new(),
            text,
            remedy: remedy.to_owned(),
        }
    }

    /// Returns the finding with the names of the parameters it is about.
    #[must_use]
    pub fn about(mut self, parameters: impl IntoIterator<Item = String>) -> Self {
        self.parameters.extend(parameters);
        self
    }
}
