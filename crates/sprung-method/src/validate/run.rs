//! Direct validation (identification log) and prediction (other logs).

use std::collections::BTreeMap;

use sprung_core::chain::JointKind;

use super::candidate::{Candidate, ParameterSet};
use super::changes::Logs;
use super::comparison::Comparison;
use super::error::ValidateError;
use super::explained::Beginning;
use super::findings::until_gap;
use super::result::{RunResult, Validation};
use crate::curves::{CurveSet, Curves};
use crate::description::{Controller, Delay, Experiment, Identify, OnCheckError};
use crate::estimate::GENERATOR;
use crate::finding::{Finding, Severity};
use crate::log::{Channel, Channels, LogError, LogSource, Quantity, check};
use crate::model::{Model, Theta};
use crate::prepare::{Excerpt, as_given, excerpt, limit_by_rate, velocity_noise};
use crate::progress::{Listener, Phase};
use crate::regression::{PassError, Reading, System, TransitionWeights, read_through};

/// Results of a validation.
#[derive(Clone, Debug)]
pub struct Validated {
    /// The results.
    pub validation: Validation,
    /// Measured and simulated signals; labels are `run/set`.
    pub curves: Curves,
}

/// Choices of an identification that hold for the logs of a validation too.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChosenFor {
    /// Delays, s, by column.
    pub delays: BTreeMap<String, f64>,
    /// Common delay of all motor torques, s. It is used if the experiment does not say when the torques act.
    pub torques_delay: f64,
    /// Cut-off of the position filter, Hz. It is used if the experiment gives no cut-off.
    pub position_cutoff_hz: Option<f64>,
    /// Names of its logs.
    pub logs: Vec<String>,
}

/// Validates parameter sets on every `[[validate]]` experiment.
///
/// - `chosen`: choices of the identification that found the parameters.
/// - `sources`: logs of each validation experiment, in the order of the experiments; surplus
///   entries on either side are ignored.
/// - `progress`: receives the number of samples read so far.
///
/// With a controller the closed loop is simulated from rest under the same reference, which uses
/// the log's time, and compared with the log. With or without a controller, the filtered torque
/// that the model needs for the measured motion is compared with the logged torque.
///
/// # Errors
///
/// [`ValidateError`] if a description or a log is faulty. A loop that runs away is a finding.
///
/// # Source
///
/// Section 4.
pub fn validate(
    experiment: &Experiment,
    model: &Model,
    sets: &[ParameterSet],
    chosen: &ChosenFor,
    sources: &mut [Vec<LogSource<'_>>],
    progress: &mut dyn Listener,
) -> Result<Validated, ValidateError> {
    if experiment.validate.is_empty() {
        return Err(ValidateError::NoRuns);
    }
    for set in sets {
        model.check_names(&set.values)?;
    }
    let log = experiment.log.as_ref().ok_or(ValidateError::NoLog)?;
    // A run may give columns that [log] lacks, so [log] alone need not be complete.
    let identified = Channels::new(&experiment.robot, log).ok();
    let mut runs = Vec::new();
    let mut curves = Curves {
        columns: columns(model),
        sets: Vec::new(),
    };
    for (described, sources) in experiment.validate.iter().zip(sources) {
        let log = match &described.log {
            Some(over) => log.overlaid(over, &experiment.robot),
            None => log.clone(),
        };
        let channels = Channels::new(&experiment.robot, &log)?;
        if let Some(open) = (channels.all.iter()).find(|c| c.open_sign || c.open_gain) {
            return Err(ValidateError::UnknownFactor {
                column: open.column.clone(),
            });
        }
        channels.require_sides(&experiment.robot)?;
        let controller = described
            .controller
            .as_ref()
            .or(experiment.controller.as_ref());
        let mut candidates: Vec<Candidate> = sets
            .iter()
            .map(|set| Candidate::new(model, set, controller.is_some()))
            .collect();
        let run = Run {
            logs: KnownLogs {
                model,
                settings: &experiment.identify,
                channels: &channels,
                delays: &channel_delays(&channels, chosen, identified.as_ref())?,
                cutoff_hz: chosen.position_cutoff_hz,
            },
            controller,
        };
        let mut outcome = run.simulate(&mut candidates, sources, progress)?;
        let mut modified: Vec<Candidate> = candidates
            .iter()
            .filter_map(Candidate::without_negative_friction)
            .collect();
        if !modified.is_empty() {
            let again = run.simulate(&mut modified, sources, progress)?;
            outcome.curves.extend(again.curves.into_iter().skip(1));
            candidates.extend(modified);
        }
        for mut set in outcome.curves {
            set.label = format!("{}/{}", described.name, set.label);
            curves.sets.push(set);
        }
        // The names in the experiment, not the full paths.
        let names: Vec<String> = match &log.file {
            Some(files) => files.iter().map(ToString::to_string).collect(),
            None => sources.iter().map(LogSource::label).collect(),
        };
        let logs = Logs {
            run: &names,
            identified: &chosen.logs,
            channels: &channels,
            gain: &|column| log.gain.get(column).copied(),
        };
        let beginning = outcome.beginning.as_ref().map(|excerpt| Beginning {
            experiment,
            reading: &outcome.reading,
            excerpt,
            carried: outcome.carried.as_ref(),
            file: names.first().map_or("", String::as_str),
        });
        runs.push(RunResult {
            name: described.name.clone(),
            log: names.join(", "),
            same_log: !names.is_empty() && names.iter().all(|name| chosen.logs.contains(name)),
            samples: outcome.samples,
            position_cutoff_hz: Some(outcome.reading.position_cutoff_hz()),
            simulated: controller.is_some(),
            findings: outcome.findings,
            sets: candidates
                .into_iter()
                .map(|candidate| candidate.finish(&outcome.system, beginning.as_ref(), &logs))
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
    let named = |what: &'static [&'static str; 2]| {
        (model.joints().iter().enumerate()).map(move |(i, joint)| {
            let unit = match model.kind(i) {
                JointKind::Revolute => what[0],
                JointKind::Prismatic => what[1],
            };
            format!("{joint}.{unit}")
        })
    };
    named(&["link_position_rad", "link_position_m"])
        .chain(named(&["motor_position_rad", "motor_position_m"]))
        .chain(named(&["motor_torque_nm", "motor_force_n"]))
        .collect()
}

struct Simulated {
    samples: u64,
    findings: Vec<Finding>,
    system: System,
    reading: Reading,
    beginning: Option<Excerpt>,
    /// Change of theta by the payload of the first log, \[p\].
    carried: Option<Theta>,
    // Measured curves, then one set per shown candidate.
    curves: Vec<CurveSet>,
}

struct Run<'a> {
    logs: KnownLogs<'a>,
    controller: Option<&'a Controller>,
}

impl Run<'_> {
    /// Returns the settings for reading the logs. All weights are 1; they only give the variance
    /// that velocity noise causes in the friction of the first candidate. Its Stribeck and residual
    /// velocities serve all candidates; those of one identification hardly differ.
    fn reading(&self, candidates: &[Candidate], beginning: Option<&Excerpt>) -> Reading {
        let model = candidates.first().map_or(self.logs.model, Candidate::model);
        let theta = candidates.iter().find_map(Candidate::theta);
        let logs = KnownLogs { model, ..self.logs };
        let reading = logs.reading(beginning, theta);
        let (Some(beginning), Some(theta)) = (beginning, theta) else {
            return reading;
        };
        let model = reading.model();
        let cutoff = reading.position_cutoff_hz();
        let noise = velocity_noise(model, self.logs.channels, beginning, cutoff);
        let weights = TransitionWeights::unweighted(model, &noise, theta);
        reading.with_weights(weights)
    }

    /// Reads the logs once and compares all candidates with them.
    fn simulate(
        &self,
        candidates: &mut [Candidate],
        sources: &mut [LogSource<'_>],
        progress: &mut dyn Listener,
    ) -> Result<Simulated, PassError> {
        let first = sources.first_mut();
        let beginning = first
            .map(|first| excerpt(self.logs.channels, first))
            .transpose()?;
        let reading = self.reading(candidates, beginning.as_ref());
        if self.logs.settings.on_check_error == OnCheckError::Refuse {
            refuse_open_mountings(&reading)?;
        }
        let payloads: Vec<Option<Theta>> = (sources.iter())
            .map(|source| self.logs.model.change_by_payload(source.payload()?))
            .collect();
        let carried = payloads.first().cloned().flatten();
        let mut comparison = Comparison::new(self.controller, candidates, payloads.into_iter());
        let passed = read_through(
            &reading,
            sources,
            &mut comparison,
            Phase::Validating,
            progress,
        )?;
        let mut findings = Vec::new();
        for (figures, source) in passed.logs.iter().zip(&*sources) {
            let joints = self.logs.model.joints();
            let found = check(
                &source.label(),
                self.logs.channels,
                joints,
                &figures.summary,
                &figures.mended,
            );
            let wrong = (found.iter()).find(|finding| finding.severity == Severity::Error);
            if let Some(wrong) = wrong
                && self.logs.settings.on_check_error == OnCheckError::Refuse
            {
                return Err(LogError::Implausible {
                    message: wrong.text.clone(),
                }
                .into());
            }
            findings.extend(found);
        }
        if comparison.ended_at_gap() {
            findings.push(until_gap());
        }
        Ok(Simulated {
            samples: passed.logs.iter().map(|log| log.summary.samples()).sum(),
            findings,
            system: passed.system,
            reading,
            beginning,
            carried,
            curves: comparison.curves(self.logs.model.joint_count()),
        })
    }
}

/// Logs of a robot with known parameters.
#[derive(Clone, Copy)]
pub(crate) struct KnownLogs<'a> {
    pub(crate) model: &'a Model,
    pub(crate) settings: &'a Identify,
    pub(crate) channels: &'a Channels,
    /// Delay of every channel, s.
    pub(crate) delays: &'a [f64],
    /// Cut-off of the position filter by an identification, Hz.
    pub(crate) cutoff_hz: Option<f64>,
}

impl KnownLogs<'_> {
    /// Returns the settings for reading them.
    ///
    /// - `theta`: the parameters, \[p\].
    pub(crate) fn reading(&self, beginning: Option<&Excerpt>, theta: Option<&Theta>) -> Reading {
        let Self {
            model,
            settings,
            channels,
            delays,
            cutoff_hz,
        } = *self;
        let Some(beginning) = beginning else {
            return Reading::new(model, settings, channels, 0.0).with_delays(delays);
        };
        let (mut reading, chosen) = as_given(model, settings, channels, beginning);
        if let (Some(cutoff), Some(_)) = (cutoff_hz, chosen) {
            // A validation log may have fewer samples per second than that of the identification.
            let cutoff = cutoff.min(limit_by_rate(beginning.period()));
            reading = reading.with_position_cutoff(cutoff);
        }
        let reading = reading.with_delays(delays);
        match theta {
            Some(theta) => reading.with_springs(theta),
            None => reading,
        }
    }
}

/// Returns the delay of every channel, s.
pub(crate) fn channel_delays(
    channels: &Channels,
    chosen: &ChosenFor,
    identified: Option<&Channels>,
) -> Result<Vec<f64>, ValidateError> {
    let is_torque = |channel: &Channel| channel.quantity == Quantity::MotorTorque;
    let is_timing_given = channels.torque_hold.is_some()
        || (channels.all.iter()).any(|channel| is_torque(channel) && channel.delay.is_some());
    // Delays belong to the recorder of a channel, so those of the identification hold here.
    let found = |channel: &Channel| {
        let signal = channel.quantity.signal();
        let same_channel = identified
            .and_then(|log| Some(&log.all[log.telling(signal, channel.joint)?]))
            .and_then(|of_log| chosen.delays.get(&of_log.column));
        same_channel
            .or_else(|| chosen.delays.get(&channel.column))
            .copied()
    };
    (channels.all.iter())
        .map(|channel| match channel.delay {
            None if is_torque(channel) && !is_timing_given => {
                Ok(found(channel).unwrap_or(chosen.torques_delay))
            }
            None => Ok(found(channel).unwrap_or_default()),
            Some(Delay::Known(value)) => Ok(value),
            Some(Delay::Estimate) => found(channel).ok_or_else(|| ValidateError::UnknownDelay {
                column: channel.column.clone(),
            }),
        })
        .collect()
}

/// Checks that the mountings of all sensors are known.
fn refuse_open_mountings(reading: &Reading) -> Result<(), LogError> {
    let Some(sensors) = &reading.channels().inertial else {
        return Ok(());
    };
    let open = sensors
        .all
        .iter()
        .find(|sensor| sensor.needs_mounting(sensors.kind));
    open.map_or(Ok(()), |sensor| {
        Err(LogError::Implausible {
            message: format!(
                "{}: the {} has no given mounting, and this log does not determine it; give {}",
                reading.model().joints()[sensor.joint],
                sensors.kind.word(),
                sensors.kind.mounting_keys()
            ),
        })
    })
}
