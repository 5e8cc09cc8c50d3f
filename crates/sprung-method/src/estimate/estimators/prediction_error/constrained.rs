//! Steps of a descent to the parameters of robots that can exist.

use faer::Mat;
use faer::linalg::solvers::Solve;

use super::filter::NormalEquations;
use super::problem::Problem;
use super::solve::damped_step;
use crate::estimate::possible::Robots;

/// Size of a fixed parameter, relative to that of its information, so large that no step reaches
/// it.
const HELD: f64 = 1e8;

/// Returns the step to the minimum of a quadratic model over the robots that can exist, where the damping increases the
/// diagonal by a fraction of itself; over all robots without constraints. Returns `None` if the model is not convex.
///
/// - `z`: unknowns from which the step is made.
pub(super) fn step(
    problem: &Problem<'_>,
    z: &[f64],
    normal: &NormalEquations,
    damping: f64,
) -> Option<Vec<f64>> {
    let by = damped_step(&normal.information, &normal.gradient, damping)?;
    match problem.robots {
        None => Some(by),
        Some(robots) => to_possible(problem, robots, (z, by), normal, damping),
    }
}

/// Returns the step to the robot that can exist and is nearest to the end of a step, in the metric of the model. The
/// other unknowns, offsets and velocities, follow the parameters.
fn to_possible(
    problem: &Problem<'_>,
    robots: &Robots<'_>,
    (z, by): (&[f64], Vec<f64>),
    normal: &NormalEquations,
    damping: f64,
) -> Option<Vec<f64>> {
    let unknowns = problem.unknowns;
    let (count, width) = (by.len(), unknowns.free.len());
    let entry = |i: usize, j: usize| {
        let information = normal.information[i.max(j) * count + i.min(j)];
        information * if i == j { 1.0 + damping } else { 1.0 }
    };
    let others = Mat::from_fn(count - width, count - width, |i, j| {
        entry(width + i, width + j)
    });
    let coupling = Mat::from_fn(count - width, width, |i, j| entry(width + i, j));
    // Moves of the other unknowns by those of the parameters.
    let follow = match count - width {
        0 => Mat::zeros(0, width),
        _ => others.llt(faer::Side::Lower).ok()?.solve(&coupling),
    };
    let seen = coupling.transpose() * &follow;
    let target: Vec<f64> = z.iter().zip(&by).map(|(z, by)| z + by).collect();
    let theta = unknowns.theta(&target);
    let p = theta.len();
    let mut metric = Mat::zeros(p, p);
    for (i, &row) in unknowns.free.iter().enumerate() {
        for (j, &column) in unknowns.free.iter().enumerate() {
            metric[(row, column)] = entry(i, j) - seen[(i, j)];
        }
    }
    for i in (0..p).filter(|i| !unknowns.free.contains(i)) {
        metric[(i, i)] = HELD / theta[i].powi(2).max(HELD.recip());
    }
    if robots.contains(&metric, &theta) {
        return Some(by);
    }
    let found = robots.nearest(&metric, &theta).ok()?.theta;
    let moved: Vec<f64> = (unknowns.free.iter())
        .map(|&i| found[i] - theta[i])
        .collect();
    let mut step = by;
    for (entry, moved) in step.iter_mut().zip(&moved) {
        *entry += moved;
    }
    for (i, entry) in step[width..].iter_mut().enumerate() {
        *entry -= moved
            .iter()
            .enumerate()
            .map(|(j, moved)| follow[(i, j)] * moved)
            .sum::<f64>();
    }
    Some(step)
}
