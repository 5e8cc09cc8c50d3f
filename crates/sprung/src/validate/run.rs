//! Direct validation and prediction.

use std::collections::BTreeMap;

use super::metrics::{Rms, Spread};
use super::result::{Outcome, RootMeanSquares, RunResult, SetResult, Validation};
use crate::curves::{CurveSet, Curves};
use crate::description::{Controller, Delay, Experiment, Identify};
use crate::estimate::{UNEXPLAINED, residual};
use crate::finding::{Finding, Severity};
use crate::log::{ChannelError, Channels, LogSource, check};
use crate::model::{JOINT_COUNT, Model, ModelError, Theta};
use crate::named::Named;
use crate::preprocess::{Decimator, RawSample};
use crate::regression::{Observer, PassError, Reading, System, read_through};
use crate::simulate::{ClosedLoop, LoopError};

/// Points of the curves, at most.
const POINTS: usize = 2048;

/// Label of what the log says.
const MEASURED: &str = "measured";

/// Quantities compared per joint: link position, motor position, torque.
const COMPARED: usize = 3 * JOINT_COUNT;

/// Parameters to validate, and what they are called.
#[derive(Clone, Debug)]
pub struct ParameterSet {
    /// Where they come from.
    pub label: String,
    /// Values by name; those that could not be identified are missing.
    pub values: BTreeMap<String, f64>,
}

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
/// reference, which runs on the log's time, and compared with the log. Without, and besides, the filtered
/// torque that the model needs for the measured motion is compared.
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
            generator: concat!("sprung ", env!("CARGO_PKG_VERSION")).to_owned(),
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

/// One parameter set on its way through one experiment.
struct Candidate {
    label: String,
    modified: Option<String>,
    theta: Option<Theta>,
    plant: Option<ClosedLoop>,
    rms: [Rms; COMPARED],
    measured: [Spread; COMPARED],
    findings: Vec<Finding>,
    ran_away: bool,
    simulated: bool,
}

impl Candidate {
    fn new(model: &Model, set: &ParameterSet, simulated: bool) -> Self {
        let mut findings = Vec::new();
        let theta = model.theta(&set.values).map_err(|error| {
            findings.push(Finding::new(
                Severity::Serious,
                "parameters-missing",
                format!("{}: {error}", set.label),
                "identify from a log that excites these parameters",
            ));
        });
        Self {
            // The log's own curves are called that.
            label: if set.label == MEASURED {
                format!("{MEASURED} (parameters)")
            } else {
                set.label.clone()
            },
            modified: None,
            theta: theta.ok(),
            plant: None,
            rms: [Rms::default(); COMPARED],
            measured: [Spread::default(); COMPARED],
            findings,
            ran_away: false,
            simulated,
        }
    }

    /// Returns the set with negative friction set to zero, if the loop ran
    /// away and there is any.
    fn without_negative_friction(&self, model: &Model) -> Option<Self> {
        if !self.ran_away {
            return None;
        }
        let mut theta = self.theta?;
        let mut names = Vec::new();
        for i in negative_friction(model, &theta) {
            theta[i] = 0.0;
            names.push(model.parameters()[i].name.clone());
        }
        let modified = format!("{} set to 0", names.join(", "));
        (!names.is_empty()).then(|| Self {
            label: format!("{} ({modified})", self.label),
            modified: Some(modified),
            theta: Some(theta),
            plant: None,
            rms: [Rms::default(); COMPARED],
            measured: [Spread::default(); COMPARED],
            findings: Vec::new(),
            ran_away: false,
            simulated: true,
        })
    }

    fn start(&mut self, model: &Model, controller: &Controller, period: f64, first: &RawSample) {
        let Some(theta) = self.theta else { return };
        match ClosedLoop::new(model, &theta, controller, period, &first.q, &first.phi) {
            Ok(plant) => self.plant = Some(plant),
            Err(error) => self.findings.push(Finding::new(
                Severity::Serious,
                "not-simulable",
                format!("{}: the loop cannot be simulated: {error}", self.label),
                match error {
                    LoopError::Model(ModelError::Missing { .. }) => {
                        "give the nominal values that the feedforward needs"
                    }
                    _ => "look at the warnings of the identification",
                },
            )),
        }
    }

    /// Compares one sample and moves on; returns what the model says.
    fn compare(&mut self, model: &Model, sample: &RawSample) -> [Option<f64>; COMPARED] {
        let mut said = [None; COMPARED];
        let Some(plant) = &mut self.plant else {
            return said;
        };
        let state = plant.state();
        let tau = plant.command(sample.time, &state.q, &state.phi);
        let model_values = [state.q, state.phi, tau];
        let measured = [sample.q, sample.phi, sample.tau];
        for (at, (value, measured)) in (model_values.iter().flatten())
            .zip(measured.iter().flatten())
            .enumerate()
        {
            said[at] = Some(*value);
            self.rms[at].push(measured - value);
            self.measured[at].push(*measured);
        }
        if let Err(diverged) = plant.advance(&tau) {
            self.ran_away = true;
            let theta = self.theta.unwrap_or_default();
            let names: Vec<String> = negative_friction(model, &theta)
                .into_iter()
                .map(|i| {
                    let p = &model.parameters()[i];
                    format!("{} = {:.4} {}", p.name, theta[i], p.unit)
                })
                .collect();
            let (reason, remedy) = if names.is_empty() {
                (
                    format!(
                        "the controller's gains do not stabilise this model at the log's period of \
                         {:.4} ms",
                        1e3 * plant.period()
                    ),
                    "check the gains and the velocity window; the log must be recorded at the \
                     controller's own period",
                )
            } else {
                (
                    format!("friction below zero feeds energy in: {}", names.join(", ")),
                    "compare the row with these set to zero; identify with an estimator that finds \
                     them positive",
                )
            };
            self.plant = None;
            self.findings.push(Finding::new(
                Severity::Serious,
                "loop-runs-away",
                format!("{}: {diverged}: {reason}", self.label),
                remedy,
            ));
        }
        said
    }

    fn finish(self, model: &Model, system: &System) -> SetResult {
        let of_joints = |group: usize| -> Named {
            (model.joints().iter().enumerate())
                .map(|(i, name)| (name.clone(), self.rms[group * JOINT_COUNT + i].value()))
                .collect()
        };
        let rows = self.theta.map(|theta| residual(model, system, &theta));
        let motor = |of: fn(&(f64, f64)) -> f64| -> Named {
            rows.iter()
                .flat_map(|rows| rows.iter().skip(JOINT_COUNT).zip(model.joints()))
                .map(|(row, name)| (name.clone(), of(row)))
                .filter(|(_, value)| value.is_finite())
                .collect()
        };
        let outcome = match (&self.plant, self.ran_away, self.simulated) {
            (_, true, _) => Outcome::RanAway,
            (Some(_), ..) => Outcome::Simulated,
            (None, _, true) => Outcome::NotSimulable,
            (None, _, false) => Outcome::NoController,
        };
        let relative = motor(|row| row.0 / row.1);
        let mut findings = self.findings;
        for (joint, share) in relative.iter().filter(|(_, share)| *share > UNEXPLAINED) {
            findings.push(Finding::new(
                Severity::Warning,
                "poor-prediction",
                format!(
                    "{}: the model misses the filtered motor torque of {joint} by {:.0} % (root mean \
                     squares)",
                    self.label,
                    100.0 * share
                ),
                "look at the torque over time; identify from a log that moves like this one",
            ));
        }
        // A model that fits along the measured motion, in a loop that moves
        // otherwise: it is the loop that is not the one of the log.
        let motion = (self.rms.iter().zip(&self.measured).take(2 * JOINT_COUNT))
            .map(|(error, measured)| error.value() / measured.value())
            .fold(0.0, f64::max);
        let fits = relative.iter().all(|(_, share)| share <= UNEXPLAINED);
        if outcome == Outcome::Simulated && fits && motion > UNEXPLAINED {
            findings.push(Finding::new(
                Severity::Warning,
                "loop-moves-otherwise",
                format!(
                    "{}: the simulated positions miss the measured ones by {:.0} % of their motion, \
                     though the model explains the torque along them: the log does not start at \
                     rest, its clock is not the reference's, or another controller ran",
                    self.label,
                    100.0 * motion
                ),
                "cut the log at its start, let its time begin where the reference does, and check \
                 gains, reference and velocity window",
            ));
        }
        SetResult {
            parameters: self.label.clone(),
            modified: self.modified.clone(),
            outcome,
            e_rms: (outcome == Outcome::Simulated).then(|| RootMeanSquares {
                q_rad: of_joints(0),
                phi_rad: of_joints(1),
                tau_nm: of_joints(2),
            }),
            torque_residual_nm: motor(|row| row.0),
            torque_relative_residual: relative,
            findings,
        }
    }
}

fn negative_friction(model: &Model, theta: &Theta) -> Vec<usize> {
    (model.parameters().iter().enumerate())
        .filter(|(i, parameter)| theta[*i] < 0.0 && parameter.is_friction())
        .map(|(i, _)| i)
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
