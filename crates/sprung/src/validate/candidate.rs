//! One parameter set beside one log.

use std::collections::BTreeMap;

use super::metrics::{Rms, Spread};
use super::result::{Outcome, RootMeanSquares, SetResult};
use crate::check::{UNEXPLAINED, beyond_resolution};
use crate::description::Controller;
use crate::estimate::{Identification, residual};
use crate::finding::{Finding, Severity};
use crate::model::{Model, ModelError, Theta};
use crate::named::Named;
use crate::preprocess::RawBlock;
use crate::regression::System;
use crate::simulate::{ClosedLoop, LoopError};

/// Label of what the log says.
pub(super) const MEASURED: &str = "measured";

/// Quantities compared per joint: link position, motor position, torque.
pub(super) const COMPARED: usize = 3;

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
    plant: Option<ClosedLoop>,
    // The model with the shapes that the set holds.
    model: Model,
    rms: Vec<Rms>,
    measured: Vec<Spread>,
    findings: Vec<Finding>,
    pub(super) ran_away: bool,
    stopped: bool,
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
            rms: vec![Rms::default(); COMPARED * model.joint_count()],
            measured: vec![Spread::default(); COMPARED * model.joint_count()],
            model: model.shaped(&set.values),
            findings,
            ran_away: false,
            stopped: false,
            simulated,
        }
    }

    /// Returns the set with negative friction set to zero, if the loop ran
    /// away and there is any.
    pub(super) fn without_negative_friction(&self) -> Option<Self> {
        if !self.ran_away {
            return None;
        }
        let model = &self.model;
        let mut theta = self.theta.clone()?;
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
            rms: vec![Rms::default(); self.rms.len()],
            measured: vec![Spread::default(); self.rms.len()],
            model: model.clone(),
            findings: Vec::new(),
            ran_away: false,
            stopped: false,
            simulated: true,
        })
    }

    pub(super) fn start(
        &mut self,
        controller: &Controller,
        period: f64,
        (q, phi): (&[f64], &[f64]),
    ) {
        let Some(theta) = &self.theta else { return };
        match ClosedLoop::new(&self.model, theta, controller, period, Some((q, phi))) {
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

    /// Returns whether its curves belong beside the measured ones.
    pub(super) fn is_shown(&self) -> bool {
        !self.ran_away && (self.plant.is_some() || self.stopped)
    }

    /// Leaves the loop where it is: what follows cannot be compared.
    pub(super) fn stop(&mut self) {
        self.stopped |= self.plant.take().is_some();
    }

    /// Compares sample `k` of a block and moves on; returns what the model says.
    pub(super) fn compare(&mut self, samples: &RawBlock, k: usize) -> Vec<Option<f64>> {
        let mut said = vec![None; self.rms.len()];
        let model = &self.model;
        let Some(plant) = &mut self.plant else {
            return said;
        };
        let state = plant.state();
        let tau = plant.command(samples.time[k], &state.q, &state.phi);
        let measured = samples.q.iter().chain(&samples.phi).chain(&samples.tau);
        let modelled = state.q.iter().chain(&state.phi).chain(&tau);
        for (at, (value, measured)) in modelled.zip(measured).enumerate() {
            said[at] = Some(*value);
            self.rms[at].push(measured[k] - value);
            self.measured[at].push(measured[k]);
        }
        if let Err(diverged) = plant.advance(&tau) {
            self.ran_away = true;
            let theta = self.theta.clone().unwrap_or_default();
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

    /// Returns its parameters, \[p\], if it has all.
    pub(super) fn theta(&self) -> Option<&Theta> {
        self.theta.as_ref()
    }

    pub(super) fn finish(self, system: &System) -> SetResult {
        let model = &self.model;
        let n = model.joint_count();
        let of_joints = |group: usize| -> Named {
            (model.joints().iter().enumerate())
                .map(|(i, name)| (name.clone(), self.rms[group * n + i].value()))
                .collect()
        };
        let rows = (self.theta.as_ref()).map(|theta| residual(model, system, theta));
        let motor = |of: fn(&(f64, f64)) -> f64| -> Named {
            rows.iter()
                .flat_map(|rows| {
                    let joints = model.joints().iter().enumerate();
                    joints.map(|(joint, name)| (name, &rows[model.torque_row(joint)]))
                })
                .map(|(name, row)| (name.clone(), of(row)))
                .filter(|(_, value)| value.is_finite())
                .collect()
        };
        let outcome = match (&self.plant, self.ran_away, self.simulated) {
            (_, true, _) => Outcome::RanAway,
            (Some(_), ..) => Outcome::Simulated,
            (None, _, true) if self.stopped => Outcome::Simulated,
            (None, _, true) => Outcome::NotSimulable,
            (None, _, false) => Outcome::NoController,
        };
        let relative = motor(|row| row.0 / row.1);
        let mut findings = self.findings;
        let unexplained = |joint: &str, relative: f64| {
            let joint = model.joints().iter().position(|name| name == joint);
            let share =
                joint.and_then(|joint| system.kept().transition_share(model.torque_row(joint)));
            beyond_resolution(relative, share.unwrap_or(0.0)) > UNEXPLAINED
        };
        for (joint, share) in relative
            .iter()
            .filter(|(joint, share)| unexplained(joint, *share))
        {
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
        let motion = (self.rms.iter().zip(&self.measured).take(2 * n))
            .map(|(error, measured)| error.value() / measured.value())
            .fold(0.0, f64::max);
        let fits = !(relative.iter()).any(|(joint, share)| unexplained(joint, share));
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
