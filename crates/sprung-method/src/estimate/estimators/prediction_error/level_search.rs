//! Search for the levels with the greatest likelihood.
//!
//! The search takes scoring steps. Their matrix is the average information of the innovations,
//! scaled to the expected information.

use super::disturbance_cap::{follow_cap, held_by_cap};
use super::levels::{Level, Levels, UnknownLevels};
use super::likelihood::{LevelLikelihood, Score};
use super::solve::damped_step;
use crate::estimate::statistics::{MAX_ROUNDS, NEGLIGIBLE_SHARE, ROUNDING};

/// Largest change of a logarithm in a step: a factor of 4.5, beyond which the quadratic model of the likelihood fails.
/// Half the value stops a search early and moves an estimate by 1.1 standard errors, twice the value by 0.04.
const MAX_LOG_CHANGE: f64 = 1.5;

/// Limit of the factor that scales the information, and of its inverse.
const MAX_CORRECTION: f64 = 30.0;

/// The search ends if a step predicts a smaller gain of the log-likelihood; the next run of the filter begins a new
/// search. Twice the value moves an estimate by 0.04 standard errors, half the value by less than 0.01.
const MIN_PREDICTED_GAIN: f64 = 0.1;

/// Gain relative to the gain of the search so far, below which the next run of the filter gains more. Twice the value
/// moves an estimate by 0.04 standard errors, half the value by less than 0.01.
const MIN_RELATIVE_GAIN: f64 = 0.02;

/// Factor that shortens a step while it does not raise the likelihood. Its inverse is the growth of the added
/// information while the longest step is too long. Half or twice the value moves an estimate by 0.04 standard errors.
const SHORTENING: f64 = 0.25;

/// Initial information that is added for every logarithm: a prior whose standard deviation is a factor of 24.
const START_ADDED_INFORMATION: f64 = 0.1;

/// Expected corner frequency of the disturbances, Hz, and its standard deviation as a factor. This prior is needed
/// because a log with small disturbances does not determine the corner. Half the value moves an estimate by 0.06
/// standard errors, twice the value by 0.01.
pub(super) const EXPECTED_CORNER_HZ: f64 = 1.5;

/// Standard deviation of the corner frequency, as a factor. Half the value moves an estimate by 0.3 standard errors,
/// twice the value by 0.04.
const CORNER_FACTOR: f64 = 3.0;

/// Searches the levels with the greatest likelihood. Returns them and the increase of the
/// log-likelihood.
///
/// - `unknown`: the levels that are searched; `from`: all levels at the start.
pub(super) fn search_levels(
    likelihood: &LevelLikelihood<'_>,
    unknown: &UnknownLevels,
    from: &Levels,
) -> (Levels, f64) {
    let mut logs = unknown.logarithms(from);
    let mut levels = unknown.levels(from, &logs);
    let Some(mut score) = score(likelihood, unknown, &levels) else {
        return (levels, 0.0);
    };
    let first = score.loss;
    for _ in 0..MAX_ROUNDS {
        let held = held_by_cap(unknown, &levels, &score.gradient, &mut logs);
        follow_cap(unknown, &held, &mut score);
        let Some((step, predicted)) = scoring_step(unknown, &logs, &score) else {
            break;
        };
        let least = MIN_RELATIVE_GAIN * (first - score.loss);
        if predicted < MIN_PREDICTED_GAIN.max(least) {
            break;
        }
        let mut part = 1.0;
        let better = loop {
            let at: Vec<f64> = logs.iter().zip(&step).map(|(x, d)| x + part * d).collect();
            let there = unknown.levels(from, &at);
            let found = self::score(likelihood, unknown, &there);
            if let Some(found) = found.filter(|found| found.loss < score.loss) {
                break Some((there, found));
            }
            part *= SHORTENING;
            if part < NEGLIGIBLE_SHARE {
                break None;
            }
        };
        let Some((there, found)) = better else { break };
        levels = there;
        logs = unknown.logarithms(&levels);
        score = found;
    }
    (levels, first - score.loss)
}

/// Returns the score of the likelihood with the prior of the corner. The information is scaled such
/// that for a single level it equals the expected information.
pub(super) fn score(
    likelihood: &LevelLikelihood<'_>,
    unknown: &UnknownLevels,
    levels: &Levels,
) -> Option<Score> {
    let mut score = likelihood.score(unknown, levels)?;
    let count = unknown.all.len();
    let scales: Vec<f64> = (unknown.all.iter().zip(&score.expected).zip(&score.gradient))
        .map(|((level, expected), derivative)| {
            let found = expected - derivative;
            if *level == Level::Corner || !(found > 0.0 && *expected > 0.0) {
                1.0
            } else {
                let correction = (expected / found).sqrt();
                correction.clamp(1.0 / MAX_CORRECTION, MAX_CORRECTION)
            }
        })
        .collect();
    for i in 0..count {
        for j in 0..=i {
            score.information[i * count + j] *= scales[i] * scales[j];
        }
    }
    if let Some(at) = unknown.all.iter().position(|level| *level == Level::Corner) {
        let (away, width) = (
            (levels.corner / EXPECTED_CORNER_HZ).ln(),
            CORNER_FACTOR.ln(),
        );
        score.loss += 0.5 * (away / width).powi(2);
        score.gradient[at] += away / width.powi(2);
        score.information[at * (count + 1)] += width.powi(-2);
    }
    Some(score)
}

/// Returns the scoring step within the bounds, and its predicted gain.
///
/// The same information is added for every logarithm. It is large enough to keep the longest step
/// below `MAX_LOG_CHANGE`. So a level that the log hardly determines moves little.
fn scoring_step(unknown: &UnknownLevels, logs: &[f64], score: &Score) -> Option<(Vec<f64>, f64)> {
    let (gradient, information) = (&score.gradient, &score.information);
    let count = logs.len();
    let mut fixed = vec![false; count];
    let mut added = START_ADDED_INFORMATION;
    loop {
        let free: Vec<usize> = (0..count).filter(|i| !fixed[*i]).collect();
        let part: Vec<f64> = (free.iter())
            .flat_map(|&i| free.iter().map(move |&j| (i, j)))
            .map(|(i, j)| {
                let damping = if i == j { added } else { 0.0 };
                damping + information[i.max(j) * count + i.min(j)]
            })
            .collect();
        let free_gradient: Vec<f64> = free.iter().map(|&i| gradient[i]).collect();
        let step = damped_step(&part, &free_gradient, 0.0)?;
        if step.iter().any(|step| step.abs() > MAX_LOG_CHANGE) {
            added /= SHORTENING;
            continue;
        }
        let mut all = vec![0.0; count];
        let mut most_cut = None;
        for (&i, step) in free.iter().zip(&step) {
            let (low, high) = unknown.bounds[i];
            let inside = (logs[i] + step).clamp(low.ln(), high.ln());
            all[i] = inside - logs[i];
            let cut = (all[i] - step).abs();
            if most_cut.is_none_or(|(_, most)| cut > most) && cut > ROUNDING {
                most_cut = Some((i, cut));
            }
        }
        let predicted: f64 = -0.5 * all.iter().zip(gradient).map(|(d, g)| d * g).sum::<f64>();
        match most_cut {
            // A level at its bound whose step points outward is fixed. A level whose step is cut is
            // fixed too if the whole step would lower the likelihood.
            Some((i, _)) if all[i].abs() < ROUNDING || predicted <= 0.0 => fixed[i] = true,
            _ => return Some((all, predicted)),
        }
    }
}
