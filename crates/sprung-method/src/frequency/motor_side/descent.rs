//! Levenberg-Marquardt steps on the errors of the equations.

use faer::Mat;
use faer::Side;
use faer::linalg::solvers::Solve;

use super::equations::{Equations, Errors};

/// First damping of a descent, and factors after a failed and after a good step.
const FIRST_DAMPING: f64 = 1e-2;
const AFTER_FAILURE: f64 = 4.0;
const AFTER_SUCCESS: f64 = 0.2;
const LEAST_DAMPING: f64 = 1e-9;

/// Failed steps in a row at which a descent ends.
const MAX_FAILURES: usize = 12;

/// Largest change of a logarithm in one step.
const LARGEST_STEP: f64 = 1.0;

/// Relative change of the cost at which a descent ends.
const SETTLED: f64 = 1e-8;

/// Descends from `x`; returns the end with its errors, `None` if the equations cannot be solved at the
/// start.
pub(super) fn descend(
    equations: &Equations<'_>,
    mut x: Vec<f64>,
    steps: usize,
) -> Option<(Vec<f64>, Errors)> {
    let mut errors = equations.errors(&x)?;
    let mut damping = FIRST_DAMPING;
    let mut failures = 0;
    let mut taken = 0;
    while taken < steps && failures < MAX_FAILURES {
        let moved = step(equations, &x, &errors, damping);
        let cost = moved.as_ref().and_then(|moved| equations.cost(moved));
        let better = moved.zip(cost).filter(|(_, cost)| *cost < errors.cost);
        let Some((moved, cost)) = better else {
            damping *= AFTER_FAILURE;
            failures += 1;
            continue;
        };
        let settled = errors.cost - cost < SETTLED * cost;
        x = moved;
        errors = equations.errors(&x)?;
        if settled {
            break;
        }
        (failures, taken) = (0, taken + 1);
        damping = (AFTER_SUCCESS * damping).max(LEAST_DAMPING);
    }
    Some((x, errors))
}

/// Returns the unknowns after a damped step.
fn step(equations: &Equations<'_>, x: &[f64], errors: &Errors, damping: f64) -> Option<Vec<f64>> {
    let scales = scales(&errors.normal);
    let count = x.len();
    let matrix = Mat::from_fn(count, count, |i, j| {
        let entry = errors.normal[(i, j)] / (scales[i] * scales[j]);
        if i == j { entry + damping } else { entry }
    });
    let right = Mat::from_fn(count, 1, |i, _| errors.gradient[i] / scales[i]);
    let solved = matrix.llt(Side::Lower).ok()?.solve(right);
    let places = equations.places;
    let mut moved: Vec<f64> = (0..count)
        .map(|i| x[i] + solved[(i, 0)] / scales[i])
        .collect();
    for joint in 0..equations.lines.joints() {
        for place in [places.rotor(joint), places.stiffness(joint)] {
            moved[place] = moved[place].clamp(x[place] - LARGEST_STEP, x[place] + LARGEST_STEP);
        }
    }
    moved.iter().all(|value| value.is_finite()).then_some(moved)
}

/// Returns the covariance of the unknowns, \[unknowns × unknowns\]; `None` if they are not determined.
pub(super) fn covariance(errors: &Errors) -> Option<Mat<f64>> {
    let scales = scales(&errors.normal);
    let count = scales.len();
    let is_used = |i: usize| errors.normal[(i, i)] > 0.0;
    let matrix = Mat::from_fn(count, count, |i, j| {
        let entry = errors.normal[(i, j)] / (scales[i] * scales[j]);
        if i == j && !is_used(i) { 1.0 } else { entry }
    });
    let inverse = matrix
        .llt(Side::Lower)
        .ok()?
        .solve(Mat::<f64>::identity(count, count));
    Some(Mat::from_fn(count, count, |i, j| {
        inverse[(i, j)] / (scales[i] * scales[j])
    }))
}

/// Returns the length of each column; one for an empty column.
fn scales(normal: &Mat<f64>) -> Vec<f64> {
    (0..normal.nrows())
        .map(|i| normal[(i, i)].sqrt())
        .map(|scale| if scale > 0.0 { scale } else { 1.0 })
        .collect()
}
