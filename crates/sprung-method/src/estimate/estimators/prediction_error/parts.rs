//! Changes of the unknowns between parts of the logs: folds of all samples, and single logs.

use super::constrained;
use super::descent::Descent;
use super::filter::{NormalEquations, Sums};
use super::problem::{Problem, add_prior};
use super::solve::{covariance, damped_step};
use crate::estimate::statistics::HELD_OUT_PARTS;
use crate::estimate::statistics::between_parts;

/// One of the consecutive folds of all samples.
pub(super) struct Fold {
    /// Normal equations of the fold.
    pub(super) normal: NormalEquations,
    /// End of the fold, as a fraction of all samples.
    pub(super) end: f64,
}

/// Returns the folds of the samples, of about equal length.
///
/// - `sums`: with the sums after growing parts.
pub(super) fn folds(problem: &Problem<'_>, sums: &Sums) -> Vec<Fold> {
    let duration = problem.measurements.duration();
    // Each fold contains a motion, which takes a second or more.
    let count = if duration < HELD_OUT_PARTS as f64 {
        HELD_OUT_PARTS / 2
    } else {
        HELD_OUT_PARTS
    };
    equal_parts(problem, sums, count)
}

/// Returns a number of parts of about equal length.
pub(super) fn equal_parts(problem: &Problem<'_>, sums: &Sums, count: usize) -> Vec<Fold> {
    let duration = problem.measurements.duration();
    let whole = (1.0, &sums.normal);
    let mut before = (0.0, NormalEquations::zero(sums.normal.count));
    (1..=count)
        .map(|fold| {
            let at = fold * sums.growing.len() / count;
            let kept = (sums.growing.get(at.wrapping_sub(1))).filter(|_| fold < count);
            let (end, up_to) = kept.map_or(whole, |(time, normal)| (time / duration, normal));
            let difference = Fold {
                normal: up_to.without(&before.1),
                end,
            };
            before = (end, up_to.clone());
            difference
        })
        .collect()
}

/// Value and standard error of each unknown with a value, from a part of the measurements alone.
pub(super) type Alone = Vec<(f64, f64)>;

/// Returns the estimate from a part of the measurements, one step from the optimum of all
/// measurements; `None` if the part does not determine all unknowns.
pub(super) fn alone(
    problem: &Problem<'_>,
    descent: &Descent,
    part: &NormalEquations,
) -> Option<Alone> {
    let count = problem.unknowns.values();
    let normal = with_prior(problem, descent, part);
    let covariance = covariance(&normal.information, count)?;
    let z = step(descent, &normal)?;
    let error = |i: usize| covariance[i * (count + 1)].sqrt();
    Some((0..count).map(|i| (z[i], error(i))).collect())
}

/// Returns the values of [`alone`].
pub(super) fn values_alone(
    problem: &Problem<'_>,
    descent: &Descent,
    part: &NormalEquations,
) -> Option<Vec<f64>> {
    step(descent, &with_prior(problem, descent, part))
}

fn step(descent: &Descent, normal: &NormalEquations) -> Option<Vec<f64>> {
    let step = damped_step(&normal.information, &normal.gradient, 0.0)?;
    Some(descent.z.iter().zip(&step).map(|(x, d)| x + d).collect())
}

fn with_prior(problem: &Problem<'_>, descent: &Descent, part: &NormalEquations) -> NormalEquations {
    let mut part = part.first(problem.unknowns.values());
    add_prior(problem.unknowns, &descent.z, &mut part);
    part
}

/// Returns the estimates with the standard error of each unknown multiplied by its factor.
pub(super) fn widened(mut parts: Vec<Alone>, widening: &[f64]) -> Vec<Alone> {
    for part in &mut parts {
        for ((_, error), factor) in part.iter_mut().zip(widening) {
            *error *= factor;
        }
    }
    parts
}

/// Returns the standard error of an unknown by its changes between the parts; zero if the parts
/// agree.
pub(super) fn between(parts: &[Alone], unknown: usize) -> f64 {
    let values: Vec<(f64, f64)> = (parts.iter())
        .filter_map(|part| part.get(unknown).copied())
        .collect();
    between_parts(&values).map_or(0.0, |found| found.standard_error())
}

/// Returns the values of [`alone`] of the likeliest robot that can exist.
pub(super) fn possible_alone(
    problem: &Problem<'_>,
    descent: &Descent,
    part: &NormalEquations,
) -> Option<Vec<f64>> {
    let normal = with_prior(problem, descent, part);
    let step = constrained::step(problem, &descent.z, &normal, 0.0)?;
    Some(descent.z.iter().zip(&step).map(|(x, d)| x + d).collect())
}

/// Returns the unknowns without each of the folds in turn, and the end of each fold as a fraction
/// of the samples. Returns an empty list if the other folds do not determine the unknowns.
///
/// - `values`: returns the unknowns of some normal equations.
pub(super) fn without_folds(
    whole: &NormalEquations,
    folds: &[Fold],
    values: impl Fn(&NormalEquations) -> Option<Vec<f64>>,
) -> Vec<(f64, Vec<f64>)> {
    let each: Option<Vec<(f64, Vec<f64>)>> = (folds.iter())
        .map(|fold| Some((fold.end, values(&whole.without(&fold.normal))?)))
        .collect();
    each.unwrap_or_default()
}

/// Returns the standard deviation of an unknown between the folds by the jackknife; infinite if
/// there is none. A fold with little information, for example one in which the robot stands still,
/// may alone give any value, but hardly changes the estimate.
pub(super) fn deviation(without: &[(f64, Vec<f64>)], unknown: usize) -> f64 {
    let count = without.len() as f64;
    let values = || without.iter().map(|(_, z)| z.get(unknown).copied());
    let Some(sum) = values().sum::<Option<f64>>().filter(|_| count > 1.0) else {
        return f64::INFINITY;
    };
    let squares: f64 = values().flatten().map(|x| (x - sum / count).powi(2)).sum();
    ((count - 1.0) * squares).sqrt()
}
