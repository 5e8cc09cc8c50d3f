//! Inputs that estimators need from the experiment besides its log.

use crate::description::{Experiment, StartName};
use crate::estimate::errors::IdentifyError;
use crate::model::{Model, Theta};
use crate::prepare::PrepareError;

/// Inputs that the requested estimators need from the experiment.
pub(in crate::estimate) struct EstimatorInputs {
    /// Nominal parameters from which the refinement starts, \[p\]; `None` if it starts from least
    /// squares.
    pub(in crate::estimate) nominal: Option<Theta>,
}

impl EstimatorInputs {
    /// Collects the inputs before a log is read.
    ///
    /// # Errors
    ///
    /// [`IdentifyError::Prepare`] or [`IdentifyError::Start`] if the experiment does not contain a needed input.
    pub(super) fn new(experiment: &Experiment, model: &Model) -> Result<Self, IdentifyError> {
        if experiment.log.is_none() {
            return Err(PrepareError::NoLog.into());
        }
        let nominal = match experiment.identify.start {
            StartName::LeastSquares => None,
            StartName::Nominal => Some(model.nominal().map_err(IdentifyError::Start)?),
        };
        Ok(Self { nominal })
    }
}
