//! Findings: observations that the user must know, with evidence and remedy.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Name and version of the program, as written into results.
pub const GENERATOR: &str = concat!("sprung ", env!("CARGO_PKG_VERSION"));

/// Severity of a finding.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// For information; all numbers are valid.
    Info,
    /// Some numbers are not reliable.
    Warning,
    /// The result is not usable.
    Serious,
    /// The log contradicts the experiment file, so the results are not the parameters of this
    /// robot.
    Error,
}

impl Severity {
    /// Returns the word for the severity in texts.
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

/// Place in a log that shows a finding, and its value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Evidence {
    /// Name of the log.
    pub file: String,
    /// Name of the column, if the finding concerns one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// Time of the sample, s, if the finding concerns one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_s: Option<f64>,
    /// Measured value, in `unit`.
    pub value: f64,
    /// Unit of the value; empty for counts and ratios.
    pub unit: String,
}

/// A finding.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Finding {
    /// Stable name for scripts, for example `impossible-robot`.
    pub code: String,
    /// Severity.
    pub severity: Severity,
    /// Names of the parameters concerned.
    #[serde(default)]
    #[schemars(extend("uniqueItems" = true))]
    pub parameters: Vec<String>,
    /// Observation with values and units, and its likely cause.
    pub text: String,
    /// Remedy.
    pub remedy: String,
    /// Evidence in a log.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evidence: Option<Evidence>,
    /// Table and line of `experiment.toml` that correct the cause.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub setting: Option<String>,
}

impl Finding {
    /// Returns a finding that concerns no particular parameter.
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

    /// Returns the finding with the names of the parameters concerned.
    #[must_use]
    pub fn about(mut self, parameters: impl IntoIterator<Item = String>) -> Self {
        self.parameters.extend(parameters);
        self
    }

    /// Returns the finding with its evidence.
    ///
    /// - `column`: the column concerned, or an empty text; `unit`: unit of `value`.
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

    /// Turns a warning into a note.
    pub fn note(&mut self) {
        self.severity = self.severity.min(Severity::Info);
    }

    /// Returns the finding with the time of its evidence, s.
    #[must_use]
    pub fn at(mut self, time: f64) -> Self {
        if let Some(evidence) = &mut self.evidence {
            evidence.time_s = Some(time);
        }
        self
    }

    /// Returns the finding with the line `key = value` of the experiment file that corrects the
    /// cause, and its table.
    #[must_use]
    pub fn mended_by(mut self, table: &str, line: &str) -> Self {
        self.setting = Some(format!("{table} {line}"));
        self
    }

    /// Completes the lines that correct the cause, in its texts as well; removes them where they cannot be completed.
    ///
    /// - `complete`: returns the lines with what the file says beside them.
    pub fn complete(&mut self, complete: impl Fn(&str) -> Option<String>) {
        let Some(before) = self.setting.take() else {
            return;
        };
        self.setting = complete(&before);
        let words = |setting: &str| {
            let lines = setting.split_once("] ").map_or(setting, |(_, lines)| lines);
            let bare = lines
                .lines()
                .map(|line| line.split("  #").next().unwrap_or(line));
            bare.collect::<Vec<&str>>().join(" and ")
        };
        if let Some(after) = &self.setting {
            for text in [&mut self.text, &mut self.remedy] {
                *text = text.replace(&words(&before), &words(after));
            }
        }
    }
}
