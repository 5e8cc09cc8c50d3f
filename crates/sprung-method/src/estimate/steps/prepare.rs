//! The first step: all choices from the beginning of the first log.

use super::refuse::refuse;
use crate::check::settled_or_other_meaning;
use crate::description::{Experiment, StartName};
use crate::estimate::errors::IdentifyError;
use crate::estimate::estimators::prediction_error::{Retiming, likely};
use crate::estimate::refined_unknowns::{FoundVelocity, replace_velocities};
use crate::estimate::result::RigidJoint;
use crate::estimate::springs::{RigidByLog, with_joints_rigid_by_log};
use crate::log::LogSource;
use crate::model::{Model, Theta};
use crate::prepare::{PrepareError, Prepared, prepare};
use crate::progress::Listener;
use crate::unknowns::{AboutUnknowns, Settled, UnknownResult};

/// Logs of one robot that are ready for the pass.
pub(in crate::estimate) struct Ready {
    /// The choices, with what the first log shows beyond the description.
    pub(in crate::estimate) prepared: Prepared,
    /// Joints that are rigid by the beginning of the first log; they are rigid in the choices.
    pub(in crate::estimate) rigid: Vec<RigidJoint>,
    /// What the first log shows beyond the description, with findings.
    pub(in crate::estimate) unknowns: Vec<UnknownResult>,
    pub(in crate::estimate) about_unknowns: AboutUnknowns,
    /// Nominal parameters from which the refinement starts, \[p\]; `None` if it starts from least squares.
    pub(in crate::estimate) nominal: Option<Theta>,
}

impl Ready {
    /// Returns the same logs with another timing of the torques and another sharpness of Coulomb friction.
    pub(in crate::estimate) fn retimed(&self, retiming: &Retiming) -> Result<Self, IdentifyError> {
        let reading = retiming.applied(self.prepared.reading());
        self.with_prepared(self.prepared.clone().with_reading(reading))
    }

    /// Returns the same logs with another model of the same equations.
    pub(in crate::estimate) fn with_model(&self, model: Model) -> Result<Self, IdentifyError> {
        self.with_prepared(self.prepared.clone().with_model(model))
    }

    fn with_prepared(&self, prepared: Prepared) -> Result<Self, IdentifyError> {
        let nominal = nominal_start(prepared.experiment(), prepared.reading().model())?;
        Ok(Self {
            prepared,
            rigid: self.rigid.clone(),
            unknowns: self.unknowns.clone(),
            about_unknowns: self.about_unknowns.clone(),
            nominal,
        })
    }
}

/// Makes all choices from the beginning of the first log: what the log shows beyond the description, joints whose springs it does not
/// show, open Stribeck velocities by likelihood, and the weights of the samples.
///
/// # Errors
///
/// [`IdentifyError`] if the description is not complete, the first log cannot be read or contradicts
/// it, or the caller stops the run.
pub(in crate::estimate) fn make_ready(
    experiment: &Experiment,
    model: &Model,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<Ready, IdentifyError> {
    // A missing input is reported before a log is read.
    nominal_start(experiment, model)?;
    let prepared = prepare(experiment, model, sources, progress)?;
    refuse(prepared.reading().settings(), prepared.wrong_time_unit())?;
    let Settled {
        prepared,
        mut unknowns,
        about: about_unknowns,
        ..
    } = settled_or_other_meaning(prepared, progress)?;
    prepared.require_gains().map_err(PrepareError::from)?;
    let RigidByLog {
        prepared,
        joints: rigid,
    } = with_joints_rigid_by_log(prepared, progress)?;
    let velocities = likely(prepared.reading(), sources, prepared.excerpt(), progress)?;
    let prepared = prepared.with_velocities(&velocities);
    let names = prepared.reading().model().joints();
    let used = (velocities.iter()).filter(|velocity| prepared.uses(velocity));
    let used = used.map(|velocity| FoundVelocity {
        joint: names[velocity.joint].as_str(),
        velocity: velocity.velocity,
        standard_error: velocity.standard_error,
    });
    replace_velocities(&mut unknowns, used);
    let prepared = prepared.weighted(progress)?;
    let nominal = nominal_start(prepared.experiment(), prepared.reading().model())?;
    Ok(Ready {
        prepared,
        rigid,
        unknowns,
        about_unknowns,
        nominal,
    })
}

/// Returns the nominal parameters from which the refinement starts, \[p\]; `None` if it starts from least squares.
///
/// # Errors
///
/// [`IdentifyError::Start`] if the experiment does not give all of them.
fn nominal_start(experiment: &Experiment, model: &Model) -> Result<Option<Theta>, IdentifyError> {
    match experiment.identify.start {
        StartName::LeastSquares => Ok(None),
        StartName::Nominal => Ok(Some(model.nominal().map_err(IdentifyError::Start)?)),
    }
}
