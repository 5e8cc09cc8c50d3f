//! What estimators ask of an experiment beside its log.

use super::error::IdentifyError;
use crate::description::{
    Controller, ControllerKind, Estimator, Experiment, Feedforward, StartName,
};
use crate::model::{Model, Theta};
use crate::prepare::PrepareError;

/// What the estimators that are asked for take from the experiment.
pub(super) struct Asked<'a> {
    /// The controller that output error simulates, if it is asked for.
    pub(super) controller: Option<&'a Controller>,
    /// Values that a refinement starts from, if not those of least squares, \[p\].
    pub(super) nominal: Option<Theta>,
}

impl<'a> Asked<'a> {
    /// Returns what is asked, before a log is read.
    ///
    /// # Errors
    ///
    /// [`IdentifyError::Prepare`], [`IdentifyError::Controller`] or [`IdentifyError::Start`] if the
    /// experiment does not give it.
    pub(super) fn new(experiment: &'a Experiment, model: &Model) -> Result<Self, IdentifyError> {
        if experiment.log.is_none() {
            return Err(PrepareError::NoLog.into());
        }
        let nominal = match experiment.identify.start {
            StartName::LeastSquares => None,
            StartName::Nominal => Some(model.nominal().map_err(IdentifyError::Start)?),
        };
        Ok(Self {
            controller: loop_controller(experiment)?,
            nominal,
        })
    }
}

/// Returns the controller that output error simulates, if it is asked for.
fn loop_controller(experiment: &Experiment) -> Result<Option<&Controller>, IdentifyError> {
    if !(experiment.identify.estimator).contains(&Estimator::OutputError) {
        return Ok(None);
    }
    let controller = experiment.controller.as_ref();
    let controller = controller.ok_or(IdentifyError::Controller(
        "the experiment has no [controller]; give gains and reference of what ran during the log",
    ))?;
    if controller.kind == ControllerKind::StateFeedback
        && controller.feedforward == Feedforward::Identified
    {
        return Err(IdentifyError::Controller(
            "the feedforward of a controller that ran before cannot have used the parameters to be \
             identified; set feedforward = \"nominal\" in [controller]",
        ));
    }
    Ok(Some(controller))
}
