//! Direct validation and prediction.

use std::collections::BTreeMap;

use super::candidate::{COMPARED, Candidate, MEASURED, ParameterSet};
use super::result::{RunResult, Validation};
use crate::curves::{CurveSet, Curves};
use crate::description::{Controller, Delay, Experiment, Identify};
use crate::estimate::GENERATOR;
use crate::finding::Finding;
use crate::log::{ChannelError, Channels, LogSource, check};
use crate::model::{JOINT_COUNT, Model, ModelError};
use crate::preprocess::{Decimator, RawSample};
use crate::regression::{Observer, PassError, Reading, System, read_through};

/// Points of the curves, at most.
const POINTS: usize = 2048;

/// What a validation leaves.
#[derive(Clone, Debug)]
pub struct Validated {
    /// The results.
    pub validation: Validation,
    /// Measured and simulated signals; labels are `run/set`.
    pub curves: Curves,
}

/// What keeps a model from being validated.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ValidateError {
    /// The experiment has nothing to validate on.
    #[error(
        "the experiment has no [[validate]] block; add one with a name, a log and a controller"
    )]
    NoRuns,
    /// The experiment names no log.
    #[error("the experiment has no [log]; say which columns its logs have")]
    NoLog,
    /// The description of a log is not complete.
    #[error(transparent)]
    Channel(#[from] ChannelError),
    /// A delay is to be estimated, which only an identification does.
    #[error(
        "the delay of \"{column}\" is to be estimated, and the parameter file does not say what was \
         found; give it as a number in delay_s"
    )]
    UnknownDelay {
        /// Name of the column.
        column: String,
    },
    /// A name of the parameter file is not one of the model.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A log is wrong, or does not fit the filters.
    #[error(transparent)]
    Pass(#[from] PassError),
}

/// Validates parameter sets on every `[[validate]]` experiment.
///
/// - `delays`: delays that an identification found, s, by column.
/// - `sources`: the logs of the validation experiments, in their order; more or
///   fewer are passed over.
/// - `progress`: called with the number of samples read so far.
///
/// With a controller the closed loop is simulated from rest under the same
/// reference, which runs on the log's time, and compared with the log. Without,
/// and besides, the filtered torque that the model needs for the measured
/// motion is compared.
///
/// # Errors
///
/// [`ValidateError`] if a description or a log is wrong. A loop that runs away
/// is a finding.
///
/// # Source
///
/// Section 4.
pub fn validate(
    experiment: &Experiment,
    model: &Model,
    sets: &[ParameterSet],
    delays: &BTreeMap<String, f64>,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn FnMut(u64),
) -> Result<Validated, ValidateError> {
    if experiment.validate.is_empty() {
        return Err(ValidateError::NoRuns);
    }
    for set in sets {
        for name in set.values.keys() {
            model.index_of(name)?;
        }
    }
    let log = experiment.log.as_ref().ok_or(ValidateError::NoLog)?;
    let mut runs = Vec::new();
    let mut curves = Curves {
        columns: columns(model),
        sets: Vec::new(),
    };
    for (described, source) in experiment.validate.iter().zip(sources) {
        let log = match &described.log {
            Some(over) => log.overlaid(over),
            None => log.clone(),
        };
        let channels = Channels::new(&experiment.robot, &log)?;
        let controller = described
            .controller
            .as_ref()
            .or(experiment.controller.as_ref());
        let mut candidates: Vec<Candidate> = sets
            .iter()
            .map(|set| Candidate::new(model, set, controller.is_some()))
            .collect();
        let run = Run {
            model,
            settings: &experiment.identify,
            channels: &channels,
            delays: &channel_delays(&channels, delays)?,
            controller,
        };
        let mut outcome = run.simulate(&mut candidates, source, progress)?;
        let mut tamed: Vec<Candidate> = candidates
            .iter()
            .filter_map(|c| c.without_negative_friction(model))
            .collect();
        if !tamed.is_empty() {
            let again = run.simulate(&mut tamed, source, progress)?;
            outcome.curves.extend(again.curves.into_iter().skip(1));
            candidates.extend(tamed);
        }
        for mut set in outcome.curves {
            set.label = format!("{}/{}", described.name, set.label);
            curves.sets.push(set);
        }
        runs.push(RunResult {
            name: described.name.clone(),
            log: log.name(&source.name),
            samples: outcome.samples,
            simulated: controller.is_some(),
            findings: outcome.findings,
            sets: candidates
                .into_iter()
                .map(|candidate| candidate.finish(model, &outcome.system))
                .collect(),
        });
    }
    Ok(Validated {
        validation: Validation {
            format: 1,
            generator: GENERATOR.to_owned(),
            robot: experiment.robot.name.clone(),
            runs,
        },
        curves,
    })
}

fn columns(model: &Model) -> Vec<String> {
    ["link_position_rad", "motor_position_rad", "motor_torque_nm"]
        .iter()
        .flat_map(|what| {
            model
                .joints()
                .iter()
                .map(move |joint| format!("{joint}.{what}"))
        })
        .collect()
}

struct Simulated {
    samples: u64,
    findings: Vec<Finding>,
    system: System,
    // Measured first, then one per candidate.
    curves: Vec<CurveSet>,
}

struct Run<'a> {
    model: &'a Model,
    settings: &'a Identify,
    channels: &'a Channels,
    delays: &'a [f64],
    controller: Option<&'a Controller>,
}

impl Run<'_> {
    /// Reads the log once, past all candidates.
    fn simulate(
        &self,
        candidates: &mut [Candidate],
        source: &mut LogSource<'_>,
        progress: &mut dyn FnMut(u64),
    ) -> Result<Simulated, PassError> {
        let reading = Reading {
            model: self.model,
            settings: self.settings,
            channels: self.channels,
            delays: self.delays,
        };
        let mut comparison = Comparison {
            model: self.model,
            controller: self.controller,
            candidates,
            points: Decimator::new(POINTS),
            started: false,
        };
        let passed = read_through(&reading, source, &mut comparison, progress)?;
        let points = comparison.points.into_items();
        let findings = check(
            &source.name,
            self.channels,
            self.model.joints(),
            &passed.summary,
        )?;
        Ok(Simulated {
            samples: passed.summary.samples(),
            findings,
            system: passed.system,
            curves: curves(candidates, &points),
        })
    }
}

/// Returns the delay of every channel, s.
fn channel_delays(
    channels: &Channels,
    found: &BTreeMap<String, f64>,
) -> Result<Vec<f64>, ValidateError> {
    (channels.all.iter())
        .map(|channel| match channel.delay {
            None => Ok(0.0),
            Some(Delay::Known(value)) => Ok(value),
            Some(Delay::Estimate) => {
                found
                    .get(&channel.column)
                    .copied()
                    .ok_or_else(|| ValidateError::UnknownDelay {
                        column: channel.column.clone(),
                    })
            }
        })
        .collect()
}

/// Runs every candidate beside the log.
struct Comparison<'a> {
    model: &'a Model,
    controller: Option<&'a Controller>,
    candidates: &'a mut [Candidate],
    points: Decimator<Point>,
    started: bool,
}

impl Observer for Comparison<'_> {
    fn raw(&mut self, period: f64, samples: &[RawSample]) {
        for sample in samples {
            if !std::mem::replace(&mut self.started, true)
                && let Some(controller) = self.controller
            {
                for candidate in &mut *self.candidates {
                    candidate.start(self.model, controller, period, sample);
                }
            }
            let said: Vec<_> = (self.candidates.iter_mut())
                .map(|candidate| candidate.compare(self.model, sample))
                .collect();
            self.points.push(|| (*sample, said));
        }
    }
}

type Point = (RawSample, Vec<[Option<f64>; COMPARED]>);

fn curves(candidates: &[Candidate], points: &[Point]) -> Vec<CurveSet> {
    let time: Vec<f64> = points.iter().map(|(sample, _)| sample.time).collect();
    let mut sets = vec![CurveSet {
        label: MEASURED.to_owned(),
        time: time.clone(),
        values: vec![Vec::new(); COMPARED],
    }];
    for (sample, _) in points {
        for (group, of) in [sample.q, sample.phi, sample.tau].into_iter().enumerate() {
            for (i, value) in of.into_iter().enumerate() {
                sets[0].values[group * JOINT_COUNT + i].push(Some(value));
            }
        }
    }
    for (index, candidate) in candidates.iter().enumerate() {
        // A loop that ran away would hide every other curve.
        if candidate.ran_away || candidate.plant.is_none() {
            continue;
        }
        sets.push(CurveSet {
            label: candidate.label.clone(),
            time: time.clone(),
            values: (0..COMPARED)
                .map(|at| points.iter().map(|(_, said)| said[index][at]).collect())
                .collect(),
        });
    }
    sets
}
