//! Inputs that estimators need from the experiment besides its log.

use crate::description::{
    Controller, ControllerKind, Estimator, Experiment, Feedforward, StartName,
};
use crate::estimate::errors::IdentifyError;
use crate::model::{Model, Theta};
use crate::prepare::PrepareError;

/// Inputs that the requested estimators need from the experiment.
pub(in crate::estimate) struct EstimatorInputs {
    /// Controller that output error simulates; `None` if output error is not requested.
    pub(in crate::estimate) controller: Option<Controller>,
    /// Nominal parameters from which the refinement starts, \[p\]; `None` if it starts from least
    /// squares.
    pub(in crate::estimate) nominal: Option<Theta>,
}

impl EstimatorInputs {
    /// Collects the inputs before a log is read.
    ///
    /// # Errors
    ///
    /// [`IdentifyError::Prepare`], [`IdentifyError::Controller`] or [`IdentifyError::Start`] if the
    /// experiment does not contain a needed input.
    pub(super) fn new(experiment: &Experiment, model: &Model) -> Result<Self, IdentifyError> {
        if experiment.log.is_none() {
            return Err(PrepareError::NoLog.into());
        }
        let nominal = match experiment.identify.start {
            StartName::LeastSquares => None,
            StartName::Nominal => Some(model.nominal().map_err(IdentifyError::Start)?),
        };
        Ok(Self {
            controller: loop_controller(experiment)?.cloned(),
            nominal,
        })
    }
}

/// Returns the controller that output error simulates; `None` if output error is not requested.
fn loop_controller(experiment: &Experiment) -> Result<Option<&Controller>, IdentifyError> {
    if !(experiment.identify.estimator).contains(&Estimator::OutputError) {
        return Ok(None);
    }
    let controller = experiment.controller.as_ref();
    let controller = controller.ok_or(IdentifyError::Controller(
        "the experiment has no [controller]; give gains and reference of the controller that ran \
         during the log",
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
