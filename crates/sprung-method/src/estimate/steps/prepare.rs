//! The first step: all choices from the beginning of the first log.

use super::inputs::EstimatorInputs;
use super::refuse::refuse;
use crate::check::settled_or_other_meaning;
use crate::description::Experiment;
use crate::estimate::errors::IdentifyError;
use crate::estimate::estimators::prediction_error::{Retiming, likely};
use crate::estimate::laws::{Chosen, FoundVelocity, choose_laws};
use crate::estimate::result::RigidJoint;
use crate::estimate::springs::{RigidByLog, with_joints_rigid_by_log};
use crate::log::LogSource;
use crate::model::Model;
use crate::prepare::{Prepared, prepare};
use crate::progress::Listener;
use crate::unknowns::{AboutUnknowns, Settled, UnknownResult};
use sprung_core::friction::Scale;

/// Logs of one robot that are ready for the pass.
pub(in crate::estimate) struct Ready {
    /// The choices, with the laws of friction and springs that the settings request.
    pub(in crate::estimate) prepared: Prepared,
    /// These laws; `None` if the log is too short for parts.
    pub(in crate::estimate) laws: Option<Chosen>,
    /// The choices without added laws; `None` if none was added.
    declared: Option<Prepared>,
    /// Joints that are rigid by the beginning of the first log; they are rigid in the choices.
    pub(in crate::estimate) rigid: Vec<RigidJoint>,
    /// What the first log shows beyond the description, with findings.
    pub(in crate::estimate) unknowns: Vec<UnknownResult>,
    pub(in crate::estimate) about_unknowns: AboutUnknowns,
    pub(in crate::estimate) inputs: EstimatorInputs,
}

impl Ready {
    /// Returns the same logs with another timing of the torques and another sharpness of Coulomb friction, and whether the
    /// laws are the same. Laws that the description lacks are looked for again.
    pub(in crate::estimate) fn retimed(
        &self,
        retiming: &Retiming,
        sources: &mut [LogSource<'_>],
        progress: &mut dyn Listener,
    ) -> Result<(Self, bool), IdentifyError> {
        let applied = |prepared: &Prepared| {
            let reading = retiming.applied(prepared.reading());
            prepared.clone().with_reading(reading)
        };
        let declared = applied(self.declared.as_ref().unwrap_or(&self.prepared));
        let laws = choose_laws(&declared);
        let (before, after) = (self.laws.as_ref(), laws.as_ref());
        if before
            .zip(after)
            .is_some_and(|(before, after)| before.adds_as(after))
        {
            let mut same = self.with_prepared(applied(&self.prepared))?;
            if let (Some(before), Some(after)) = (&mut same.laws, laws) {
                before.update(after);
            }
            return Ok((same, true));
        }
        let WithLaws {
            prepared,
            laws,
            declared,
        } = WithLaws::new(declared, laws, sources, progress)?;
        let changed = Self {
            inputs: EstimatorInputs::new(prepared.experiment(), prepared.reading().model())?,
            prepared,
            laws,
            declared,
            rigid: self.rigid.clone(),
            unknowns: self.unknowns.clone(),
            about_unknowns: self.about_unknowns.clone(),
        };
        Ok((changed, false))
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
            declared: self.declared.clone(),
            rigid: self.rigid.clone(),
            unknowns: self.unknowns.clone(),
            about_unknowns: self.about_unknowns.clone(),
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
    let Settled {
        prepared,
        unknowns,
        about: about_unknowns,
    } = {
        let prepared = prepare(experiment, model, sources, progress)?;
        refuse(prepared.reading().settings(), prepared.wrong_time_unit())?;
        settled_or_other_meaning(prepared, progress)?.without_laws()
    };
    let (with_laws, rigid) = with_laws(prepared, sources, progress)?;
    let WithLaws {
        prepared,
        laws,
        declared,
    } = with_laws;
    let inputs = EstimatorInputs::new(prepared.experiment(), prepared.reading().model())?;
    Ok(Ready {
        prepared,
        laws,
        declared,
        rigid,
        unknowns,
        about_unknowns,
        inputs,
    })
}

/// Takes joints as rigid whose springs the logs do not show, estimates open Stribeck velocities by likelihood, determines the weights
/// of the samples, and chooses the laws by hold-out.
fn with_laws(
    prepared: Prepared,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<(WithLaws, Vec<RigidJoint>), IdentifyError> {
    let RigidByLog { prepared, joints } = with_joints_rigid_by_log(prepared, progress)?;
    let velocities = likely(prepared.reading(), sources, prepared.excerpt(), progress)?;
    let declared = prepared.with_velocities(&velocities).weighted(progress)?;
    let laws = choose_laws(&declared);
    Ok((WithLaws::new(declared, laws, sources, progress)?, joints))
}

/// The choices with the laws that cross-validation selects, and those without them.
struct WithLaws {
    prepared: Prepared,
    laws: Option<Chosen>,
    declared: Option<Prepared>,
}

impl WithLaws {
    /// Makes all choices again with the laws that are to be added, and estimates their Stribeck velocities by
    /// likelihood.
    ///
    /// - `declared`: the choices without these laws.
    fn new(
        declared: Prepared,
        mut laws: Option<Chosen>,
        sources: &mut [LogSource<'_>],
        progress: &mut dyn Listener,
    ) -> Result<Self, IdentifyError> {
        let richer = (laws.as_mut())
            .map(|chosen| add_laws(&declared, chosen, sources, progress))
            .transpose()?;
        Ok(match richer.flatten() {
            Some(prepared) => Self {
                prepared,
                laws,
                declared: Some(declared),
            },
            None => Self {
                prepared: declared,
                laws,
                declared: None,
            },
        })
    }
}

/// Returns the choices with added laws; `None` if there are none to add.
fn add_laws(
    declared: &Prepared,
    chosen: &mut Chosen,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<Option<Prepared>, IdentifyError> {
    let Some(experiment) = &chosen.experiment else {
        return Ok(None);
    };
    let Ok(model) = Model::new(experiment) else {
        return Ok(None);
    };
    let mut model = model.with_open_stribeck(&chosen.open_velocities);
    let before = declared.reading();
    for &joint in before.model().open_sharpness() {
        model.set_scale(joint, Scale::Sharpness, before.model().sharpness(joint));
    }
    let prepared = declared.again(experiment, &model, progress)?;
    let reading = prepared.reading().with_delays(before.delays());
    let prepared = prepared.with_reading(reading);
    let likely = likely(prepared.reading(), sources, prepared.excerpt(), progress)?;
    let prepared = prepared.with_velocities(&likely);
    let reading = prepared.reading().with_delays(before.delays());
    let prepared = prepared.with_reading(reading);
    let joints = model.joints();
    let velocities = (likely.iter()).filter(|velocity| prepared.uses(velocity));
    chosen.set_velocities(velocities.map(|velocity| FoundVelocity {
        joint: joints[velocity.joint].as_str(),
        velocity: velocity.velocity,
        standard_error: velocity.standard_error,
    }));
    Ok(Some(prepared.weighted(progress)?))
}
