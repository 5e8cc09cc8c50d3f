//! Delays of channels, to a fraction of a sample: by the likelihood of the log.

use super::error::IdentifyError;
use super::identify::identify;
use super::result::RefinedDelay;
use crate::check::LikelyDelay;
use crate::description::{Delay, Estimator, Experiment, OnCheckError};
use crate::log::{Channels, LogSource};
use crate::model::Model;
use crate::prepare::PrepareError;
use crate::progress::Listener;

/// Significance from which on a channel is late: standard errors that its delay is away from
/// what is assumed, and the part of a sampling period.
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
    let log = experiment.log.as_ref().ok_or(PrepareError::NoLog)?;
    let channels = Channels::new(&experiment.robot, log)?;
    let given: Vec<usize> = (channels.all.iter())
        .filter(|channel| channel.delay.is_some())
        .map(|channel| channel.joint)
        .collect();
    let mut search = LateSearch {
        now: refined(&experiment, model, sources, progress)?,
        experiment,
        model,
        sources,
        progress,
        joints: (0..model.joint_count())
            .filter(|joint| !given.contains(joint))
            .collect(),
        channels,
        found: Vec::new(),
    };
    // One late link seems to make its neighbours late: first the one is looked for
    // that explains them all, then one joint after the other.
    for explains in [Explains::EveryJoint, Explains::ItsJoint] {
        while let Some((delay, then)) = search.likeliest(explains)? {
            search.accept(delay, then);
        }
    }
    Ok(search.found)
}

/// What is to be explained by a late channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Explains {
    /// No delay of any joint is certain besides.
    EveryJoint,
    /// No other delay of its joint is.
    ItsJoint,
}

/// A search for late channels, one after the other.
struct LateSearch<'a, 's> {
    /// With the delays that were found.
    experiment: Experiment,
    model: &'a Model,
    sources: &'a mut [LogSource<'s>],
    progress: &'a mut dyn Listener,
    channels: Channels,
    /// Joints whose description gives no delay.
    joints: Vec<usize>,
    /// What the refinement says now.
    now: Refined,
    found: Vec<LikelyDelay>,
}

impl LateSearch<'_, '_> {
    /// Returns the columns of a joint.
    fn columns(&self, joint: usize) -> Vec<&str> {
        (self.channels.all.iter())
            .filter(|channel| channel.joint == joint)
            .map(|channel| channel.column.as_str())
            .collect()
    }

    /// Returns channels that may be late, of joints without one that was found, with their
    /// joints, the surest first.
    fn suspects(&self) -> Vec<(usize, RefinedDelay)> {
        let is_open = |joint: &&usize| {
            let own = self.columns(**joint);
            !(self.found.iter()).any(|delay| own.contains(&delay.column.as_str()))
        };
        let mut suspects: Vec<(usize, RefinedDelay)> = (self.joints.iter().filter(is_open))
            .flat_map(|&joint| {
                let own = self.now.suspects(&self.columns(joint));
                own.into_iter().map(move |delay| (joint, delay))
            })
            .collect();
        suspects.sort_by(|(_, a), (_, b)| sureness(b).total_cmp(&sureness(a)));
        suspects.truncate(MAX_SUSPECTS);
        suspects
    }

    /// Tries the suspects; returns the one with the greatest likelihood of those that explain
    /// the log, and what the refinement then says.
    fn likeliest(
        &mut self,
        explains: Explains,
    ) -> Result<Option<(LikelyDelay, Refined)>, IdentifyError> {
        let mut best: Option<(LikelyDelay, Refined)> = None;
        for (joint, suspect) in self.suspects() {
            let mut trial = self.experiment.clone();
            if let Some(log) = &mut trial.log {
                log.delay_s.insert(suspect.column.clone(), Delay::Estimate);
            }
            let then = refined(&trial, self.model, self.sources, self.progress)?;
            let better = (best.as_ref()).is_none_or(|(_, before)| then.loss < before.loss);
            if let Some(likely) = then.likely_delay(&suspect.column)
                && self.explained(explains, joint, &suspect.column, &then)
                && then.used
                && better
            {
                best = Some((likely, then));
            }
        }
        Ok(best)
    }

    /// Returns whether a refinement leaves no certain delay but that of one column.
    fn explained(&self, explains: Explains, joint: usize, column: &str, then: &Refined) -> bool {
        (self.joints.iter())
            .filter(|&&other| explains == Explains::EveryJoint || other == joint)
            .all(|&other| then.certain(&self.columns(other), column).is_empty())
    }

    /// Takes a delay as known.
    fn accept(&mut self, delay: LikelyDelay, then: Refined) {
        if let Some(log) = &mut self.experiment.log {
            let known = Delay::Known(delay.delay);
            log.delay_s.insert(delay.column.clone(), known);
        }
        self.now = then;
        self.found.push(delay);
    }
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

    /// Returns the delay of a column that was estimated, if it is certain.
    fn likely_delay(&self, column: &str) -> Option<LikelyDelay> {
        let delay = self.delays.iter().find(|delay| delay.column == column)?;
        let standard_error = delay.standard_error_s?;
        is_certain(delay.delay_s, standard_error, self.period).then(|| LikelyDelay {
            column: delay.column.clone(),
            delay: delay.delay_s,
            standard_error,
        })
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
