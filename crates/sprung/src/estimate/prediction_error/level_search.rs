//! The levels of the greatest likelihood.
//!
//! Steps are those of scoring: the information that the innovations show, brought
//! to the size that is expected of it.

use super::levels::{Level, Levels, UnknownLevels};
use super::likelihood::{LevelLikelihood, Score};
use super::solve::damped_step;

/// Steps of scoring, at most, and the largest change of a logarithm in one.
const MAX_STEPS: usize = 6;
const MAX_LOG_CHANGE: f64 = 1.5;

/// Ratio of expected to found by which the information is corrected, at most.
const MAX_CORRECTION: f64 = 30.0;

/// A step that promises less than this of the likelihood's logarithm ends the
/// search: the estimate does not feel it.
const MIN_PROMISED_GAIN: f64 = 0.1;

/// Shortening of a step that does not raise the likelihood, and the part of it from which
/// on it is given up.
const SHORTENING: f64 = 0.25;
const MIN_STEP_PART: f64 = 0.01;

/// What holds every logarithm at first, as an information, and by how much more where the
/// longest step is too long.
const START_HOLD: f64 = 0.1;
const HOLD_GROWTH: f64 = 4.0;

/// Change of a logarithm that counts as none.
const NO_CHANGE: f64 = 1e-9;

/// Corner of the disturbances' spectrum that is expected, Hz, and by which factor it may
/// well differ: a log with little disturbance says nothing of it.
pub(super) const EXPECTED_CORNER_HZ: f64 = 1.5;
const CORNER_FACTOR: f64 = 3.0;

/// Searches the levels of the greatest likelihood; returns them, and by how much
/// its logarithm grew.
///
/// - `unknown`: those that are searched; `from`: all, at the start.
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
    for _ in 0..MAX_STEPS {
        let Some((step, promised)) = scoring_step(unknown, &logs, &score) else {
            break;
        };
        if promised < MIN_PROMISED_GAIN {
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
            if part < MIN_STEP_PART {
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

/// Returns what the likelihood and what is known of the corner say at some
/// levels; the information is the expected one where only one level counts.
pub(super) fn score(
    likelihood: &LevelLikelihood<'_>,
    unknown: &UnknownLevels,
    levels: &Levels,
) -> Option<Score> {
    let mut score = likelihood.score(unknown, levels)?;
    let count = unknown.all.len();
    let scales: Vec<f64> = (unknown.all.iter().zip(&score.expected).zip(&score.gradient))
        .map(|((level, expected), own)| {
            let found = expected - own;
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

/// Returns the step of scoring within the bounds, and what it promises.
///
/// What the log hardly speaks of moves little: every logarithm is held by the
/// same amount, as much as keeps the longest step within its bound.
fn scoring_step(unknown: &UnknownLevels, logs: &[f64], score: &Score) -> Option<(Vec<f64>, f64)> {
    let (gradient, information) = (&score.gradient, &score.information);
    let count = logs.len();
    let mut fixed = vec![false; count];
    let mut hold = START_HOLD;
    loop {
        let free: Vec<usize> = (0..count).filter(|i| !fixed[*i]).collect();
        let part: Vec<f64> = (free.iter())
            .flat_map(|&i| free.iter().map(move |&j| (i, j)))
            .map(|(i, j)| {
                let own = if i == j { hold } else { 0.0 };
                own + information[i.max(j) * count + i.min(j)]
            })
            .collect();
        let own: Vec<f64> = free.iter().map(|&i| gradient[i]).collect();
        let step = damped_step(&part, &own, 0.0)?;
        if step.iter().any(|step| step.abs() > MAX_LOG_CHANGE) {
            hold *= HOLD_GROWTH;
            continue;
        }
        let mut all = vec![0.0; count];
        let mut beyond = None;
        for (&i, step) in free.iter().zip(&step) {
            let (low, high) = unknown.bounds[i];
            let inside = (logs[i] + step).clamp(low.ln(), high.ln());
            all[i] = inside - logs[i];
            let cut = (all[i] - step).abs();
            if beyond.is_none_or(|(_, most)| cut > most) && cut > NO_CHANGE {
                beyond = Some((i, cut));
            }
        }
        let promised: f64 = -0.5 * all.iter().zip(gradient).map(|(d, g)| d * g).sum::<f64>();
        match beyond {
            // A level that stands at its bound and pulls outward is none; nor
            // may one that is cut short lead the others uphill.
            Some((i, _)) if all[i].abs() < NO_CHANGE || promised <= 0.0 => fixed[i] = true,
            _ => return Some((all, promised)),
        }
    }
}
