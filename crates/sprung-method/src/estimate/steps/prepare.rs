//! The first step: all choices from the beginning of the first log.

use super::inputs::EstimatorInputs;
use super::refuse::refuse;
use crate::description::{Experiment, Laws};
use crate::estimate::errors::IdentifyError;
use crate::estimate::estimators::prediction_error::{Retiming, likely};
use crate::estimate::laws::{Chosen, choose_laws, laws_of, open_delays, with_open_delays};
use crate::estimate::result::RigidJoint;
use crate::estimate::springs::{RigidByLog, with_joints_rigid_by_log};
use crate::log::LogSource;
use crate::model::Model;
use crate::prepare::{Prepared, prepare};
use crate::progress::Listener;

/// Logs of one robot that are ready for the pass.
pub(in crate::estimate) struct Ready {
    /// The choices, with the laws of friction and springs that the settings ask to find.
    pub(in crate::estimate) prepared: Prepared,
    /// These laws; `None` if the log is too short for parts.
    pub(in crate::estimate) laws: Option<Chosen>,
    /// Joints that the beginning of the first log shows as rigid; they are rigid in the choices.
    pub(in crate::estimate) rigid: Vec<RigidJoint>,
    pub(in crate::estimate) inputs: EstimatorInputs,
}

impl Ready {
    /// Returns the same logs with another timing of the torques and another sharpness of Coulomb friction. Laws that the
    /// description lacks are looked for again.
    pub(in crate::estimate) fn retimed(&self, retiming: &Retiming) -> Result<Self, IdentifyError> {
        let prepared = self.prepared.clone();
        let reading = retiming.applied(prepared.reading());
        let mut own = self.with_prepared(prepared.with_reading(reading))?;
        if own
            .laws
            .as_ref()
            .is_some_and(|laws| laws.experiment.is_none())
        {
            own.laws = choose_laws(&own.prepared);
        }
        Ok(own)
    }

    /// Returns the same logs with another model of the same equations.
    pub(in crate::estimate) fn with_model(&self, model: Model) -> Result<Self, IdentifyError> {
        self.with_prepared(self.prepared.clone().with_model(model))
    }

    fn with_prepared(&self, prepared: Prepared) -> Result<Self, IdentifyError> {
        let inputs = EstimatorInputs::new(prepared.experiment(), prepared.reading().model())?;
        Ok(Self {
            prepared,
            laws: self.laws.clone(),
            rigid: self.rigid.clone(),
            inputs,
        })
    }
}

/// Makes all choices from the beginning of the first log.
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
    EstimatorInputs::new(experiment, model)?;
    let (prepared, laws, rigid) = with_laws(experiment, model, sources, progress)?;
    let inputs = EstimatorInputs::new(prepared.experiment(), prepared.reading().model())?;
    Ok(Ready {
        prepared,
        laws,
        rigid,
        inputs,
    })
}

/// Prepares the logs for a refinement, with the laws that the settings ask to choose by hold-out.
pub(in crate::estimate) fn prepare_with_laws(
    experiment: &Experiment,
    model: &Model,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<Prepared, IdentifyError> {
    let auto = (0..model.joint_count()).any(|joint| laws_of(experiment, joint) == Laws::Auto);
    if !auto {
        let prepared = prepare(experiment, model, sources, progress)?;
        let prepared = with_joints_rigid_by_log(prepared, progress)?.prepared;
        return Ok(prepared.weighted(progress)?);
    }
    Ok(with_laws(experiment, model, sources, progress)?.0)
}

/// Prepares the logs as a check does, makes joints rigid whose springs they do not show, estimates the requested delays and open Stribeck velocities by
/// likelihood, determines the weights of the samples, and chooses the laws by hold-out.
fn with_laws(
    experiment: &Experiment,
    model: &Model,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<(Prepared, Option<Chosen>, Vec<RigidJoint>), IdentifyError> {
    let prepared = prepare(experiment, model, sources, progress)?;
    let settings = prepared.reading().settings();
    refuse(settings, prepared.wrong_time_unit())?;
    let RigidByLog { prepared, joints } = with_joints_rigid_by_log(prepared, progress)?;
    let likely = likely(prepared.reading(), sources, prepared.excerpt(), progress)?;
    let prepared = prepared.with_likely(&likely).weighted(progress)?;
    let (prepared, laws) = with_chosen_laws(prepared, sources, progress)?;
    Ok((prepared, laws, joints))
}

/// Chooses the laws by hold-out. If laws are added, makes all choices again with them, estimates
/// Stribeck velocities and the delays of torques by likelihood, and keeps the delays that are
/// significant.
fn with_chosen_laws(
    prepared: Prepared,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<(Prepared, Option<Chosen>), IdentifyError> {
    let Some(mut chosen) = choose_laws(&prepared) else {
        return Ok((prepared, None));
    };
    let richer = chosen.experiment.as_ref();
    let described = richer.unwrap_or(prepared.experiment()).clone();
    let columns = open_delays(&prepared, &described);
    if richer.is_none() && columns.is_empty() {
        return Ok((prepared, Some(chosen)));
    }
    // Delays change no equation, so one model serves all of them.
    let Ok(model) = Model::new(&described) else {
        return Ok((prepared, Some(chosen)));
    };
    let model = model.with_open_stribeck(&chosen.open_velocities);
    let with_delays = prepared.again(&with_open_delays(&described, &columns), &model, progress)?;
    let (reading, excerpt) = (with_delays.reading(), with_delays.excerpt());
    let likely = likely(reading, sources, excerpt, progress)?;
    let with_delays = with_delays.with_likely(&likely);
    let joints = model.joints();
    let velocities = (likely.velocities.iter()).filter(|own| with_delays.uses(own));
    chosen.set_velocities(
        velocities.map(|own| (joints[own.joint].as_str(), own.velocity, own.standard_error)),
    );
    if columns.is_empty() {
        return Ok((with_delays.weighted(progress)?, Some(chosen)));
    }
    let mut again = |experiment: &Experiment| -> Result<Prepared, IdentifyError> {
        Ok(prepared
            .again(experiment, &model, progress)?
            .with_likely(&likely))
    };
    let without_delays = again(&described)?;
    let added = chosen.add_delays(&without_delays, &with_delays, &columns);
    let ready = match added.len() {
        0 => without_delays,
        all if all == columns.len() => with_delays,
        _ => again(&with_open_delays(&described, &added))?,
    };
    Ok((ready.weighted(progress)?, Some(chosen)))
}
