//! The contents of `comparison.json`.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::Serialize;

use super::dates::minute;
use super::drift_result::Drift;
use super::promises::ComparedPromise;
use crate::estimate::{ErrorParts, SettingsUsed, Verdict};
use crate::finding::Finding;
use crate::model::short;
use crate::named::Named;

/// The compared results; format 1.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Comparison {
    /// Version of the file format; 1.
    pub format: u32,
    /// Program and version that wrote the file.
    pub generator: String,
    /// The compared results, in the order of the dates of their logs if all logs have one; differences refer to the
    /// first result.
    pub compared: Vec<ComparedResult>,
    /// All parameters of all results, in the order of the first result.
    pub parameters: Vec<ComparedParameter>,
    /// Results of one estimator from different logs of one robot, combined; absent without such results.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub combined: Vec<CombinedResult>,
    /// Drift of each estimator with at least four results from different logs; absent without such results.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub drift: Vec<Drift>,
    /// Number of tests for agreement between repeated results: one per parameter and estimator.
    pub tested: usize,
    /// Findings of the comparison.
    pub findings: Vec<Finding>,
    /// Promises of validations; absent without validations.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub promises: Vec<ComparedPromise>,
    /// How often promises were kept, in words; absent without validations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub promises_kept: Option<String>,
}

/// Code of the finding about disagreeing results.
pub const RUNS_DISAGREE: &str = "runs-disagree";

impl Comparison {
    /// Returns whether the results agree, in one sentence; `None` without two results.
    #[must_use]
    pub fn conclusion(&self) -> Option<String> {
        let results = self.compared.len();
        if results < 2 {
            return None;
        }
        let tested = self.tested;
        let apart: Vec<Cow<'_, str>> = (self.findings.iter())
            .filter(|finding| finding.code == RUNS_DISAGREE)
            .flat_map(|finding| &finding.parameters)
            .map(|name| short(name))
            .collect();
        Some(if tested == 0 {
            format!(
                "No estimator has two of the {results} results with intervals, so sprung shows the differences and \
                 does not test them."
            )
        } else if apart.is_empty() {
            format!(
                "The results agree: in no of {tested} tests of repeated results does a parameter differ by more than \
                 its intervals allow."
            )
        } else {
            format!(
                "The results disagree: {} of {tested} tests of repeated results find a parameter that differs by more \
                 than its intervals allow ({}).",
                apart.len(),
                apart.join(", ")
            )
        })
    }
}

/// Origin of the values in one column.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ComparedResult {
    /// A short, unique name.
    pub label: String,
    /// The file that was read.
    pub file: String,
    /// Name of the robot.
    pub robot: String,
    /// Names of the logs.
    pub log: String,
    /// Beginning of the first log, s since 1970; absent if its times are not dates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub date_s: Option<f64>,
    /// Number of samples of all logs.
    pub samples: u64,
    /// Duration of all logs, s.
    pub duration_s: f64,
    /// Program and version that made the identification.
    pub generator: String,
    /// Settings of the identification.
    pub settings: SettingsUsed,
    /// Laws beyond the description, as `joint1: motor_friction "stribeck"`.
    #[serde(default)]
    pub laws: Vec<String>,
    /// Name of the estimator.
    pub estimator: String,
    /// Trustworthiness of the result.
    pub verdict: Verdict,
    /// Condition number with columns scaled to unit length; absent if infinite.
    pub condition_number_scaled: Option<f64>,
    /// Residual of each row, root mean square, N·m (N).
    pub residual_rms: Named,
    /// Residual over torque in each row with a torque, root mean squares.
    pub relative_residual: Named,
    /// Codes of the result's warnings and serious findings.
    pub findings: Vec<String>,
    /// Duration of the estimation, s.
    pub elapsed_s: f64,
}

impl ComparedResult {
    /// Returns the date of the logs as `2026-01-31 17:05`, in their time zone; `None` without a date.
    #[must_use]
    pub fn date(&self) -> Option<String> {
        self.date_s.map(minute)
    }
}

/// One parameter in all results.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ComparedParameter {
    /// Name of the parameter.
    pub name: String,
    /// The paper's symbol.
    pub symbol: String,
    /// Unit.
    pub unit: String,
    /// One entry per result; `None` if the result does not have the parameter.
    pub values: Vec<Option<ComparedValue>>,
}

/// One parameter in one result.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ComparedValue {
    /// Estimate; absent if the log does not determine it.
    pub value: Option<f64>,
    /// Standard error.
    pub standard_error: Option<f64>,
    /// 95 % confidence interval.
    pub ci95: Option<[f64; 2]>,
    /// Whether the value was given.
    pub fixed: bool,
    /// Difference from the first result, percent of the first result's value.
    pub difference_percent: Option<f64>,
    /// Difference from the first result over the root of the sum of both squared standard errors,
    /// which is valid for independent errors.
    pub difference_standard_errors: Option<f64>,
}

/// Results of one estimator from different logs of one robot, combined.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "Combined")]
pub struct CombinedResult {
    /// Name of the estimator.
    pub estimator: String,
    /// Labels of the combined results.
    pub results: Vec<String>,
    /// Parameters that at least two results determine with an interval.
    pub parameters: Vec<CombinedParameter>,
}

/// One parameter from several results.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CombinedParameter {
    /// Name of the parameter.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Number of results with an interval.
    pub results: usize,
    /// Mean, weighted by the information of each result.
    pub value: f64,
    /// Standard error of the mean.
    pub standard_error: f64,
    /// 95 % confidence interval.
    pub ci95: [f64; 2],
    /// Contributions to the standard error: the independent errors of the results, the deviation between
    /// the results beyond their errors, and the bias, which combining does not reduce.
    pub error_parts: ErrorParts,
    /// Sum of the squared distances from the mean over the squared standard errors, chi-square if the
    /// results agree.
    pub chi_square: f64,
    /// Its degrees of freedom.
    pub freedom: usize,
    /// Probability of at least this sum if the results agree.
    pub probability: f64,
    /// Part of the scatter that the standard errors do not explain (I²), percent.
    pub i_squared_percent: f64,
}
