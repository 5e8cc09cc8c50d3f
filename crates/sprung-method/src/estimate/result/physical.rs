//! Possible bodies in the form of the files.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::named::Named;

/// One inertial parameter of a single link, or the inertia of a rotor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StandardParameter {
    /// Name, as in `link1.izz`.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Value, of a body that can exist.
    pub value: f64,
    /// Standard error by the log and by the error of the nominal values; absent for a given value.
    #[serde(default)]
    pub standard_error: Option<f64>,
    /// Nominal value.
    pub nominal: Option<f64>,
    /// What decided the value.
    pub decided: Decided,
    /// Part of the prior's variance that the log removed, 0 to 1.
    #[serde(default)]
    pub share_of_log: f64,
}

/// What decided a standard parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Decided {
    /// The log removed most of the variance of the prior.
    Log,
    /// The log and the nominal values.
    Both,
    /// The nominal values: the log says hardly anything.
    Nominal,
    /// Nothing: there is no nominal value, and the log contains hardly any information.
    Nothing,
    /// The experiment gives the value.
    Given,
}

/// The program that found possible bodies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PhysicalResult {
    /// `nominal` if at least one link has a possible nominal body, else `none`.
    pub prior: String,
    /// Distance from the nominal bodies: `entropic` or `euclidean`.
    pub distance: String,
    /// Relative error of the nominal values.
    pub prior_error: f64,
    /// Distance of the possible values from the estimate, in standard errors, along all parameters.
    pub moved_standard_errors: f64,
    /// Residual of each torque row with the possible values over that with the estimate.
    pub residual_ratio: Named,
    /// Links whose nominal bodies cannot exist. They have no prior.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub impossible_nominal: Vec<String>,
}

/// Covariance of the errors of parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CovarianceOfErrors {
    /// Names of the parameters, one per row.
    pub parameters: Vec<String>,
    /// The lower triangle, row by row, in the products of the units of the parameters.
    pub values: Vec<Vec<f64>>,
}

impl CovarianceOfErrors {
    /// Returns the variance of a weighted sum of the parameters that have a weight.
    pub(crate) fn of_sum(&self, weight: impl Fn(&str) -> Option<f64>) -> f64 {
        let chosen: Vec<(usize, f64)> = (self.parameters.iter().enumerate())
            .filter_map(|(i, name)| Some((i, weight(name)?)))
            .collect();
        let entry = |i: usize, j: usize| self.values[i.max(j)][i.min(j)];
        let rows = chosen.iter();
        rows.map(|&(i, of)| {
            let row = chosen.iter();
            row.map(|&(j, other)| of * other * entry(i, j)).sum::<f64>()
        })
        .sum()
    }
}
