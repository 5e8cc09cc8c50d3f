//! The search for the likeliest equations, from many starts.

use std::f64::consts::TAU;

use faer::{Mat, Side};
use rayon::prelude::*;

use super::descent::descend;
use super::equations::{Equations, Errors, Places};
use super::lines::{Lines, POWER_LINES, mean_power};
use super::start::starts;

/// Lines of a trial; first steps from each start, share of continued starts (one in this number), and steps of those;
/// steps of a descent.
const LINES_OF_TRIAL: usize = 240;
const FIRST_STEPS: usize = 8;
const FIRST_ONE_OF: usize = 4;
const STEPS_OF_TRIAL: usize = 40;
const STEPS: usize = 60;

/// Trials that are completed, and the relative difference of costs from which they differ.
const BEST_TRIALS: usize = 4;
const DIFFERENT: f64 = 1e-3;

/// Antiresonances of possible ends: at least over the distance of lines, and at most over the highest line.
const LOWEST_ANTIRESONANCE: f64 = 6.0;
const HIGHEST_ANTIRESONANCE: f64 = 3.0;

/// Estimates of the variances of the positions from their errors.
const VARIANCE_ROUNDS: usize = 5;

/// Least variance of a position, rad² (m²).
const LEAST_VARIANCE: f64 = 1e-40;

/// Returns the likeliest unknowns with the errors there; `None` if no start ends at possible ones.
///
/// The first trials weight the positions by their sizes. The best of them continue with the variances of their errors,
/// and the smallest variances decide.
pub(super) fn solve(lines: &Lines) -> Option<(Vec<f64>, Errors)> {
    let few = lines.thinned(LINES_OF_TRIAL);
    let places = Places::new(lines);
    let variances = relative_variances(&few);
    let trial = Equations {
        lines: &few,
        places,
        variances: &variances,
    };
    let ends = |starts: Vec<Vec<f64>>| -> Vec<(Vec<f64>, f64)> {
        let mut first: Vec<(Vec<f64>, Errors)> = (starts.into_par_iter())
            .filter_map(|x| descend(&trial, x, FIRST_STEPS))
            .collect();
        first.sort_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
        first.truncate(first.len().div_ceil(FIRST_ONE_OF));
        (first.into_par_iter())
            .filter_map(|(x, _)| descend(&trial, x, STEPS_OF_TRIAL))
            .filter(|(x, _)| is_possible(x, places, lines))
            .map(|(x, errors)| (x, errors.cost))
            .collect()
    };
    let starts = starts(&few, places);
    let mut tried = ends(starts.clone());
    for joint in 0..lines.joints() {
        // The joints may have other antiresonances.
        let Some((best, _)) = tried.iter().min_by(|a, b| a.1.total_cmp(&b.1)).cloned() else {
            break;
        };
        let others = starts.iter().map(|start| {
            let mut x = start.clone();
            for other in (0..lines.joints()).filter(|other| *other != joint) {
                for place in places.of_joint(other) {
                    x[place] = best[place];
                }
            }
            x
        });
        tried.extend(ends(others.collect()));
    }
    tried.sort_by(|a, b| a.1.total_cmp(&b.1));
    tried.dedup_by(|b, a| b.1 - a.1 < DIFFERENT * a.1);
    tried.truncate(BEST_TRIALS);
    let ends: Vec<Weighted> = (tried.into_par_iter())
        .filter_map(|(x, _)| weighted(lines, &x))
        .filter(|end| is_possible(&end.x, places, lines))
        .collect();
    let best = ends.into_iter().min_by(|a, b| a.size.total_cmp(&b.size))?;
    Some((best.x, best.errors))
}

/// Returns half the difference of each unknown between two parts of the log, \[unknowns\]: the standard
/// error of their mean. Infinite if a part has no solution.
///
/// - `x`: the solution of the whole log.
pub(super) fn half_differences(parts: [Option<Lines>; 2], x: &[f64]) -> Vec<f64> {
    let [first, second] = parts.map(|lines| {
        let lines = lines?;
        // Each part has separate states at its ends.
        let mut start = x.to_vec();
        for place in Places::new(&lines).of_transients() {
            start[place] = 0.0;
        }
        Some(weighted(&lines, &start)?.x)
    });
    match first.zip(second) {
        Some((first, second)) => (first.iter().zip(&second))
            .map(|(a, b)| 0.5 * (a - b).abs())
            .collect(),
        None => vec![f64::INFINITY; x.len()],
    }
}

/// Returns whether the links have a positive definite inertia matrix, and antiresonances near the lines.
fn is_possible(x: &[f64], places: Places, lines: &Lines) -> bool {
    let joints = lines.joints();
    let links = Mat::from_fn(joints, joints, |i, j| x[Places::inertia(i, j)]);
    let (Some(first), Some(last)) = (lines.hz.first(), lines.hz.last()) else {
        return false;
    };
    let near = LOWEST_ANTIRESONANCE * first..HIGHEST_ANTIRESONANCE * last;
    links.llt(Side::Lower).is_ok()
        && (0..joints).all(|joint| {
            let square = x[places.stiffness(joint)].exp() / x[Places::inertia(joint, joint)];
            let damping = x[places.motor_damping(joint)];
            near.contains(&(square.sqrt() / TAU))
                && damping >= 0.0
                && damping + x[places.link_damping(joint)] >= 0.0
        })
}

/// The end of a descent with variances from the errors.
struct Weighted {
    /// The unknowns.
    x: Vec<f64>,
    errors: Errors,
    /// Sum of the logarithms of the variances.
    size: f64,
}

/// Descends with variances from the errors, in rounds.
fn weighted(lines: &Lines, x: &[f64]) -> Option<Weighted> {
    let places = Places::new(lines);
    let mut variances = relative_variances(lines);
    let mut end: Option<(Vec<f64>, Errors)> = None;
    for _ in 0..=VARIANCE_ROUNDS {
        let start = end.map_or_else(|| x.to_vec(), |(x, _)| x);
        let equations = Equations {
            lines,
            places,
            variances: &variances,
        };
        let (x, errors) = descend(&equations, start, STEPS)?;
        variances = (errors.residuals.iter())
            .map(|residuals| {
                (0..residuals.len())
                    .map(|line| mean_power(residuals, line, POWER_LINES).max(LEAST_VARIANCE))
                    .collect()
            })
            .collect();
        end = Some((x, errors));
    }
    let (x, errors) = end?;
    let size = variances
        .iter()
        .flatten()
        .map(|variance| variance.ln())
        .sum();
    Some(Weighted { x, errors, size })
}

/// Returns variances in proportion to the powers of the positions.
fn relative_variances(lines: &Lines) -> Vec<Vec<f64>> {
    let half = POWER_LINES / 2;
    (lines.motor.iter())
        .map(|spectrum| {
            (0..spectrum.len())
                .map(|line| mean_power(spectrum, line, half).max(LEAST_VARIANCE))
                .collect()
        })
        .collect()
}
