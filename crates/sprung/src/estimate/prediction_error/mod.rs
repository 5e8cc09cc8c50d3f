//! The prediction-error estimator: refines the estimate of least squares and judges the refinement.
//! NOTATION.md contains the equations.

mod bound;
mod covariance;
mod delay_updates;
mod delays;
mod descent;
mod describe;
mod dynamics;
mod filter;
mod findings;
mod finish;
mod hold_out;
mod level_search;
mod levels;
mod likelihood;
mod measurements;
mod noisy_torque;
mod problem;
mod refine;
mod refined;
mod solve;
mod start_levels;
mod status;
#[cfg(test)]
mod tests;
mod unknowns;
mod vector;

use super::found::{Criterion, Found, NORMAL_95, Numbers};
use crate::description::Delay;
use crate::finding::{Finding, Severity};
use crate::fit::{Fitted, trace};
use crate::log::LogSource;
use crate::prepare::Excerpt;
use crate::progress::{Listener, Phase};
use crate::regression::{PassError, Reading, System};
use crate::stopwatch::Stopwatch;
pub use bound::{KnownNoise, information_bound};
pub(super) use delays::likely_delays;
use describe::describe;
use findings::about;
use hold_out::held_out;
use refine::{Start, refine};
use refined::Refined;
use start_levels::TorqueNoise;
use status::Status;

/// Inputs of a refinement.
#[derive(Clone, Copy)]
pub(super) struct Before<'a> {
    /// The beginning of the first log.
    pub(super) excerpt: &'a Excerpt,
    pub(super) system: &'a System,
    pub(super) fitted: &'a Fitted,
    /// Start values instead of the fitted ones, \[p\].
    pub(super) nominal: Option<&'a [f64]>,
    /// Findings about the logs. If a log itself is faulty, the refinement is not tried, because it
    /// may take minutes to fail.
    pub(super) about_logs: &'a [Finding],
}

/// Refines the estimate of least squares: refine, hold out, judge.
///
/// If the refinement fails, the result contains the linear values and a finding with the reason.
///
/// - `progress`: is called before each run of the filter.
///
/// # Errors
///
/// [`PassError`] if a log cannot be read again or the listener asks to stop.
pub(super) fn prediction_error(
    reading: &Reading,
    sources: &mut [LogSource<'_>],
    before: Before<'_>,
    progress: &mut dyn Listener,
) -> Result<Found, PassError> {
    let begin = Stopwatch::start();
    let (model, excerpt) = (reading.model(), before.excerpt);
    let start = start(reading, &before);
    let wrong = wrong_log(before.about_logs);
    let refined = match wrong {
        Some(_) => None,
        None => refine(reading, sources, excerpt, &start, Phase::Refining, progress)?,
    };
    let held = (refined.as_ref()).and_then(|refined| held_out(model, before.system, refined));
    let status = match (&refined, wrong) {
        (_, Some(wrong)) => Status::NotTried {
            code: wrong.code.clone(),
        },
        (None, None) => Status::NotFollowed,
        (Some(refined), None) => Status::of(model, refined, held),
    };
    let mut findings: Vec<Finding> = status.finding().into_iter().collect();
    if let Some(refined) = &refined {
        findings.extend(about(reading, excerpt.period(), refined));
    }
    let refinement = (refined.as_ref())
        .map(|refined| describe(model, reading.channels(), refined, held, &status));
    let numbers = match refined.filter(|_| status.is_used()) {
        Some(refined) => refined_numbers(refined, before.fitted),
        None => Numbers {
            points: trace(model, before.system).collect(),
            ..Numbers::of(before.fitted)
        },
    };
    Ok(Found {
        numbers: Numbers {
            criterion: Criterion::Likelihood(refinement.map(Box::new)),
            elapsed: begin.seconds(),
            ..numbers
        },
        findings,
    })
}

/// Returns the start of a refinement after least squares.
fn start<'a>(reading: &Reading, before: &Before<'a>) -> Start<'a> {
    let (model, channels) = (reading.model(), reading.channels());
    let parameters = model.parameters().iter();
    let free = (parameters.zip(&before.fitted.identifiable).enumerate())
        .filter(|(_, (parameter, known))| **known && parameter.fixed.is_none())
        .map(|(i, _)| i)
        .collect();
    Start {
        theta: before.nominal.unwrap_or(&before.fitted.theta),
        free,
        torque_noise: TorqueNoise::of(channels),
        delays: (0..channels.all.len())
            .filter(|&i| channels.all[i].delay == Some(Delay::Estimate))
            .collect(),
    }
}

/// Returns a finding that a log itself is faulty, if there is one.
fn wrong_log(about_logs: &[Finding]) -> Option<&Finding> {
    about_logs.iter().find(|finding| {
        finding.severity >= Severity::Serious || finding.code == "looks-like-degrees"
    })
}

/// Returns the numerical result of a refinement that is used.
fn refined_numbers(refined: Refined, fitted: &Fitted) -> Numbers {
    Numbers {
        theta: refined.theta,
        errors: refined.standard_error,
        interval: NORMAL_95,
        points: (refined.trace.into_iter())
            .map(|(time, theta)| (time, Some(theta)))
            .collect(),
        ..Numbers::of(fitted)
    }
}
