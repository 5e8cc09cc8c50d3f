//! One parameter set on one log.

use std::collections::BTreeMap;

use super::changes::{Logs, OfSet, promise_broken, promise_explained};
use super::explained::Beginning;
use super::findings::{self, TorqueFit};
use super::metrics::{Rms, Spread};
use super::proof::{JointProof, is_kept};
use super::result::{Outcome, RootMeanSquares, SetResult};
use crate::check::UNEXPLAINED;
use crate::description::Controller;
use crate::estimate::{EstimateResult, Identification, JointPrediction, RigidJoint, predictions};
use crate::finding::Finding;
use crate::model::{Model, Theta};
use crate::named::Named;
use crate::preprocess::RawBlock;
use crate::regression::System;
use crate::simulate::ClosedLoop;

/// Label of the measured curves.
pub(super) const MEASURED: &str = "measured";

/// Quantities compared per joint: link position, motor position, torque.
pub(super) const COMPARED: usize = 3;

/// Parameters to validate, with a label.
#[derive(Clone, Debug)]
pub struct ParameterSet {
    /// Origin of the values.
    pub label: String,
    /// Values by name; parameters that were not identified are missing.
    pub values: BTreeMap<String, f64>,
    /// Errors that the identification of the values promises; empty without an identification.
    pub promise: Vec<JointPrediction>,
}

impl ParameterSet {
    /// Returns one set per estimator of an identification.
    #[must_use]
    pub fn of(identification: &Identification) -> Vec<Self> {
        (identification.results.iter())
            .map(|result| Self {
                label: result.estimator.clone(),
                values: completed(result, &identification.rigid_joints),
                promise: result.promise.clone(),
            })
            .collect()
    }
}

/// Returns values with the springs that simulations take for joints without a determined stiffness.
fn completed(result: &EstimateResult, rigid: &[RigidJoint]) -> BTreeMap<String, f64> {
    let mut values = result.values();
    for joint in rigid {
        joint.complete(|name| result.lacks(name), &mut values);
    }
    values
}

/// One parameter set during the validation on one experiment.
pub(super) struct Candidate {
    pub(super) label: String,
    modified: Option<String>,
    theta: Option<Theta>,
    promise: Vec<JointPrediction>,
    plant: Option<ClosedLoop>,
    // The model with the Stribeck velocities of the set.
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
            findings.push(findings::parameters_missing(&set.label, &error));
        });
        Self {
            // This label is reserved for the measured curves.
            label: if set.label == MEASURED {
                format!("{MEASURED} (parameters)")
            } else {
                set.label.clone()
            },
            modified: None,
            theta: theta.ok(),
            promise: set.promise.clone(),
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

    /// Returns a copy with negative friction set to zero, if the loop ran away and a friction is
    /// negative.
    pub(super) fn without_negative_friction(&self) -> Option<Self> {
        if !self.ran_away {
            return None;
        }
        let model = &self.model;
        let mut theta = self.theta.clone()?;
        let mut names = Vec::new();
        for i in findings::negative_friction(model, &theta) {
            theta[i] = 0.0;
            names.push(model.parameters()[i].name.clone());
        }
        let modified = format!("{} set to 0", names.join(", "));
        (!names.is_empty()).then(|| Self {
            label: format!("{} ({modified})", self.label),
            modified: Some(modified),
            theta: Some(theta),
            // The promise was made for the unchanged values.
            promise: Vec::new(),
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

    /// Returns the model with the Stribeck and residual velocities of the set.
    pub(super) fn model(&self) -> &Model {
        &self.model
    }

    /// Starts the loop at the beginning of a log.
    ///
    /// - `carried`: change of theta by the payload of the log, \[p\].
    pub(super) fn start(
        &mut self,
        controller: &Controller,
        period: f64,
        (q, phi): (&[f64], &[f64]),
        carried: Option<&[f64]>,
    ) {
        let Some(mut theta) = self.theta.clone() else {
            return;
        };
        for (value, by) in theta.iter_mut().zip(carried.unwrap_or_default()) {
            *value += by;
        }
        match ClosedLoop::new(&self.model, &theta, controller, period, Some((q, phi))) {
            Ok(plant) => self.plant = Some(plant),
            Err(error) => self
                .findings
                .push(findings::not_simulable(&self.label, &error)),
        }
    }

    /// Returns whether the report shows the curves of this set.
    pub(super) fn is_shown(&self) -> bool {
        !self.ran_away && (self.plant.is_some() || self.stopped)
    }

    /// Ends the simulation, because the samples that follow cannot be compared.
    pub(super) fn stop(&mut self) {
        self.stopped |= self.plant.take().is_some();
    }

    /// Compares sample `k` of a block and advances the loop; returns the simulated values.
    pub(super) fn compare(&mut self, samples: &RawBlock, k: usize) -> Vec<Option<f64>> {
        let mut values = vec![None; self.rms.len()];
        let model = &self.model;
        let Some(plant) = &mut self.plant else {
            return values;
        };
        let state = plant.state();
        plant.set_excess(&samples.excess_at(k));
        let tau = plant.command(samples.time[k], &state.q, &state.phi);
        let measured = samples.q.iter().chain(&samples.phi).chain(&samples.tau);
        let modelled = state.q.iter().chain(&state.phi).chain(&tau);
        for (at, (value, measured)) in modelled.zip(measured).enumerate() {
            values[at] = Some(*value);
            self.rms[at].push(measured[k] - value);
            self.measured[at].push(measured[k]);
        }
        if let Err(diverged) = plant.advance(&tau) {
            self.ran_away = true;
            let theta = self.theta.as_deref().unwrap_or_default();
            let finding = findings::runs_away(&self.label, model, theta, plant.period(), diverged);
            self.findings.push(finding);
            self.plant = None;
        }
        values
    }

    /// Returns the parameters, \[p\]; `None` if a value is missing.
    pub(super) fn theta(&self) -> Option<&Theta> {
        self.theta.as_ref()
    }

    /// Returns the result on a log.
    ///
    /// - `system`: the filtered regression of the log; `beginning`: the beginning of the log.
    pub(super) fn finish(
        mut self,
        system: &System,
        beginning: Option<&Beginning<'_>>,
        logs: &Logs<'_>,
    ) -> SetResult {
        let proofs = self.proofs(system);
        let torques = self.torques(system, &proofs);
        let kept = is_kept(&proofs);
        let fits = kept != Some(false) && !torques.iter().any(TorqueFit::is_unexplained);
        let theta = self.theta.clone();
        let theta = theta.filter(|_| !fits && self.modified.is_none());
        let change = theta.and_then(|theta| {
            let changes = beginning?.changes((&self.model, &theta), &proofs)?;
            Some((changes, theta))
        });
        let about_changes = change.map_or_else(Vec::new, |((changes, left), theta)| {
            let of_set = OfSet {
                label: &self.label,
                model: &self.model,
                theta: &theta,
            };
            promise_explained(&of_set, (&changes, &left), &proofs, logs)
        });
        let is_explained = !about_changes.is_empty();
        self.findings
            .extend(promise_broken(&self.label, &proofs, is_explained, logs));
        let not_broken: Vec<TorqueFit> = (torques.iter().zip(&proofs))
            .filter(|(_, proof)| !proof.quantities().any(|quantity| quantity.is_broken()))
            .map(|(torque, _)| torque.clone())
            .collect();
        self.findings
            .extend(findings::poor_prediction(&self.label, &not_broken));
        self.findings.extend(about_changes);
        let outcome = self.outcome();
        let motion = self.motion_error();
        if outcome == Outcome::Simulated && fits && motion > UNEXPLAINED {
            self.findings
                .push(findings::moves_otherwise(&self.label, motion));
        }
        let named = |of: fn(&TorqueFit) -> f64| -> Named {
            (torques.iter())
                .map(|torque| (torque.joint.clone(), of(torque)))
                .filter(|(_, value)| value.is_finite())
                .collect()
        };
        SetResult {
            e_rms: (outcome == Outcome::Simulated).then(|| self.errors()),
            outcome,
            torque_residual_nm: named(|torque| torque.residual),
            torque_relative_residual: named(|torque| torque.relative),
            predictions: proofs,
            promise_kept: kept,
            parameters: self.label,
            modified: self.modified,
            findings: self.findings,
        }
    }

    /// Returns the prediction errors of each joint beside the promised ones; empty if a value of the
    /// set is missing.
    fn proofs(&self, system: &System) -> Vec<JointProof> {
        let Some(theta) = &self.theta else {
            return Vec::new();
        };
        let promised = |joint: &str| self.promise.iter().find(|promise| promise.joint == joint);
        (predictions(&self.model, system, theta).iter())
            .map(|measured| JointProof::new(measured, promised(&measured.joint)))
            .collect()
    }

    /// Returns the fit of each joint's filtered torque.
    fn torques(&self, system: &System, proofs: &[JointProof]) -> Vec<TorqueFit> {
        (proofs.iter().enumerate())
            .map(|(joint, proof)| TorqueFit {
                joint: proof.joint.clone(),
                residual: proof.torque_error_nm,
                relative: proof.torque_error_nm / proof.torque_nm,
                transition: (system.kept())
                    .transition_share(self.model.torque_row(joint))
                    .unwrap_or(0.0),
            })
            .collect()
    }

    fn outcome(&self) -> Outcome {
        match (&self.plant, self.ran_away, self.simulated) {
            (_, true, _) => Outcome::RanAway,
            (Some(_), ..) => Outcome::Simulated,
            (None, _, true) if self.stopped => Outcome::Simulated,
            (None, _, true) => Outcome::NotSimulable,
            (None, _, false) => Outcome::NoController,
        }
    }

    /// Returns the largest error of a simulated position over the position's measured motion.
    fn motion_error(&self) -> f64 {
        let positions = 2 * self.model.joint_count();
        (self.rms.iter().zip(&self.measured).take(positions))
            .map(|(error, measured)| error.value() / measured.value())
            .fold(0.0, f64::max)
    }

    /// Returns the root mean squares of measured minus simulated, by quantity and joint.
    fn errors(&self) -> RootMeanSquares {
        let joints = self.model.joints();
        let of_joints = |group: usize| -> Named {
            (joints.iter().enumerate())
                .map(|(i, name)| (name.clone(), self.rms[group * joints.len() + i].value()))
                .collect()
        };
        RootMeanSquares {
            q_rad: of_joints(0),
            phi_rad: of_joints(1),
            tau_nm: of_joints(2),
        }
    }
}
