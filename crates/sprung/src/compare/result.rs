//! The contents of `comparison.json`.

use serde::Serialize;

use crate::estimate::{SettingsUsed, Verdict};
use crate::finding::Finding;
use crate::named::Named;

/// Results side by side; format 1.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Version of the file format; 1.
    pub format: u32,
    /// Program and version that wrote it.
    pub generator: String,
    /// The results that are compared; the others differ from the first.
    pub compared: Vec<ComparedResult>,
    /// Every parameter that one of them has, in the order of the first.
    pub parameters: Vec<ComparedParameter>,
    /// Number of parameters, over all estimators, whose repeated results were
    /// tested for agreement.
    pub tested: usize,
    /// What was noticed.
    pub findings: Vec<Finding>,
}

/// Where the values of one column come from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComparedResult {
    /// A short name that no other result here has.
    pub label: String,
    /// The file that was read.
    pub file: String,
    /// Name of the robot.
    pub robot: String,
    /// The logs.
    pub log: String,
    /// Number of samples of all logs.
    pub samples: u64,
    /// Time that the logs last, s.
    pub duration_s: f64,
    /// Program and version that identified.
    pub generator: String,
    /// The settings that were used.
    pub settings: SettingsUsed,
    /// Name of the estimator.
    pub estimator: String,
    /// How far to trust it.
    pub verdict: Verdict,
    /// Condition number after scaling columns to unit length; absent if
    /// infinite.
    pub condition_number_scaled: Option<f64>,
    /// Residual of each row, root mean square, N·m (N).
    pub residual_rms: Named,
    /// Residual over torque of each row that has a torque.
    pub relative_residual: Named,
    /// Codes of its warnings and serious findings.
    pub findings: Vec<String>,
    /// Time that the estimate took, s.
    pub elapsed_s: f64,
}

/// One parameter in all results.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComparedParameter {
    /// Name.
    pub name: String,
    /// The paper's symbol.
    pub symbol: String,
    /// Unit.
    pub unit: String,
    /// One entry per result; nothing where the robot does not have it.
    pub values: Vec<Option<ComparedValue>>,
}

/// One parameter in one result.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ComparedValue {
    /// Estimate; absent if the log does not determine it.
    pub value: Option<f64>,
    /// Standard error.
    pub standard_error: Option<f64>,
    /// 95 % confidence interval.
    pub ci95: Option<[f64; 2]>,
    /// Whether it was given.
    pub fixed: bool,
    /// Difference from the first result, percent of its value there.
    pub difference_percent: Option<f64>,
    /// The same over both standard errors, squared and added, which takes
    /// the errors for independent.
    pub difference_standard_errors: Option<f64>,
}
