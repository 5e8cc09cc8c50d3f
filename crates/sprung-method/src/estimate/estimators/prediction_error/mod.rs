//! The prediction-error estimator: refines the estimate of least squares and judges the refinement.
//! NOTATION.md contains the equations.

mod before;
mod bound;
mod channel_updates;
mod constrained;
mod covariance;
mod descent;
mod describe;
mod disturbance_cap;
mod dynamics;
mod effects;
mod expected_time;
mod filter;
mod findings;
mod finish;
mod hold_out;
mod ladder;
mod level_search;
mod levels;
mod likelihood;
mod matrix;
mod measurements;
mod noisy_torque;
mod open_velocities;
mod parts;
mod presliding_levels;
mod problem;
mod refine;
mod refined;
mod residual_ratio;
mod retiming;
mod reversals;
mod rung;
mod sandwich;
mod solve;
mod start_levels;
mod state_layout;
mod status;
#[cfg(test)]
mod tests;
mod undeclared;
mod undeclared_findings;
mod unknowns;
mod vector;

use sprung_core::parameters::JointParameter;

use crate::description::Delay;
use crate::estimate::estimators::estimator_result::{Covariance, Criterion, Found, Numbers};
use crate::estimate::estimators::least_squares::linear_numbers;
use crate::estimate::result::ErrorParts;
use crate::estimate::statistics::NORMAL_95;
use crate::finding::{Finding, Severity};
use crate::fit::{Fitted, trace};
use crate::log::LogSource;
use crate::prepare::OPEN_STIFFNESS;
use crate::progress::{Listener, Phase};
use crate::regression::{PassError, Reading};
use crate::stopwatch::Stopwatch;
pub(in crate::estimate) use before::Before;
pub use bound::{Bound, KnownNoise, KnownTruth, information_bound};
use describe::describe;
use effects::TorquesTiming;
use findings::about;
use ladder::{Climbed, Tried, choose, climb, nearest};
use measurements::{Extent, samples_in};
pub(in crate::estimate) use open_velocities::likely;
use refine::{Refinery, Start};
use refined::Refined;
use residual_ratio::Guard;
pub(in crate::estimate) use retiming::{Retiming, Timing};
use retiming::{contradicted, timing_of};
use rung::Rung;
use start_levels::TorqueNoise;
use status::Status;
use undeclared::bias;
use undeclared_findings::about_undeclared;

/// Least start value of a rotor inertia or stiffness, in its standard errors.
const INSIDE: f64 = 0.3;

/// Refines the estimate of least squares: climb the ladder, choose a rung, describe it.
///
/// If no rung can be used, the result contains the linear values and a finding with the reasons. If the likelihood
/// shows another timing, the refinement ends early with it.
///
/// - `progress`: is called before each run of the filter.
///
/// # Errors
///
/// [`PassError`] if a log cannot be read again or the listener requests a stop.
pub(in crate::estimate) fn prediction_error(
    reading: &Reading,
    sources: &mut [LogSource<'_>],
    before: Before<'_>,
    progress: &mut dyn Listener,
) -> Result<Refinements, PassError> {
    let begin = Stopwatch::start();
    let (model, excerpt) = (reading.model(), before.excerpt);
    let theta = start_values(reading, &before);
    let start = start(reading, &before, &theta);
    let wrong = wrong_log(before.about_logs);
    let (mut tried, mut missing) = (Vec::new(), Vec::new());
    if wrong.is_none() {
        let memory = reading.settings().refinement_memory_mib;
        let limit = samples_in(memory, model, reading.channels());
        let extent = (Phase::Refining, Extent::Spread(limit));
        if let Some(refinery) = Refinery::new(reading, sources, excerpt, &start, extent)? {
            // A search from nominal values passes through worse ones.
            let guard = match before.nominal {
                Some(_) => None,
                None => Guard::new(model, before.system, &before.fitted.theta),
            };
            let refinery = refinery.with_guard(guard).with_possible(before.possible);
            let climbed = climb(&refinery, &before, progress)?;
            tried = match climbed {
                Climbed::Tried(tried) => tried,
                Climbed::Retimed(retiming) => return Ok(Refinements::Retimed(retiming)),
            };
            if let Some(used) = choose(&tried).map(|index| &tried[index])
                && let Some(end) = &used.end
                && !end.refined.is_outweighed_by_noise()
            {
                missing = refinery.undeclared(used.rung, end, before.experiment)?;
            }
        }
    }
    let used = choose(&tried);
    let status = match wrong {
        Some(wrong) => Status::NotTried {
            code: wrong.code.clone(),
        },
        None => Status::of(model, &tried, used),
    };
    let shown = (used.or_else(|| nearest(&tried))).map(|index| tried.swap_remove(index));
    let mut findings: Vec<Finding> = status.finding().into_iter().collect();
    let mut listed = Vec::new();
    if let Some(refined) = shown.as_ref().and_then(Tried::refined) {
        let (unknowns, mut notes): (Vec<_>, Vec<Finding>) =
            about_undeclared((reading, excerpt), refined, &missing)
                .into_iter()
                .unzip();
        notes.extend(about(reading, refined));
        let contradicted = contradicted(reading, excerpt, refined);
        if !refined.converged() || contradicted.is_some() {
            // Away from the maximum of the likelihood, or with a wrong timing, every effect seems to be missing.
            notes.iter_mut().for_each(Finding::note);
        } else if status.is_used() {
            listed = unknowns;
        }
        findings.extend(notes);
        findings.extend(contradicted.filter(|_| refined.converged()));
    }
    let refinement =
        (shown.as_ref()).and_then(|shown| describe(model, reading.channels(), shown, &status));
    let rung = shown.as_ref().map_or(Rung::Free, |shown| shown.rung);
    let numbers = match shown
        .and_then(|shown| shown.end)
        .map(|end| end.refined)
        .filter(|_| status.is_used())
    {
        Some(refined) => {
            let bias: Vec<f64> = (bias(&refined, &missing).iter().zip(before.by_gains))
                .map(|(bias, by_gain)| bias.hypot(*by_gain))
                .collect();
            refined_numbers(refined, rung, before.fitted, &bias)
        }
        None => Numbers {
            points: trace(model, before.system).collect(),
            ..linear_numbers(before.fitted, before.possible)
        },
    };
    Ok(Refinements::Found(Box::new(Found {
        numbers: Numbers {
            criterion: Criterion::Likelihood(refinement.map(Box::new)),
            elapsed: begin.seconds(),
            ..numbers
        },
        findings,
        unknowns: listed,
    })))
}

/// End of a refinement.
pub(in crate::estimate) enum Refinements {
    Found(Box<Found>),
    /// The regression is to be repeated with another timing, and the refinement with it.
    Retimed(Box<Retiming>),
}

/// Returns the start values of a refinement, \[p\]. If least squares do not determine the stiffness of a joint without
/// link encoder, its start is that of the preparation.
fn start_values(reading: &Reading, before: &Before<'_>) -> Vec<f64> {
    let (model, fitted) = (reading.model(), before.fitted);
    let mut theta = before.nominal.unwrap_or(&fitted.theta).to_vec();
    for joint in model.joints_without_link() {
        let index = model.index(JointParameter::Stiffness, joint);
        if let Some((index, known)) = index.zip(model.known_stiffness(joint)) {
            let error = fitted.standard_error[index];
            if error.is_nan() || error > OPEN_STIFFNESS * theta[index] {
                theta[index] = known;
            }
        }
    }
    if before.possible.is_some() && before.nominal.is_none() {
        // Motors and springs at their bound have motions that no time step resolves.
        for (i, parameter) in model.parameters().iter().enumerate() {
            let is_vital = parameter.joint.is_some_and(|(kind, _)| kind.is_vital());
            let least = INSIDE * fitted.standard_error[i];
            if is_vital && fitted.identifiable[i] && least.is_finite() {
                theta[i] = theta[i].max(least);
            }
        }
    }
    theta
}

/// Returns the start of a refinement after least squares.
fn start<'a>(reading: &Reading, before: &Before<'_>, theta: &'a [f64]) -> Start<'a> {
    let (model, channels) = (reading.model(), reading.channels());
    let parameters = model.parameters().iter();
    let free = (parameters.zip(&before.fitted.identifiable).enumerate())
        .filter(|(i, (parameter, known))| {
            // Least squares with signs leave elements of a curve at zero that the log does not need.
            let of_curve = parameter.joint.is_some_and(|(kind, _)| kind.is_of_curve());
            **known && parameter.fixed.is_none() && !(of_curve && theta[*i] <= 0.0)
        })
        .map(|(i, _)| i)
        .collect();
    Start {
        theta,
        free,
        torque_noise: TorqueNoise::of(channels, before.excerpt.period()),
        torques: match before.timing {
            Timing::Found(retiming) if retiming.torques.is_some() => TorquesTiming::Estimated,
            Timing::Found(_) | Timing::Open => timing_of(reading),
        },
        delays: (0..channels.all.len())
            .filter(|&i| channels.all[i].delay == Some(Delay::Estimate))
            .collect(),
    }
}

/// Returns the finding that makes a log faulty, if there is one.
fn wrong_log(about_logs: &[Finding]) -> Option<&Finding> {
    (about_logs.iter()).find(|finding| finding.severity >= Severity::Serious)
}

/// Returns the numerical result of a refinement that is used.
///
/// A lower rung is used because the model lacks an effect, so estimators with different weights
/// converge to different values. Then the difference from least squares beyond both standard errors
/// counts as a bias. The last rung takes slow disturbances for white noise, so its sampling error
/// is at least that of least squares, which comes from segments of the log.
///
/// - `undeclared`: possible errors by effects that the model lacks, \[p\].
fn refined_numbers(refined: Refined, rung: Rung, fitted: &Fitted, undeclared: &[f64]) -> Numbers {
    let error_parts: Vec<ErrorParts> = (0..refined.theta.len())
        .map(|i| {
            if fitted.identifiable[i] && !refined.free.contains(&i) {
                return ErrorParts {
                    sampling: fitted.standard_error[i],
                    between_parts: 0.0,
                    bias: 0.0,
                };
            }
            let (error, between) = (refined.standard_error[i], refined.between_parts[i]);
            let within = (error.powi(2) - between.powi(2)).max(0.0).sqrt();
            let both = error.hypot(fitted.standard_error[i]);
            let difference = refined.theta[i] - fitted.theta[i];
            let excess = (difference.powi(2) - both.powi(2)).max(0.0).sqrt();
            ErrorParts {
                sampling: match rung {
                    Rung::Flat => within.max(fitted.sampling_error[i]),
                    Rung::Free | Rung::Cap10 | Rung::Cap3 => within,
                },
                between_parts: between,
                bias: match rung {
                    Rung::Cap10 | Rung::Cap3 | Rung::Flat if excess.is_finite() => {
                        excess.max(undeclared[i])
                    }
                    Rung::Free | Rung::Cap10 | Rung::Cap3 | Rung::Flat => undeclared[i],
                },
            }
        })
        .collect();
    Numbers {
        errors: (error_parts.iter())
            .map(|parts| parts.sampling.hypot(parts.between_parts).hypot(parts.bias))
            .collect(),
        error_parts,
        covariance: Some(Covariance {
            free: refined.free,
            values: refined.covariance,
        }),
        theta: refined.theta,
        unconstrained: refined.unconstrained,
        interval: NORMAL_95,
        points: (refined.parts.trace.into_iter())
            .map(|(time, theta)| (time, Some(theta)))
            .collect(),
        ..Numbers::of(fitted)
    }
}
