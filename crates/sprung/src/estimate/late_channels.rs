//! Delays of channels, to a fraction of a sample: by the likelihood of the log.

use super::error::IdentifyError;
use super::identify::identify;
use super::result::RefinedDelay;
use crate::check::LikelyDelay;
use crate::description::{Delay, Estimator, Experiment, OnCheckError};
use crate::log::{Channels, LogSource};
use crate::model::Model;
use crate::progress::Listener;

/// Standard errors that a delay must be away from what is assumed, and the part
/// of a sampling period.
const DELAY_SIGNIFICANCE_SIGMAS: f64 = 5.0;
const MIN_DELAY_SAMPLES: f64 = 0.05;

/// Channels that are tried in a round, the surest first.
const MAX_SUSPECTS: usize = 12;

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
    progress: &mut dyn Listener,
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
    let joints: Vec<usize> = (0..model.joint_count())
        .filter(|joint| !given.contains(joint))
        .collect();
    let mut found: Vec<LikelyDelay> = Vec::new();
    // One late link seems to make its neighbours late: first the one is looked for
    // that explains them all, then one joint after the other.
    for alone in [true, false] {
        loop {
            let done = |joint: &&usize| {
                let own = columns(**joint);
                !found
                    .iter()
                    .any(|delay| own.contains(&delay.column.as_str()))
            };
            let open: Vec<usize> = joints.iter().filter(done).copied().collect();
            let mut suspects: Vec<(usize, RefinedDelay)> = (open.iter())
                .flat_map(|&joint| {
                    let own = now.suspects(&columns(joint));
                    own.into_iter().map(move |delay| (joint, delay))
                })
                .collect();
            suspects.sort_by(|(_, a), (_, b)| sureness(b).total_cmp(&sureness(a)));
            suspects.truncate(MAX_SUSPECTS);
            let mut best: Option<(LikelyDelay, Refined)> = None;
            for (joint, suspect) in suspects {
                let mut trial = experiment.clone();
                if let Some(log) = &mut trial.log {
                    log.delay_s.insert(suspect.column.clone(), Delay::Estimate);
                }
                let then = refined(&trial, model, sources, progress)?;
                let explained = (joints.iter())
                    .filter(|&&other| alone || other == joint)
                    .all(|&other| then.certain(&columns(other), &suspect.column).is_empty());
                let own = then
                    .delays
                    .iter()
                    .find(|delay| delay.column == suspect.column);
                let better = (best.as_ref()).is_none_or(|(_, before)| then.loss < before.loss);
                if let Some(delay) = own
                    && let Some(standard_error) = delay.standard_error_s
                    && explained
                    && then.used
                    && better
                    && is_certain(delay.delay_s, standard_error, then.period)
                {
                    let likely = LikelyDelay {
                        column: delay.column.clone(),
                        delay: delay.delay_s,
                        standard_error,
                    };
                    best = Some((likely, then));
                }
            }
            let Some((delay, then)) = best else { break };
            if let Some(log) = &mut experiment.log {
                let known = Delay::Known(delay.delay);
                log.delay_s.insert(delay.column.clone(), known);
            }
            now = then;
            found.push(delay);
        }
    }
    Ok(found)
}

/// What a refinement says of delays.
struct Refined {
    delays: Vec<RefinedDelay>,
    period: f64,
    // Whether it is used.
    used: bool,
    // Minus the logarithm of the likelihood of a measurement.
    loss: f64,
}

impl Refined {
    /// Delays of some columns that are certain, but that of one column.
    fn certain(&self, columns: &[&str], but: &str) -> Vec<RefinedDelay> {
        (self.delays.iter())
            .filter(|delay| columns.contains(&delay.column.as_str()) && delay.column != but)
            .filter(|delay| {
                let beyond = delay.delay_s - delay.used_s;
                (delay.standard_error_s).is_some_and(|error| is_certain(beyond, error, self.period))
            })
            .cloned()
            .collect()
    }

    /// Delays that may explain the log: those that are certain, or if the refinement
    /// failed, which a long delay may cause, all.
    fn suspects(&self, columns: &[&str]) -> Vec<RefinedDelay> {
        if self.used {
            return self.certain(columns, "");
        }
        (columns.iter())
            .map(|&column| {
                let known = self.delays.iter().find(|delay| delay.column == column);
                known.cloned().unwrap_or(RefinedDelay {
                    column: column.to_owned(),
                    delay_s: 0.0,
                    standard_error_s: None,
                    used_s: 0.0,
                })
            })
            .collect()
    }
}

fn is_certain(delay: f64, standard_error: f64, period: f64) -> bool {
    delay.abs() > DELAY_SIGNIFICANCE_SIGMAS * standard_error
        && delay.abs() > MIN_DELAY_SAMPLES * period
}

fn refined(
    experiment: &Experiment,
    model: &Model,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<Refined, IdentifyError> {
    let found = identify(experiment, model, sources, progress)?.identification;
    let refinement = (found.results.first()).and_then(|result| result.refinement.as_ref());
    Ok(Refined {
        delays: refinement.map_or_else(Vec::new, |refinement| refinement.delays.clone()),
        period: found.log.period_s,
        used: refinement.is_some_and(|refinement| refinement.used),
        loss: refinement.map_or(f64::INFINITY, |refinement| {
            refinement.minus_log_likelihood / refinement.measurements.max(1) as f64
        }),
    })
}

/// How many standard errors a delay is away from what was assumed.
fn sureness(delay: &RefinedDelay) -> f64 {
    (delay.standard_error_s).map_or(0.0, |error| (delay.delay_s - delay.used_s).abs() / error)
}
