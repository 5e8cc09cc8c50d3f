//! What sprung noticed and the user should know: never hidden.

use serde::{Deserialize, Serialize};

/// The program and its version, as results name it.
pub const GENERATOR: &str = concat!("sprung ", env!("CARGO_PKG_VERSION"));

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
    /// The log is not what the experiment file says: what comes of it are not
    /// the parameters of this robot.
    Error,
}

impl Severity {
    /// Returns the severity as a word for people.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Info => "note",
            Self::Warning => "warning",
            Self::Serious => "serious",
            Self::Error => "error",
        }
    }
}

/// Where in a log something shows, and the number that shows it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// Name of the log.
    pub file: String,
    /// Name of the column, if it is about one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// Time of the sample, if it is at one, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_s: Option<f64>,
    /// What was measured, in `unit`.
    pub value: f64,
    /// Unit of the value; empty for counts and ratios.
    pub unit: String,
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
    /// Where it shows in a log, and by which number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evidence: Option<Evidence>,
    /// The line of `experiment.toml` that mends it, with its table.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub setting: Option<String>,
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
            evidence: None,
            setting: None,
        }
    }

    /// Returns the finding with the names of the parameters it is about.
    #[must_use]
    pub fn about(mut self, parameters: impl IntoIterator<Item = String>) -> Self {
        self.parameters.extend(parameters);
        self
    }

    /// Returns the finding with the number that shows it.
    ///
    /// - `column`: the column it is about, or an empty text; `unit`: of `value`.
    #[must_use]
    pub fn seen(mut self, file: &str, column: &str, value: f64, unit: &str) -> Self {
        self.evidence = Some(Evidence {
            file: file.to_owned(),
            column: (!column.is_empty()).then(|| column.to_owned()),
            time_s: None,
            // JSON has no infinity.
            value: value.clamp(f64::MIN, f64::MAX),
            unit: unit.to_owned(),
        });
        self
    }

    /// Returns the finding with the time at which it shows, s.
    #[must_use]
    pub fn at(mut self, time: f64) -> Self {
        if let Some(evidence) = &mut self.evidence {
            evidence.time_s = Some(time);
        }
        self
    }

    /// Returns the finding with the line of the experiment file that mends it:
    /// `key = value` in a table.
    #[must_use]
    pub fn mended_by(mut self, table: &str, line: &str) -> Self {
        self.setting = Some(format!("{table} {line}"));
        self
    }
}
