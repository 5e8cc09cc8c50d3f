//! Results of a check, the contents of `check.json`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use crate::curves::Curves;
use crate::description::Window;
use crate::finding::{Finding, Severity};
use crate::unknowns::UnknownResult;

/// Figures and findings of a check.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CheckReport {
    /// Version of the file format.
    pub format: u32,
    /// Program and version that wrote the file.
    pub generator: String,
    /// Name of the robot.
    pub robot: String,
    /// The logs, in the given order.
    pub logs: Vec<CheckedLog>,
    /// Figures of the joints, from the beginning of the first log.
    pub joints: Vec<JointFigures>,
    /// What differs from the description by a size that the beginning of the first log shows.
    pub unknowns: Vec<UnknownResult>,
    /// Whether there is an error; `identify` refuses a log with an error.
    pub refused: bool,
    /// Number of findings of each severity.
    pub counts: BTreeMap<String, usize>,
    /// Findings, worst first.
    pub findings: Vec<Finding>,
}

impl CheckReport {
    /// Counts the findings of each severity.
    pub(super) fn count(&mut self) {
        self.counts.clear();
        for finding in &self.findings {
            let word = finding.severity.word().to_owned();
            *self.counts.entry(word).or_insert(0) += 1;
        }
    }

    /// Returns the worst severity of the findings.
    #[must_use]
    pub fn worst(&self) -> Option<Severity> {
        self.findings.iter().map(|finding| finding.severity).max()
    }
}

/// Figures of one log.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CheckedLog {
    /// File as opened.
    pub file: String,
    /// Window of the file; absent for the whole file.
    #[serde(skip_serializing_if = "Window::is_whole")]
    pub window: Window,
    /// Number of samples.
    pub samples: u64,
    /// Sampling period, s.
    pub period_s: f64,
    /// Sampling rate, Hz.
    pub rate_hz: f64,
    /// Time between the first and the last sample, s.
    pub duration_s: f64,
    /// Largest deviation of a step from the period, percent.
    pub jitter_percent: f64,
    /// Times of the samples: `even`, `on-cycle` or `as-stamped`.
    pub sampling: String,
    /// Number of samples that were interpolated onto even times.
    pub interpolated: u64,
    /// Number of missing samples, outside gaps.
    pub dropped: u64,
    /// Number of duplicate samples.
    pub repeated: u64,
    /// Number of samples left out because a column has no value.
    pub without_value: u64,
    /// Number of samples that repeat all values of the previous one although a joint moves.
    pub frozen: u64,
    /// Number of gaps.
    pub gaps: u64,
    /// Duration of all gaps, s.
    pub gap_duration_s: f64,
    /// Columns, in the order of the joints: links, motors, torques.
    pub columns: Vec<ColumnFigures>,
}

impl CheckedLog {
    /// Returns its file with its window, for messages.
    #[must_use]
    pub fn name(&self) -> String {
        self.window.of(&self.file)
    }
}

impl ColumnFigures {
    /// Returns the name of the column, and the name in the file that a pattern matched.
    #[must_use]
    pub fn label(&self) -> String {
        match &self.matched {
            None => self.column.clone(),
            Some(matched) => format!("{} = {matched}", self.column),
        }
    }
}

/// Figures of one column.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "CheckedColumn")]
pub struct ColumnFigures {
    /// Name of the column.
    pub column: String,
    /// Name of the column in the file, if a pattern matched it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub matched: Option<String>,
    /// Quantity, as a key of `[log]`.
    pub quantity: String,
    /// Name of the joint.
    pub joint: String,
    /// Unit of the following values.
    pub unit: String,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Mean.
    pub mean: f64,
    /// Standard deviation about the mean.
    pub deviation: f64,
    /// Standard deviation of the noise, from the beginning of the log.
    pub noise: Option<f64>,
    /// Step between values, if the column is quantised.
    pub step: Option<f64>,
    /// Bits of an ideal converter with the same range and noise.
    pub effective_bits: Option<f64>,
    /// Longest time with a constant value, s.
    pub longest_still_s: f64,
}

/// Figures of one joint.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct JointFigures {
    /// Name of the joint.
    pub joint: String,
    /// Slope of motor over link position, if both are logged.
    pub slope: Option<f64>,
    /// Percentage of the squared filtered torque that the motion explains.
    pub explained_percent: f64,
    /// Stiffness from the motor row alone, N·m/rad (N/m).
    pub stiffness: Option<f64>,
}

/// Results of a check with curves for the report.
#[derive(Clone, Debug)]
pub struct Checked {
    /// The figures and findings.
    pub report: CheckReport,
    /// Each column over the first log: a set `smallest` and a set `largest`.
    pub overview: Curves,
    /// Samples around the places of findings, one entry per finding with a place in the excerpt.
    pub places: Vec<FindingSamples>,
}

/// Samples around the place of a finding.
#[derive(Clone, Debug, PartialEq)]
pub struct FindingSamples {
    /// Index of the finding in [`CheckReport::findings`].
    pub finding: usize,
    /// Name of the column.
    pub column: String,
    /// Unit of the values.
    pub unit: String,
    /// Time, s.
    pub time: Vec<f64>,
    /// Values.
    pub values: Vec<f64>,
}
