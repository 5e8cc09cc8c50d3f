//! Delays of channels, to a fraction of a sample: by the likelihood of the log.

use super::identify::{IdentifyError, identify};
use super::progress::Progress;
use super::result::RefinedDelay;
use crate::check::LikelyDelay;
use crate::description::{Delay, Estimator, Experiment, OnCheckError};
use crate::log::{Channels, LogSource};
use crate::model::Model;

/// Standard errors that a delay must be away from what is assumed, and the part
/// of a sampling period.
const CERTAIN: f64 = 5.0;
const PART: f64 = 0.05;

/// Refinements with a channel's delay, each from where the last one ended.
const ROUNDS: usize = 5;

/// Finds channels that come late by the likelihood of the logs.
///
/// A refinement says of every channel how late it seems to be; the likeliest of a
/// joint is taken for late, and the next refinement, with its delay undone, says
/// whether that explains them all. Nothing is said of joints whose description gives
/// a delay.
///
/// Takes as long as a few identifications.
///
/// # Errors
///
/// [`IdentifyError`] as [`identify`].
pub fn late_channels(
    experiment: &Experiment,
    model: &Model,
    sources: &mut [LogSource<'_>],
    progress: &mut (dyn FnMut(Progress) + Send),
) -> Result<Vec<LikelyDelay>, IdentifyError> {
    let mut experiment = experiment.clone();
    experiment.identify.estimator = vec![Estimator::PredictionError];
    experiment.identify.on_check_error = OnCheckError::GoOn;
    let log = experiment.log.as_ref().ok_or(IdentifyError::NoLog)?;
    let channels = Channels::new(&experiment.robot, log)?;
    let mut now = refined(&experiment, model, sources, progress)?;
    let given: Vec<usize> = (channels.all.iter())
        .filter(|channel| channel.delay.is_some())
        .map(|channel| channel.joint)
        .collect();
    let columns = |joint: usize| -> Vec<&str> {
        (channels.all.iter())
            .filter(|channel| channel.joint == joint)
            .map(|channel| channel.column.as_str())
            .collect()
    };
    let mut found: Vec<LikelyDelay> = Vec::new();
    // One late link seems to make its neighbours late: first the one is looked for
    // that explains them all, the surest first, then one joint after the other.
    for alone in [true, false] {
        let mut tried: Vec<String> = Vec::new();
        while let Some((joint, suspect)) = (0..model.joint_count())
            .filter(|joint| !given.contains(joint))
            .flat_map(|joint| {
                let suspects = own(&now.delays, &columns(joint), now.period);
                suspects.into_iter().map(move |suspect| (joint, suspect))
            })
            .filter(|(_, suspect)| !tried.contains(&suspect.column))
            .max_by(|(_, a), (_, b)| sureness(a).total_cmp(&sureness(b)))
        {
            tried.push(suspect.column.clone());
            let mut trial = experiment.clone();
            let Some((delay, then)) =
                settle(&mut trial, &suspect, (model, sources, progress), now.period)?
            else {
                continue;
            };
            let explained = (0..model.joint_count())
                .filter(|other| alone || *other == joint)
                .all(|other| own(&then.delays, &columns(other), then.period).is_empty());
            if explained {
                experiment = trial;
                now = then;
                found.push(delay);
            }
        }
    }
    Ok(found)
}

/// What a refinement says of delays.
struct Refined {
    delays: Vec<RefinedDelay>,
    period: f64,
}

fn refined(
    experiment: &Experiment,
    model: &Model,
    sources: &mut [LogSource<'_>],
    progress: &mut (dyn FnMut(Progress) + Send),
) -> Result<Refined, IdentifyError> {
    let found = identify(experiment, model, sources, progress)?.identification;
    let refinement = found.results.first().and_then(|result| result.refined());
    Ok(Refined {
        delays: refinement.map_or_else(Vec::new, |refinement| refinement.delays.clone()),
        period: found.log.period_s,
    })
}

/// How many standard errors a delay is away from what was assumed.
fn sureness(delay: &RefinedDelay) -> f64 {
    (delay.standard_error_s).map_or(0.0, |error| (delay.delay_s - delay.used_s).abs() / error)
}

/// Delays of some columns that are not what was assumed.
fn own(delays: &[RefinedDelay], columns: &[&str], period: f64) -> Vec<RefinedDelay> {
    (delays.iter())
        .filter(|delay| columns.contains(&delay.column.as_str()))
        .filter(|delay| {
            sureness(delay) > CERTAIN && (delay.delay_s - delay.used_s).abs() > PART * period
        })
        .cloned()
        .collect()
}

/// Undoes a delay until the likelihood asks for no more of it; returns it and what
/// is left of others, or nothing if it does not settle.
fn settle(
    trial: &mut Experiment,
    suspect: &RefinedDelay,
    (model, sources, progress): (
        &Model,
        &mut [LogSource<'_>],
        &mut (dyn FnMut(Progress) + Send),
    ),
    period: f64,
) -> Result<Option<(LikelyDelay, Refined)>, IdentifyError> {
    let mut delay = suspect.delay_s;
    for _ in 0..ROUNDS {
        if let Some(log) = &mut trial.log {
            log.delay_s
                .insert(suspect.column.clone(), Delay::Known(delay));
        }
        let found = refined(trial, model, sources, progress)?;
        let own = (found.delays.iter()).find(|next| next.column == suspect.column);
        let Some(next) = own.cloned() else {
            return Ok(None);
        };
        let Some(error) = next.standard_error_s else {
            return Ok(None);
        };
        let step = next.delay_s - delay;
        delay = next.delay_s;
        if step.abs() < (0.5 * error).max(0.01 * period) {
            let likely = LikelyDelay {
                column: next.column,
                delay,
                standard_error: error,
            };
            return Ok(Some((likely, found)));
        }
    }
    Ok(None)
}
