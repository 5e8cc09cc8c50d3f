//! The prior of drives, sensors and other parameters that are no bodies.

use sprung_core::parameters::JointParameter;

use super::errors::PosteriorError;
use super::evidence::Evidence;
use crate::description::Physical;
use crate::estimate::possible::Robots;
use crate::estimate::result::{EstimateResult, ParameterEstimate};

/// Error of a zero value that the log does not determine, in its unit: the value hardly changes.
const SMALLEST_ERROR: f64 = 1e-9;

/// The other unknowns, and the parameters that the log does not determine.
pub(super) struct Rest {
    /// Most likely value and its error by the prior, of each other unknown.
    pub(super) others: Vec<[f64; 2]>,
    pub(super) undetermined: Vec<String>,
}

impl Rest {
    pub(super) fn new(
        robots: &Robots<'_>,
        settings: &Physical,
        result: &EstimateResult,
        evidence: &Evidence,
    ) -> Result<Self, PosteriorError> {
        let parameters = robots.model.parameters();
        let is_known = |index: usize| evidence.known.contains(&index);
        let mut names = Vec::new();
        let others = (robots.others.iter())
            .map(|&index| {
                let parameter = &parameters[index];
                let estimate = result.parameter(&parameter.name);
                let value = estimate.and_then(|estimate| estimate.value.or(estimate.physical));
                // The offset of a sensor is not a property of the robot.
                let is_offset = matches!(parameter.joint, Some((JointParameter::TorqueOffset, _)));
                let value = (value.or(parameter.nominal)).or(is_offset.then_some(0.0));
                if value.is_none() && !is_known(index) {
                    names.push(parameter.name.clone());
                }
                let value = value.unwrap_or(0.0);
                if is_known(index) {
                    // The log's distribution takes the place of this one.
                    let error = estimate.and_then(ParameterEstimate::error_by_equations);
                    return [value, error.unwrap_or(1.0)];
                }
                [
                    value,
                    (settings.prior_error * value.abs()).max(SMALLEST_ERROR),
                ]
            })
            .collect();
        if !names.is_empty() {
            return Err(PosteriorError::NoValue { names });
        }
        let undetermined = (parameters.iter().enumerate())
            .filter(|(index, parameter)| parameter.fixed.is_none() && !is_known(*index))
            .map(|(_, parameter)| parameter.name.clone());
        Ok(Self {
            others,
            undetermined: undetermined.collect(),
        })
    }
}
