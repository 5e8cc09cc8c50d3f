//! Delays of channels to a fraction of a sample, by the likelihood of the log.

use std::cmp::Ordering;

use super::delay_test::{MIN_DELAY_SAMPLES, is_significant};
use super::error::IdentifyError;
use super::identify::identify;
use super::refinement_result::RefinedDelay;
use crate::check::LikelyDelay;
use crate::description::{Delay, Estimator, Experiment, OnCheckError};
use crate::log::{Channels, LogSource};
use crate::model::Model;
use crate::prepare::PrepareError;
use crate::progress::Listener;

/// Largest difference of an accepted delay from the delay with which the logs were read, in standard
/// errors.
const MAX_REST_SIGMAS: f64 = 3.0;

/// Maximum number of channels tried in one round, the most significant first.
const MAX_SUSPECTS: usize = 12;

/// Finds channels that are recorded late, by the likelihood of the logs.
///
/// A refinement estimates the delay of every channel. The search repeats the refinement with the
/// delay of one suspected channel estimated. It accepts the channel with the greatest likelihood
/// among those that leave no other significant delay. Joints whose description gives a delay are
/// not searched.
///
/// The search takes as long as several identifications.
///
/// # Errors
///
/// [`IdentifyError`] as for [`identify`].
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
    // One late link channel makes its neighbours seem late. So the search first looks for a channel
    // that explains all delays, then for one channel per joint.
    for explains in [Explains::EveryJoint, Explains::ItsJoint] {
        while let Some((delay, then)) = search.likeliest(explains)? {
            search.accept(delay, then);
        }
    }
    Ok(search.found)
}

/// Set of delays that a late channel has to explain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Explains {
    /// No other channel of any joint has a significant delay.
    EveryJoint,
    /// No other channel of the same joint has a significant delay.
    ItsJoint,
}

/// A search for late channels that accepts one channel at a time.
struct LateSearch<'a, 's> {
    /// The experiment with the delays found so far.
    experiment: Experiment,
    model: &'a Model,
    sources: &'a mut [LogSource<'s>],
    progress: &'a mut dyn Listener,
    channels: Channels,
    /// Joints whose description gives no delay.
    joints: Vec<usize>,
    /// Result of the refinement with the delays found so far.
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

    /// Returns channels that may be late, with their joints, the most significant first. Joints
    /// with a channel already found are left out.
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
        suspects.sort_by(|(_, a), (_, b)| significance(b).total_cmp(&significance(a)));
        suspects.truncate(MAX_SUSPECTS);
        suspects
    }

    /// Tries the suspected channels. Returns the one with the greatest likelihood among those that
    /// explain the log, with its refinement.
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
            let better = (best.as_ref()).is_none_or(|(_, before)| then.is_likelier(before));
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

    /// Returns whether a refinement leaves no significant delay except that of one column.
    fn explained(&self, explains: Explains, joint: usize, column: &str, then: &Refined) -> bool {
        (self.joints.iter())
            .filter(|&&other| explains == Explains::EveryJoint || other == joint)
            .all(|&other| then.significant(&self.columns(other), column).is_empty())
    }

    /// Accepts a delay: the experiment contains it as a known delay from now on.
    fn accept(&mut self, delay: LikelyDelay, then: Refined) {
        if let Some(log) = &mut self.experiment.log {
            let known = Delay::Known(delay.delay);
            log.delay_s.insert(delay.column.clone(), known);
        }
        self.now = then;
        self.found.push(delay);
    }
}

/// Delays and likelihood of a refinement.
struct Refined {
    delays: Vec<RefinedDelay>,
    period: f64,
    // Whether the refinement is used.
    used: bool,
    // Place of its rung in the ladder.
    rung: usize,
    // Minus the logarithm of the likelihood, per measurement.
    loss: f64,
}

impl Refined {
    /// Returns whether the log is likelier than with another refinement. Likelihoods of different
    /// rungs cannot be compared; a wrong delay needs a lower rung.
    fn is_likelier(&self, other: &Self) -> bool {
        match self.rung.cmp(&other.rung) {
            Ordering::Less => true,
            Ordering::Equal => self.loss < other.loss,
            Ordering::Greater => false,
        }
    }

    /// Returns the significant delays of some columns, except that of the column `but`.
    fn significant(&self, columns: &[&str], but: &str) -> Vec<RefinedDelay> {
        (self.delays.iter())
            .filter(|delay| columns.contains(&delay.column.as_str()) && delay.column != but)
            .filter(|delay| {
                let beyond = delay.delay_s - delay.used_s;
                (delay.standard_error_s)
                    .is_some_and(|error| is_significant(beyond, error, self.period))
            })
            .cloned()
            .collect()
    }

    /// Returns the estimated delay of a column, if it is significant.
    fn likely_delay(&self, column: &str) -> Option<LikelyDelay> {
        let delay = self.delays.iter().find(|delay| delay.column == column)?;
        let standard_error = delay.standard_error_s?;
        // Hold-out rejected the delay if the logs were read with another one.
        let rest = (delay.delay_s - delay.used_s).abs();
        if rest > MAX_REST_SIGMAS * standard_error.max(MIN_DELAY_SAMPLES * self.period) {
            return None;
        }
        is_significant(delay.delay_s, standard_error, self.period).then(|| LikelyDelay {
            column: delay.column.clone(),
            delay: delay.delay_s,
            standard_error,
        })
    }

    /// Returns the delays of a joint's columns if they may explain the log: if one of them is
    /// significant, or if the refinement failed, because a long delay can make it fail. A long
    /// delay of one channel may make another one of the joint more significant.
    fn suspects(&self, columns: &[&str]) -> Vec<RefinedDelay> {
        // A lower rung may hide a long delay as well as a failure does.
        if self.used && self.rung == 0 && self.significant(columns, "").is_empty() {
            return Vec::new();
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
        rung: refinement.map_or(usize::MAX, |refinement| {
            let mut rungs = refinement.rungs.iter();
            (rungs.position(|rung| rung.name == refinement.rung)).unwrap_or(usize::MAX)
        }),
        loss: refinement.map_or(f64::INFINITY, |refinement| {
            refinement.minus_log_likelihood / refinement.measurements.max(1) as f64
        }),
    })
}

/// Returns the difference of a delay from the assumed one, in standard errors.
fn significance(delay: &RefinedDelay) -> f64 {
    (delay.standard_error_s).map_or(0.0, |error| (delay.delay_s - delay.used_s).abs() / error)
}
