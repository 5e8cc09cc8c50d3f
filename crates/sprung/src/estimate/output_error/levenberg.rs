//! Levenberg-Marquardt with forward differences.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use rayon::prelude::*;

/// Places at which derivatives are taken, at most.
const MOST_ITERATIONS: usize = 30;

/// Part of the promised fall of the cost that it may miss, for derivatives that are good
/// enough for another step: new ones cost as many simulations as there are unknowns.
const AS_PROMISED: f64 = 0.3;

/// Mean squared residual from which another loop ran: there a step that makes the cost
/// smaller by less than this part is the last.
pub(super) const HOPELESS: f64 = 25.0;
const IN_VAIN: f64 = 1e-3;

/// Steps that are tried in one iteration, at most.
const MOST_TRIES: usize = 10;

/// A step is the last if what it leaves to go is shorter than this part of the standard
/// errors, or the cost falls by less than this many units of noise.
const SHORT_STEP_SIGMAS: f64 = 0.02;
const FLAT_COST: f64 = 1e-3;

/// Damping below which a step leaves to go what the derivatives miss and no more.
const UNDAMPED: f64 = 3e-5;

/// A difference moves the cost by this part of a standard error.
const DIFFERENCE_SIGMAS: f64 = 0.5;

/// Residuals of unknowns; nothing where there are none.
type Residuals<'a> = Box<dyn Fn(&[f64]) -> Option<Vec<f64>> + Sync + 'a>;

/// Squares to be made small.
pub(super) struct Problem<'a> {
    /// Residuals over their noise.
    pub(super) residuals: Residuals<'a>,
    /// Where the search starts, \[m\].
    pub(super) start: Vec<f64>,
    /// Differences of the first derivatives, \[m\].
    pub(super) first: Vec<f64>,
    /// Largest differences, \[m\].
    pub(super) largest: Vec<f64>,
    /// One over the standard deviation of each unknown about zero; 0 for one
    /// of which nothing is known, \[m\].
    pub(super) prior: Vec<f64>,
}

/// How a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ending {
    /// At a minimum.
    Converged,
    /// After the last iteration that is allowed.
    Limit,
    /// Where no step made the cost smaller, though the derivatives promise it.
    Stuck,
}

/// What a search found.
pub(super) struct Found {
    /// The unknowns, \[m\].
    pub(super) x: Vec<f64>,
    /// Residuals there.
    pub(super) residuals: Vec<f64>,
    /// Their derivatives, one column per unknown, from the last iteration.
    pub(super) jacobian: Vec<Vec<f64>>,
    /// `JᵀJ` and the prior, \[m × m\].
    pub(super) normal: Mat<f64>,
    /// Sum of squares of the residuals.
    pub(super) cost: f64,
    /// Number of iterations.
    pub(super) iterations: usize,
    /// How it ended.
    pub(super) ending: Ending,
    /// The unknown that moved most in the last step, in standard errors.
    pub(super) moved: usize,
}

/// There are no residuals at the start, or none beside it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct NoStart;

/// Minimises the squares of residuals and prior.
///
/// Columns of the derivatives are shared among threads; who does which changes
/// no bit.
pub(super) fn minimise(problem: &Problem<'_>) -> Result<Found, NoStart> {
    let mut x = problem.start.clone();
    let mut residuals = (problem.residuals)(&x).ok_or(NoStart)?;
    let mut steps = problem.first.clone();
    let mut damping = 1e-3;
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
        for _ in 0..if fresh { MOST_TRIES } else { 1 } {
            if let Some(step) = damped(&normal, &gradient, damping) {
                let next: Vec<f64> = x.iter().zip(&step).map(|(x, d)| x + d).collect();
                let found = (problem.residuals)(&next);
                if let Some(r) = found.filter(|r| total(problem, r, &next) < cost) {
                    accepted = Some((next, r, step));
                    break;
                }
            }
            if fresh {
                damping = f64::max(8.0 * damping, 1e-4);
            }
        }
        let (mut arrived, mut good) = (false, false);
        match accepted {
            // What the derivatives of another place promise proves nothing.
            None if !fresh => {}
            None => {
                // Rounding and the tolerance of the simulation hide the rest.
                let promised = damped(&normal, &gradient, 0.0)
                    .map_or(f64::INFINITY, |step| -dot(&step, &gradient));
                ending = if promised < FLAT_COST.sqrt() * unit * x.len() as f64 {
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
                good = missed < AS_PROMISED;
                let part = if damping < UNDAMPED {
                    missed.min(1.0)
                } else {
                    1.0
                };
                let left = part * square.sqrt() / unit.sqrt();
                arrived = left < SHORT_STEP_SIGMAS * (x.len() as f64).sqrt()
                    || fall / unit.max(1.0) < FLAT_COST
                    || (unit > HOPELESS && fall < IN_VAIN * cost);
                (x, residuals) = (next, r);
                damping = f64::max(damping / 10.0, 1e-9);
            }
        }
        if arrived && fresh {
            ending = Ending::Converged;
        }
        if ending != Ending::Limit || (evaluated >= MOST_ITERATIONS && !good) {
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
            let error = DIFFERENCE_SIGMAS / normal[(i, i)].sqrt();
            *step = error.clamp(problem.first[i].min(problem.largest[i]), problem.largest[i]);
        }
        kept = (good && !arrived).then_some((jacobian, normal));
    }
    Err(NoStart)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn quadratic(matrix: &Mat<f64>, x: &[f64]) -> f64 {
    (0..x.len())
        .map(|i| x[i] * (0..x.len()).map(|j| matrix[(i, j)] * x[j]).sum::<f64>())
        .sum()
}

/// Sum of squares of residuals and prior.
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
            // Behind the start where there is nothing before it.
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

/// `JᵀJ` and the prior.
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

/// Half the derivative of the cost.
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

/// Solves `(H + damping diag(H)) step = -gradient`, unknowns scaled to unit
/// diagonal.
fn damped(normal: &Mat<f64>, gradient: &[f64], damping: f64) -> Option<Vec<f64>> {
    let m = gradient.len();
    let scale: Vec<f64> = (0..m)
        .map(|i| match normal[(i, i)].sqrt() {
            norm if norm > 0.0 => norm.recip(),
            // Nothing moves with it: it stays.
            _ => 0.0,
        })
        .collect();
    let matrix = Mat::from_fn(m, m, |i, j| {
        let own = if i == j { damping + 1e-12 } else { 0.0 };
        let unseen = i == j && scale[i] == 0.0;
        normal[(i, j)] * scale[i] * scale[j] + own + f64::from(u8::from(unseen))
    });
    let right = Mat::from_fn(m, 1, |i, _| -gradient[i] * scale[i]);
    let step = matrix.llt(Side::Lower).ok()?.solve(&right);
    let step: Vec<f64> = (0..m).map(|i| step[(i, 0)] * scale[i]).collect();
    step.iter().all(|d| d.is_finite()).then_some(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem<'a>(
        start: [f64; 2],
        prior: f64,
        residuals: impl Fn(&[f64]) -> Option<Vec<f64>> + Sync + 'a,
    ) -> Problem<'a> {
        Problem {
            residuals: Box::new(residuals),
            start: start.to_vec(),
            first: vec![1e-6; 2],
            largest: vec![1e-3; 2],
            prior: vec![0.0, prior],
        }
    }

    #[test]
    fn a_curved_valley_is_followed() {
        let valley = |x: &[f64]| Some(vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]);
        let found = minimise(&problem([-1.2, 1.0], 0.0, valley)).unwrap();
        assert_eq!(found.ending, Ending::Converged);
        assert!((found.x[0] - 1.0).abs() < 1e-3 && (found.x[1] - 1.0).abs() < 1e-3);
        assert!(found.cost < 1e-6);
    }

    #[test]
    fn a_prior_pulls_to_zero() {
        // One residual of level 1 and a prior of the same: the middle.
        let found = minimise(&problem([0.0, 0.0], 1.0, |x| Some(vec![x[0], x[1] - 3.0])));
        assert!((found.unwrap().x[1] - 1.5).abs() < 1e-6);
    }

    #[test]
    fn steps_where_there_is_nothing_are_not_taken() {
        // The root of 4 is wanted; below 1 and above 3 no robot can move.
        let wall = |x: &[f64]| {
            (1.0..3.0)
                .contains(&x[0])
                .then(|| vec![x[0] * x[0] - 4.0, x[1]])
        };
        let found = minimise(&problem([1.0, 0.0], 0.0, wall)).unwrap();
        assert!((found.x[0] - 2.0).abs() < 1e-4, "{:?}", found.x);
        assert!(minimise(&problem([5.0, 0.0], 0.0, wall)).is_err());
    }

    #[test]
    fn no_way_down_is_said() {
        // A slope downwards beside the start, and a wall behind it.
        let trap = |x: &[f64]| {
            let height = if x[0] > 1e-5 { 9.0 } else { 1.0 - 1e4 * x[0] };
            Some(vec![height, x[1]])
        };
        let found = minimise(&problem([0.0, 0.0], 0.0, trap)).unwrap();
        assert_eq!(found.ending, Ending::Stuck);
        // A minimum at infinity.
        let forever = |x: &[f64]| Some(vec![1e12 / (1.0 + x[0]), x[1]]);
        let found = minimise(&problem([0.0, 0.0], 0.0, forever)).unwrap();
        assert_eq!((found.ending, found.moved), (Ending::Limit, 0));
    }
}
