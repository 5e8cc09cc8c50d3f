//! The Levenberg-Marquardt method with forward differences.

use crate::estimate::estimators::damping::{Damping, MAX_TRIES};
use crate::estimate::statistics::{MAX_ITERATIONS, MIN_COST_SAVED, SHORT_STEP_SIGMAS};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use rayon::prelude::*;
use sprung_core::linear::dot;

/// Maximum relative error of the predicted decrease of the cost for which the next iteration reuses
/// the derivatives. New derivatives cost one simulation per unknown.
const MAX_PREDICTION_ERROR: f64 = 0.3;

/// Mean squared residual above which the simulated loop differs from the real one. Above it the
/// search ends if a step lowers the cost by less than the given fraction.
pub(super) const FAILED_FIT_COST: f64 = 25.0;

/// Relative decrease of the cost below which the search for a differing loop stops.
const MIN_COST_DECREASE_SHARE: f64 = 1e-3;

/// Damping below which the remaining distance is the step times the relative error of the predicted
/// decrease. Above it the remaining distance is the whole step.
const NEGLIGIBLE_DAMPING: f64 = 3e-5;

/// Difference step of the derivatives, in standard errors of the unknown.
const DIFFERENCE_STEP_SIGMAS: f64 = 0.5;

/// Residuals as a function of the unknowns; `None` where they cannot be computed.
type Residuals<'a> = Box<dyn Fn(&[f64]) -> Option<Vec<f64>> + Sync + 'a>;

/// A problem of nonlinear least squares.
pub(super) struct Problem<'a> {
    /// Residuals divided by the standard deviation of their noise.
    pub(super) residuals: Residuals<'a>,
    /// Start values, \[m\].
    pub(super) start: Vec<f64>,
    /// Difference steps of the first derivatives and lower limits of the later ones, \[m\].
    pub(super) first: Vec<f64>,
    /// Upper limits of the difference steps, \[m\].
    pub(super) largest: Vec<f64>,
    /// Inverse standard deviation of each unknown about zero; 0 for an unknown without a prior,
    /// \[m\].
    pub(super) prior: Vec<f64>,
}

/// Reason why a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ending {
    /// The search reached a minimum.
    Converged,
    /// The search reached the maximum number of iterations.
    Limit,
    /// No step lowered the cost, although the derivatives predict a decrease.
    Stuck,
}

/// Result of a search.
pub(super) struct Found {
    /// The unknowns, \[m\].
    pub(super) x: Vec<f64>,
    /// Residuals at `x`.
    pub(super) residuals: Vec<f64>,
    /// Derivatives of the residuals at the last evaluation, one column per unknown.
    pub(super) jacobian: Vec<Vec<f64>>,
    /// `JᵀJ` plus the prior, \[m × m\].
    pub(super) normal: Mat<f64>,
    /// Sum of the squared residuals.
    pub(super) cost: f64,
    /// Number of iterations.
    pub(super) iterations: usize,
    /// Reason why the search ended.
    pub(super) ending: Ending,
    /// The unknown with the largest change in the last step, in standard errors.
    pub(super) moved: usize,
}

/// The residuals cannot be computed at the start or next to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct NoStart;

/// Minimises the sum of squares of the residuals and the prior.
///
/// The columns of the derivatives are computed in parallel. The number of threads does not change
/// the result.
pub(super) fn minimise(problem: &Problem<'_>) -> Result<Found, NoStart> {
    let mut x = problem.start.clone();
    let mut residuals = (problem.residuals)(&x).ok_or(NoStart)?;
    let mut steps = problem.first.clone();
    let mut damping = Damping::first();
    let (mut moved, mut ending) = (0, Ending::Limit);
    let mut kept: Option<(Vec<Vec<f64>>, Mat<f64>)> = None;
    let mut evaluated = 0;
    for iteration in 1.. {
        let fresh = kept.is_none();
        let (jacobian, normal) = if let Some(kept) = kept.take() {
            kept
        } else {
            evaluated += 1;
            let jacobian = differences(problem, &x, &residuals, &steps).ok_or(NoStart)?;
            let normal = normal_matrix(problem, &jacobian);
            (jacobian, normal)
        };
        let gradient = gradient(problem, &jacobian, &residuals, &x);
        let cost = total(problem, &residuals, &x);
        let unit = (cost / residuals.len() as f64).max(f64::MIN_POSITIVE);
        let mut accepted = None;
        for _ in 0..if fresh { MAX_TRIES } else { 1 } {
            if let Some(step) = damped(&normal, &gradient, damping.value()) {
                let next: Vec<f64> = x.iter().zip(&step).map(|(x, d)| x + d).collect();
                let found = (problem.residuals)(&next);
                if let Some(r) = found.filter(|r| total(problem, r, &next) < cost) {
                    accepted = Some((next, r, step));
                    break;
                }
            }
            if fresh {
                damping.failed();
            }
        }
        let (mut arrived, mut good) = (false, false);
        match accepted {
            // A failed step with reused derivatives is no evidence of a minimum.
            None if !fresh => {}
            None => {
                // Rounding and the tolerance of the simulation mask a smaller predicted decrease.
                let promised = damped(&normal, &gradient, 0.0)
                    .map_or(f64::INFINITY, |step| -dot(&step, &gradient));
                ending = if promised < MIN_COST_SAVED.sqrt() * unit * x.len() as f64 {
                    Ending::Converged
                } else {
                    Ending::Stuck
                };
            }
            Some((next, r, step)) => {
                let errors = |i: usize| step[i].abs() * normal[(i, i)].sqrt();
                moved = (0..x.len())
                    .max_by(|&a, &b| errors(a).total_cmp(&errors(b)))
                    .unwrap_or(0);
                let fall = cost - total(problem, &r, &next);
                let square = quadratic(&normal, &step).max(0.0);
                let promised = -2.0 * dot(&step, &gradient) - square;
                let missed = (fall / promised - 1.0).abs();
                good = missed < MAX_PREDICTION_ERROR;
                let part = if damping.value() < NEGLIGIBLE_DAMPING {
                    missed.min(1.0)
                } else {
                    1.0
                };
                let left = part * square.sqrt() / unit.sqrt();
                arrived = left < SHORT_STEP_SIGMAS * (x.len() as f64).sqrt()
                    || fall / unit.max(1.0) < MIN_COST_SAVED
                    || (unit > FAILED_FIT_COST && fall < MIN_COST_DECREASE_SHARE * cost);
                (x, residuals) = (next, r);
                damping.succeeded();
            }
        }
        if arrived && fresh {
            ending = Ending::Converged;
        }
        if ending != Ending::Limit || (evaluated >= MAX_ITERATIONS && !good) {
            return Ok(Found {
                cost: dot(&residuals, &residuals),
                x,
                residuals,
                jacobian,
                normal,
                iterations: iteration,
                ending,
                moved,
            });
        }
        for (i, step) in steps.iter_mut().enumerate() {
            let error = DIFFERENCE_STEP_SIGMAS / normal[(i, i)].sqrt();
            *step = error.clamp(problem.first[i].min(problem.largest[i]), problem.largest[i]);
        }
        kept = (good && !arrived).then_some((jacobian, normal));
    }
    Err(NoStart)
}

fn quadratic(matrix: &Mat<f64>, x: &[f64]) -> f64 {
    (0..x.len())
        .map(|i| x[i] * (0..x.len()).map(|j| matrix[(i, j)] * x[j]).sum::<f64>())
        .sum()
}

/// Returns the sum of squares of the residuals and the prior.
fn total(problem: &Problem<'_>, residuals: &[f64], x: &[f64]) -> f64 {
    let prior: f64 = (x.iter().zip(&problem.prior))
        .map(|(x, p)| (x * p).powi(2))
        .sum();
    dot(residuals, residuals) + prior
}

fn differences(
    problem: &Problem<'_>,
    x: &[f64],
    residuals: &[f64],
    steps: &[f64],
) -> Option<Vec<Vec<f64>>> {
    (0..x.len())
        .into_par_iter()
        .map(|i| {
            // The difference is taken backward where the forward one has no residuals.
            [steps[i], -steps[i]].into_iter().find_map(|step| {
                let mut beside = x.to_vec();
                beside[i] += step;
                let step = beside[i] - x[i];
                let mut column = (problem.residuals)(&beside)?;
                for (moved, r) in column.iter_mut().zip(residuals) {
                    *moved = (*moved - r) / step;
                }
                Some(column)
            })
        })
        .collect()
}

/// Returns `JᵀJ` plus the prior.
fn normal_matrix(problem: &Problem<'_>, jacobian: &[Vec<f64>]) -> Mat<f64> {
    let m = jacobian.len();
    let rows: Vec<Vec<f64>> = (0..m)
        .into_par_iter()
        .map(|i| (0..=i).map(|j| dot(&jacobian[i], &jacobian[j])).collect())
        .collect();
    let mut normal = Mat::from_fn(m, m, |i, j| rows[i.max(j)][i.min(j)]);
    for i in 0..m {
        normal[(i, i)] += problem.prior[i].powi(2);
    }
    normal
}

/// Returns half the gradient of the cost.
fn gradient(
    problem: &Problem<'_>,
    jacobian: &[Vec<f64>],
    residuals: &[f64],
    x: &[f64],
) -> Vec<f64> {
    (jacobian.iter().zip(x).zip(&problem.prior))
        .map(|((column, x), prior)| dot(column, residuals) + prior.powi(2) * x)
        .collect()
}

/// Solves `(H + damping diag(H)) step = -gradient`, unknowns scaled to unit diagonal.
fn damped(normal: &Mat<f64>, gradient: &[f64], damping: f64) -> Option<Vec<f64>> {
    let m = gradient.len();
    let scale: Vec<f64> = (0..m)
        .map(|i| match normal[(i, i)].sqrt() {
            norm if norm > 0.0 => norm.recip(),
            // No residual depends on this unknown, so it does not change.
            _ => 0.0,
        })
        .collect();
    let matrix = Mat::from_fn(m, m, |i, j| {
        let ridge = if i == j { damping + 1e-12 } else { 0.0 };
        let unseen = i == j && scale[i] == 0.0;
        normal[(i, j)] * scale[i] * scale[j] + ridge + f64::from(u8::from(unseen))
    });
    let right = Mat::from_fn(m, 1, |i, _| -gradient[i] * scale[i]);
    let step = matrix.llt(Side::Lower).ok()?.solve(&right);
    let step: Vec<f64> = (0..m).map(|i| step[(i, 0)] * scale[i]).collect();
    step.iter().all(|d| d.is_finite()).then_some(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Least difference step of the derivatives.
    const STEP: f64 = 1e-6;

    fn problem<'a>(
        start: [f64; 2],
        prior: f64,
        residuals: impl Fn(&[f64]) -> Option<Vec<f64>> + Sync + 'a,
    ) -> Problem<'a> {
        Problem {
            residuals: Box::new(residuals),
            start: start.to_vec(),
            first: vec![STEP; 2],
            largest: vec![1e-3; 2],
            prior: vec![0.0, prior],
        }
    }

    #[test]
    fn a_curved_valley_is_followed() {
        let valley = |x: &[f64]| Some(vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]);
        let found = minimise(&problem([-1.2, 1.0], 0.0, valley)).unwrap();
        assert_eq!(found.ending, Ending::Converged);
        // The search sees nothing below its difference step.
        assert!((found.x[0] - 1.0).abs() < STEP && (found.x[1] - 1.0).abs() < STEP);
        assert!(found.cost < STEP * STEP);
    }

    #[test]
    fn a_prior_pulls_to_zero() {
        // The residual pulls to 3 and the prior to 0 with equal weight, so the minimum is midway.
        let found = minimise(&problem([0.0, 0.0], 1.0, |x| Some(vec![x[0], x[1] - 3.0])));
        // The problem is linear, so the derivatives have the error of the rounding of residuals of up to 3.
        let limit = 3.0 * f64::EPSILON / STEP;
        assert!((found.unwrap().x[1] - 1.5).abs() < limit);
    }

    #[test]
    fn steps_without_residuals_are_rejected() {
        // The search looks for the root of 4. There are no residuals below 1 and above 3.
        let wall = |x: &[f64]| {
            (1.0..3.0)
                .contains(&x[0])
                .then(|| vec![x[0] * x[0] - 4.0, x[1]])
        };
        let found = minimise(&problem([1.0, 0.0], 0.0, wall)).unwrap();
        assert!((found.x[0] - 2.0).abs() < STEP, "{:?}", found.x);
        assert!(minimise(&problem([5.0, 0.0], 0.0, wall)).is_err());
    }

    #[test]
    fn a_search_without_descent_is_stuck() {
        // The cost decreases next to the start and jumps up at 1e-5.
        let trap = |x: &[f64]| {
            let height = if x[0] > 1e-5 { 9.0 } else { 1.0 - 1e4 * x[0] };
            Some(vec![height, x[1]])
        };
        let found = minimise(&problem([0.0, 0.0], 0.0, trap)).unwrap();
        assert_eq!(found.ending, Ending::Stuck);
        // The minimum is at infinity.
        let forever = |x: &[f64]| Some(vec![1e12 / (1.0 + x[0]), x[1]]);
        let found = minimise(&problem([0.0, 0.0], 0.0, forever)).unwrap();
        assert_eq!((found.ending, found.moved), (Ending::Limit, 0));
    }
}
