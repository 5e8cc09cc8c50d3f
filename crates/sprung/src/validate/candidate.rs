//! One parameter set beside one log.

use std::collections::BTreeMap;

use super::metrics::{Rms, Spread};
use super::result::{Outcome, RootMeanSquares, SetResult};
use crate::description::Controller;
use crate::estimate::{Identification, UNEXPLAINED, residual};
use crate::finding::{Finding, Severity};
use crate::model::{JOINT_COUNT, Model, ModelError, Theta};
use crate::named::Named;
use crate::preprocess::RawSample;
use crate::regression::System;
use crate::simulate::{ClosedLoop, LoopError};

/// Label of what the log says.
pub(super) const MEASURED: &str = "measured";

/// Quantities compared per joint: link position, motor position, torque.
pub(super) const COMPARED: usize = 3 * JOINT_COUNT;

/// Parameters to validate, and what they are called.
#[derive(Clone, Debug)]
pub struct ParameterSet {
    /// Where they come from.
    pub label: String,
    /// Values by name; those that could not be identified are missing.
    pub values: BTreeMap<String, f64>,
}

impl ParameterSet {
    /// Returns what each estimator of an identification found.
    #[must_use]
    pub fn of(identification: &Identification) -> Vec<Self> {
        (identification.results.iter())
            .map(|result| Self {
                label: result.estimator.clone(),
                values: result.values(),
            })
            .collect()
    }
}

/// One parameter set on its way through one experiment.
pub(super) struct Candidate {
    pub(super) label: String,
    modified: Option<String>,
    theta: Option<Theta>,
    pub(super) plant: Option<ClosedLoop>,
    rms: [Rms; COMPARED],
    measured: [Spread; COMPARED],
    findings: Vec<Finding>,
    pub(super) ran_away: bool,
    simulated: bool,
}

impl Candidate {
    pub(super) fn new(model: &Model, set: &ParameterSet, simulated: bool) -> Self {
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
    pub(super) fn without_negative_friction(&self, model: &Model) -> Option<Self> {
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

    pub(super) fn start(
        &mut self,
        model: &Model,
        controller: &Controller,
        period: f64,
        first: &RawSample,
    ) {
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
    pub(super) fn compare(&mut self, model: &Model, sample: &RawSample) -> [Option<f64>; COMPARED] {
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

    pub(super) fn finish(self, model: &Model, system: &System) -> SetResult {
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
