//! The prediction-error estimator: a refinement of least squares, and what there is
//! to know of it.

mod bound;
mod covariance;
mod delays;
mod descent;
mod dynamics;
mod filter;
mod findings;
mod hold_out;
mod level_gradient;
mod levels;
mod likelihood;
mod measurements;
mod noisy_torque;
mod refine;
mod solve;
#[cfg(test)]
mod tests;
mod unknowns;

use super::found::{Criterion, Found, NORMAL_95, Numbers};
use super::least_squares::{Fitted, trace};
use super::result::{
    HeldOutResidual, RefinedDelay, RefinedOffset, Refinement, RowDisturbance, SensorNoise,
};
use crate::description::Delay;
use crate::finding::{Finding, Severity};
use crate::log::{Channels, LogSource};
use crate::model::Model;
use crate::prepare::Excerpt;
use crate::progress::{Listener, Phase};
use crate::regression::{PassError, Reading, System};
use crate::stopwatch::Stopwatch;
pub use bound::{KnownNoise, information_bound};
pub(super) use delays::likely_delays;
use findings::{about, correlations, stands_back};
use hold_out::{HeldOut, held_out};
use refine::{Refined, Start, refine};

/// What a refinement begins with.
#[derive(Clone, Copy)]
pub(super) struct Before<'a> {
    /// The beginning of the first log.
    pub(super) excerpt: &'a Excerpt,
    pub(super) system: &'a System,
    pub(super) fitted: &'a Fitted,
    /// Values to start from instead of the fitted ones, \[p\].
    pub(super) nominal: Option<&'a [f64]>,
    /// What was noticed about the logs; where their columns are wrong, the
    /// refinement is not tried, for it may take minutes to fail.
    pub(super) about_logs: &'a [Finding],
}

/// Refines what least squares found.
///
/// Where that fails, the linear values stand and a finding says why.
///
/// - `progress`: called when a run of the filter begins.
///
/// # Errors
///
/// [`PassError`] if a log cannot be read again.
pub(super) fn prediction_error(
    reading: &Reading,
    sources: &mut [LogSource<'_>],
    before: Before<'_>,
    progress: &mut dyn Listener,
) -> Result<Found, PassError> {
    let Before {
        excerpt,
        system,
        fitted,
        nominal,
        about_logs,
    } = before;
    let begin = Stopwatch::start();
    let (model, channels) = (reading.model(), reading.channels());
    let parameters = model.parameters().iter();
    let free: Vec<usize> = (parameters.zip(&fitted.identifiable).enumerate())
        .filter(|(_, (parameter, known))| **known && parameter.fixed.is_none())
        .map(|(i, _)| i)
        .collect();
    let start = Start {
        theta: nominal.unwrap_or(&fitted.theta),
        free,
        exact_torque: channels.exact_torque,
        delays: (0..channels.all.len())
            .filter(|&i| channels.all[i].delay == Some(Delay::Estimate))
            .collect(),
    };
    let wrong = (about_logs.iter()).find(|finding| {
        finding.severity >= Severity::Serious || finding.code == "looks-like-degrees"
    });
    let refined = match wrong {
        Some(_) => None,
        None => refine(reading, sources, excerpt, &start, Phase::Refining, progress)?,
    };
    let held = (refined.as_ref()).and_then(|refined| held_out(model, system, refined));
    let mut findings = Vec::new();
    let failure = match &refined {
        None if let Some(wrong) = wrong => Some(format!(
            "it was not tried, for the log itself is wrong ({})",
            wrong.code
        )),
        None => Some(
            "the filter does not follow the log from the linear values, or the log is too short"
                .to_owned(),
        ),
        Some(refined) => failure(model, refined).or_else(|| held.and_then(HeldOut::unpredictive)),
    };
    if let Some(refined) = &refined {
        findings.extend(about(reading, excerpt.period(), refined));
    }
    let used = failure.is_none();
    let refinement = (refined.as_ref()).map(|r| describe(model, channels, r, held, used));
    Ok(match (refined, failure) {
        (Some(refined), None) => Found {
            numbers: Numbers {
                theta: refined.theta,
                errors: refined.standard_error,
                seen: fitted.identifiable.clone(),
                interval: NORMAL_95,
                points: (refined.trace.into_iter())
                    .map(|(time, theta)| (time, Some(theta)))
                    .collect(),
                criterion: Criterion::Likelihood(refinement.map(Box::new)),
                elapsed: begin.seconds(),
            },
            findings,
        },
        (_, failure) => {
            findings.insert(0, stands_back(&failure.unwrap_or_default()));
            Found {
                numbers: Numbers {
                    points: trace(model, system).collect(),
                    criterion: Criterion::Likelihood(refinement.map(Box::new)),
                    elapsed: begin.seconds(),
                    ..Numbers::of(fitted)
                },
                findings,
            }
        }
    })
}

/// Says why a refinement is not to be used.
fn failure(model: &Model, refined: &Refined) -> Option<String> {
    let bound: Vec<String> = (refined.levels.iter().enumerate())
        .filter(|(_, level)| level.at_bound)
        .map(|(row, _)| model.row_name(row))
        .collect();
    if !bound.is_empty() {
        return Some(format!(
            "in {} the torque that the model does not explain is a quarter of the motor's or more, \
             which is not a disturbance but an effect that the model lacks",
            bound.join(", ")
        ));
    }
    if refined.converged {
        return None;
    }
    let moved = refined
        .moved
        .iter()
        .take(3)
        .map(|(index, by)| format!("{} by {by:+.2}", model.parameters()[*index].short()));
    Some(format!(
        "it did not converge in {} runs of the filter; last moved, in standard errors, {}",
        refined.runs,
        moved.collect::<Vec<_>>().join(", ")
    ))
}

fn describe(
    model: &Model,
    channels: &Channels,
    refined: &Refined,
    held: Option<HeldOut>,
    used: bool,
) -> Refinement {
    let name = |index: usize| model.parameters()[index].name.clone();
    let column = |channel: usize| channels.all[channel].column.clone();
    Refinement {
        used,
        converged: refined.converged,
        runs: refined.runs,
        samples: refined.samples,
        duration_s: refined.duration,
        measurements: refined.measurements,
        minus_log_likelihood: refined.loss,
        disturbances: (refined.levels.iter().enumerate())
            .map(|(row, level)| RowDisturbance {
                row: model.row_name(row),
                torque_noise_nm: level.white,
                disturbance_nm: level.drift,
                torque_nm: level.torque,
                at_bound: level.at_bound,
            })
            .collect(),
        disturbance_corner_hz: refined.corner,
        cost_per_measurement: refined.cost,
        held_out_residual: held.map(|held| HeldOutResidual {
            refined: held.refined,
            linear: held.linear,
        }),
        sensor_noise: (refined.sensors.iter())
            .map(|&(channel, noise, shown)| SensorNoise {
                column: column(channel),
                noise_rad: noise,
                deviation_rad: shown,
            })
            .collect(),
        encoder_offsets: (refined.offsets.iter())
            .map(|&(joint, channel, offset, error)| RefinedOffset {
                joint: model.joints()[joint].clone(),
                column: column(channel),
                offset_rad: offset,
                standard_error_rad: error,
            })
            .collect(),
        delays: (refined.delays.iter())
            .map(|delay| RefinedDelay {
                column: column(delay.channel),
                delay_s: delay.assumed + delay.beyond,
                standard_error_s: Some(delay.standard_error).filter(|e| e.is_finite()),
                used_s: delay.assumed,
            })
            .collect(),
        correlations: (correlations(refined).into_iter())
            .map(|(a, b, correlation)| (name(a), name(b), correlation))
            .collect(),
        each_log: (refined.logs.iter())
            .map(|log| {
                let own = |index| refined.free.iter().position(|free| *free == index);
                (0..model.parameters().len())
                    .map(|index| own(index).map(|place| log[place]))
                    .collect()
            })
            .collect(),
    }
}
