//! Least squares on the filtered regression.

use super::jackknife::{influences, scatter};
use super::motor_row::{MotorRow, Reduced, motor_row};
use super::residual::residual;
use super::unknowns::Free;
use crate::model::{Model, Theta};
use crate::regression::{System, Triangle, solve, solve_quickly};

/// Least residual of a row relative to the largest one; a log without noise has none.
const LEAST_RESIDUAL: f64 = 1e-9;

/// Limits of the number of jackknife groups; each group is a segment of the log.
const MAX_GROUPS: usize = 32;
const MIN_GROUPS: usize = 4;

/// How well data determine parameters together.
#[derive(Clone, Debug)]
pub struct Excitation {
    /// Participation of each parameter in the least excited direction, columns scaled to unit
    /// length.
    pub weakest_direction: Vec<f64>,
    /// Numerical rank, at most `unknowns`.
    pub rank: usize,
    /// Number of parameters that are not known.
    pub unknowns: usize,
    /// Ratio of the extreme singular values, without column scaling.
    pub condition_number: f64,
    /// Ratio of the extreme singular values, columns scaled to unit length.
    pub condition_number_scaled: f64,
}

/// A parameter vector with its uncertainty.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The parameter vector, known values included, \[p\].
    pub theta: Theta,
    /// Whether the data determine each parameter; true for known parameters.
    pub identifiable: Vec<bool>,
    /// Standard error of each parameter; zero for known parameters. A fit has only the sampling
    /// error; the errors below are added later.
    pub standard_error: Vec<f64>,
    /// Standard error by the disagreement of segments of the log.
    pub sampling_error: Vec<f64>,
    /// Deviation of each parameter between parts of the logs beyond their sampling errors.
    pub between_parts: Vec<f64>,
    /// Estimated size of the bias that all segments share.
    pub bias: Vec<f64>,
    /// How well the data determine the parameters together.
    pub excitation: Excitation,
    /// Half width of a 95 % interval, in standard errors.
    pub interval: f64,
    /// Solutions of the motor rows alone, one per flexible joint.
    pub motor_rows: Vec<MotorRow>,
    /// Weight of each row.
    pub(super) weights: Vec<f64>,
    /// Weighted factors of each row without the known parameters, segment by segment.
    pub(super) groups: Vec<Vec<Triangle>>,
}

impl Fitted {
    /// Returns the weight of each row, \[rows\].
    #[must_use]
    pub(crate) fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Adds errors that all segments of a log share to the standard errors.
    ///
    /// - `between_parts`, `bias`: standard deviations, \[p\]; zero for known parameters.
    #[must_use]
    pub(crate) fn widen(mut self, between_parts: Vec<f64>, bias: Vec<f64>) -> Self {
        for (i, error) in self.standard_error.iter_mut().enumerate() {
            *error = (self.sampling_error[i].hypot(between_parts[i])).hypot(bias[i]);
        }
        self.between_parts = between_parts;
        self.bias = bias;
        self
    }
}

/// Solves the stacked system and each motor row alone.
///
/// Returns `None` if there are no samples or a number is not finite.
///
/// Standard errors come from up to 32 segments of the log that are left out in turn, so they hold
/// for residuals of any colour and level. They measure the disagreement of the segments. They do
/// not contain a bias that all segments share, for example the bias of quantised positions in the
/// Coulomb transition.
///
/// - `memory`: time over which the filters correlate neighbouring residuals, s. No segment is
///   shorter, unless the log is shorter than four times this time.
///
/// # Source
///
/// Eq. (28).
#[must_use]
pub fn fit(model: &Model, system: &System, memory: f64) -> Option<Fitted> {
    fit_weighted(model, system, memory, vec![1.0; model.rows()])
}

/// Solves the system as [`fit`], with rows multiplied by weights, \[rows\].
#[must_use]
pub(crate) fn fit_weighted(
    model: &Model,
    system: &System,
    memory: f64,
    weights: Vec<f64>,
) -> Option<Fitted> {
    let free = Free::new(model);
    let whole = weighted(free.factors(system.whole()?), &weights);
    let groups: Vec<Vec<Triangle>> = (groups_for(system, memory))
        .into_iter()
        .map(|group| weighted(free.factors(group), &weights))
        .collect();
    let solution = solve(&free.parts(&whole), free.unknowns.len())?;
    let stacked = influences(&solution, &free.columns, &groups);
    let errors = scatter(&stacked);
    let reduced = Reduced {
        free: &free,
        whole: &whole,
        groups: &groups,
        stacked: &stacked,
    };
    let motor_rows = (0..model.joint_count())
        .filter(|&joint| model.is_flexible(joint))
        // A row whose parameters are all given has no solution of its own.
        .filter(|&joint| !free.columns[model.torque_row(joint)].is_empty())
        .map(|joint| motor_row(model, joint, system, &reduced))
        .collect::<Option<_>>()?;
    Some(Fitted {
        theta: free.whole(&solution.x, |value| value),
        identifiable: free.whole(&solution.identifiable, |_| true),
        standard_error: free.whole(&errors, |_| 0.0),
        sampling_error: free.whole(&errors, |_| 0.0),
        between_parts: vec![0.0; model.parameters().len()],
        bias: vec![0.0; model.parameters().len()],
        excitation: Excitation {
            weakest_direction: free.whole(&solution.weakest_direction, |_| 0.0),
            rank: solution.rank,
            unknowns: free.unknowns.len(),
            condition_number: solution.condition_number,
            condition_number_scaled: solution.condition_number_scaled,
        },
        interval: student_95(groups.len().saturating_sub(1)),
        motor_rows,
        weights,
        groups,
    })
}

/// Returns the factors of each row of the segments that are left out in turn.
///
/// - `memory`: as for [`fit`].
pub(crate) fn groups_for(system: &System, memory: f64) -> Vec<Vec<Triangle>> {
    let count = (system.duration() / memory) as usize;
    system.groups(count.clamp(MIN_GROUPS, MAX_GROUPS))
}

/// Returns the factors of rows that are multiplied by weights.
pub(super) fn weighted(factors: Vec<Triangle>, weights: &[f64]) -> Vec<Triangle> {
    (factors.into_iter().zip(weights))
        .map(|(factor, weight)| factor.scaled(*weight))
        .collect()
}

/// Returns the weight of each row for which residuals of all joints count the same, \[rows\]: the reciprocal of the
/// residual of the joint's torque row. Link rows without a right-hand side have the weight of their motor, because a
/// row with a right-hand side of zero and a separate weight would shrink the parameters.
///
/// - `theta`: an estimate, \[p\].
#[must_use]
pub(crate) fn row_weights(model: &Model, system: &System, theta: &[f64]) -> Vec<f64> {
    let residuals = residual(model, system, theta);
    let largest = residuals.iter().map(|row| row.0).fold(0.0, f64::max);
    let n = model.joint_count();
    (residuals.iter().enumerate())
        .map(|(row, (residual, right))| {
            let has_scale = *right > 0.0 || row >= n;
            let residual = if has_scale {
                *residual
            } else {
                residuals[model.torque_row(row)].0
            };
            if largest > 0.0 {
                residual.max(LEAST_RESIDUAL * largest).recip()
            } else {
                1.0
            }
        })
        .collect()
}

/// Returns the parameter vector alone, \[p\]; `None` if the data do not determine all parameters.
#[must_use]
pub(crate) fn fit_quickly(model: &Model, system: &System) -> Option<Theta> {
    let free = Free::new(model);
    let whole = free.factors(system.whole()?);
    let x = solve_quickly(&free.parts(&whole), free.unknowns.len())?;
    Some(free.whole(&x, |value| value))
}

/// Returns the parameter vector alone, \[p\]. If the data do not determine it, this is the shortest
/// solution with columns scaled to unit length.
#[must_use]
pub(crate) fn fit_values(model: &Model, system: &System) -> Option<Theta> {
    let free = Free::new(model);
    let whole = free.factors(system.whole()?);
    let (parts, unknowns) = (free.parts(&whole), free.unknowns.len());
    let x = match solve_quickly(&parts, unknowns) {
        Some(x) => x,
        None => solve(&parts, unknowns)?.x,
    };
    Some(free.whole(&x, |value| value))
}

/// Returns the 97.5 % quantile of Student's t, accurate within 1 % for three or more degrees of
/// freedom, infinite for fewer.
///
/// # Source
///
/// Cornish-Fisher expansion about the normal quantile.
pub(crate) fn student_95(freedom: usize) -> f64 {
    if freedom < 3 {
        return f64::INFINITY;
    }
    let (z, n) = (1.959_964_f64, freedom as f64);
    let first = (z.powi(3) + z) / 4.0;
    let second = (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0;
    let third = (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0;
    z + first / n + second / n.powi(2) + third / n.powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn student_quantiles_match_tables() {
        for (freedom, expected) in [(3, 3.182), (6, 2.447), (16, 2.120), (31, 2.040)] {
            // The series is worst at 3 degrees of freedom, where its error is 0.7 %.
            assert!(
                (student_95(freedom) / expected - 1.0).abs() < 0.01,
                "{freedom}"
            );
        }
        assert!(student_95(2).is_infinite());
    }
}
