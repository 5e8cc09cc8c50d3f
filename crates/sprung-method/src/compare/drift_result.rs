//! The drift of a robot in `comparison.json`.

use schemars::JsonSchema;
use serde::Serialize;

use super::dates::{SECONDS_PER_DAY, day};
use crate::model::short;

/// Code of the finding about a parameter that drifts.
pub const PARAMETER_DRIFTS: &str = "parameter-drifts";

/// The results of one estimator from different logs of one robot over time.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "DriftOverTime")]
pub struct Drift {
    /// Name of the estimator.
    pub estimator: String,
    /// Labels of the results, from the first to the last.
    pub results: Vec<String>,
    /// Time of each result: days since the first log, or the number of the run, from 1.
    pub times: Vec<f64>,
    /// Unit of the times: `d`, or `run` if the order is that in which the results were given.
    pub time_unit: String,
    /// Date of the first log, s since 1970; absent if the order is that in which the results were given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from_date_s: Option<f64>,
    /// Label of a result whose logs have no date, the reason for that order.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub without_date: Option<String>,
    /// The tested parameters: those that at least four results determine with an interval.
    pub parameters: Vec<ParameterDrift>,
}

/// A line through the estimates of one parameter over time.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "DriftOfParameter")]
pub struct ParameterDrift {
    /// Name of the parameter.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Number of results with an interval.
    pub results: usize,
    /// Times of the first and the last of them, in the unit of the times.
    pub span: [f64; 2],
    /// Value of the line at the first of them.
    pub first: f64,
    /// Change of the line from the first to the last of them.
    pub change: f64,
    /// Standard error of the change, by the scatter of the results and their errors without the bias that all share.
    pub standard_error: f64,
    /// Change in percent of the value at the first; absent if this value is not significant.
    pub change_percent: Option<f64>,
    /// Standard error of the change in percent of the value at the first.
    pub standard_error_percent: Option<f64>,
    /// Change per day; absent without dates.
    pub change_per_day: Option<f64>,
    /// Standard deviation of the results about the line beyond these errors.
    pub between_runs: f64,
    /// Degrees of freedom of Student's t.
    pub freedom: usize,
    /// Probability of at least this change if the parameter does not drift.
    pub probability: f64,
    /// The same, adjusted for the number of tested parameters.
    pub adjusted_probability: f64,
    /// Whether the parameter drifts: the adjusted probability is below 1 %.
    pub drifts: bool,
}

impl Drift {
    /// Returns the parameters that drift.
    pub fn drifting(&self) -> impl Iterator<Item = &ParameterDrift> {
        self.parameters.iter().filter(|parameter| parameter.drifts)
    }

    /// Returns the results and their order in words: `10 runs from 2026-01-05 to 2026-02-01`.
    #[must_use]
    pub fn runs(&self) -> String {
        let count = self.results.len();
        match (self.from_date_s, self.times.last()) {
            (Some(from), Some(days)) => {
                let to = SECONDS_PER_DAY.mul_add(*days, from);
                format!("{count} runs from {} to {}", day(from), day(to))
            }
            _ => format!("{count} runs in the order given"),
        }
    }

    /// Returns whether parameters drift, in one sentence.
    #[must_use]
    pub fn conclusion(&self) -> String {
        let order = match &self.without_date {
            Some(label) => format!(", because the logs of {label} have no dates"),
            None => String::new(),
        };
        let drifting: Vec<String> = (self.drifting())
            .map(|parameter| format!("{} {}", short(&parameter.name), parameter.in_words()))
            .collect();
        let (tested, estimator, runs) = (self.parameters.len(), &self.estimator, self.runs());
        if drifting.is_empty() {
            format!("None of {tested} parameters of {estimator} drifts over {runs}{order}.")
        } else {
            format!(
                "{} of {tested} parameters of {estimator} {} over {runs}{order}: {}.",
                drifting.len(),
                if drifting.len() == 1 {
                    "drifts"
                } else {
                    "drift"
                },
                drifting.join(", ")
            )
        }
    }
}

impl ParameterDrift {
    /// Returns the change with its standard error in words: `-5.1 % ± 0.4 %`.
    #[must_use]
    pub fn in_words(&self) -> String {
        match self.change_percent.zip(self.standard_error_percent) {
            Some((change, error)) => format!("{change:+.2} % ± {error:.2} %"),
            None => format!(
                "{:+.2e} ± {:.1e} {}",
                self.change, self.standard_error, self.unit
            ),
        }
    }
}
