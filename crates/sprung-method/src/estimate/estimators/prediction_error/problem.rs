//! The minimisation problem of a descent.

use super::filter::NormalEquations;
use super::levels::{Levels, UnknownLevels};
use super::measurements::Measurements;
use super::residual_ratio::Guard;
use super::unknowns::Unknowns;
use crate::estimate::possible::Robots;
use crate::model::Model;

/// Model, measurements and unknowns of a descent.
#[derive(Clone, Copy)]
pub(super) struct Problem<'a> {
    pub(super) model: &'a Model,
    pub(super) measurements: &'a Measurements,
    pub(super) unknowns: &'a Unknowns,
    pub(super) levels: &'a UnknownLevels,
    /// Rows whose logged torque has noise.
    pub(super) noisy_rows: &'a [usize],
    /// Comparison with least squares, from which the descent starts; `None` without a comparison.
    pub(super) guard: Option<&'a Guard<'a>>,
    /// The robots that can exist; `None` without constraints.
    pub(super) robots: Option<&'a Robots<'a>>,
}

impl Problem<'_> {
    /// Returns the noise of the logged torque, as far as it biases the gradient, N·m (N), \[rows\].
    ///
    /// White noise of the torque also covers effects that the model lacks, which cause no bias. So
    /// it counts up to the white noise that the log shows.
    pub(super) fn logged_noise(&self, levels: &Levels) -> Vec<f64> {
        let noises = levels
            .torque_noise
            .iter()
            .zip(&self.measurements.fast_noise);
        (noises.enumerate())
            .map(|(row, (noise, fast))| {
                if self.noisy_rows.contains(&row) {
                    noise.min(*fast)
                } else {
                    0.0
                }
            })
            .collect()
    }

    /// Returns the cost of the priors.
    pub(super) fn prior_cost(&self, z: &[f64]) -> f64 {
        (self.unknowns.priors())
            .map(|prior| ((z[prior.at] - prior.mean) / prior.deviation).powi(2))
            .sum()
    }

    /// Returns whether the parameters can be those of a robot. The mass matrix is not checked.
    pub(super) fn is_feasible(&self, z: &[f64]) -> bool {
        let parameters = self.model.parameters();
        let vital = self.unknowns.free.iter().zip(z).all(|(&index, value)| {
            let vital = parameters[index].joint.is_some_and(|(kind, joint)| {
                // The inertia of a rigid joint's rotor may be counted with its link.
                kind.is_vital() && self.model.is_flexible(joint)
            });
            value.is_finite() && (!vital || *value > 0.0)
        });
        vital && self.unknowns.has_near_scales(z)
    }
}

/// Adds the priors to the normal equations, and returns their cost.
pub(super) fn add_prior(unknowns: &Unknowns, z: &[f64], normal: &mut NormalEquations) -> f64 {
    let mut cost = 0.0;
    for prior in unknowns.priors() {
        let weight = prior.deviation.powi(-2);
        let away = z[prior.at] - prior.mean;
        normal.information[prior.at * (normal.count + 1)] += weight;
        normal.gradient[prior.at] += weight * away;
        cost += weight * away * away;
    }
    cost
}
