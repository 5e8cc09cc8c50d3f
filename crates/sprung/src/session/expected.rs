//! Expected standard errors of an experiment, before its recording.

use std::collections::BTreeMap;
use std::io::{Cursor, Result as IoResult};
use std::path::Path;

use serde::Serialize;

use super::error::SessionError;
use super::load::Session;
use super::simulate::Recording;
use sprung_base::progress::Listener;
use sprung_log::{Input, LogSource};
use sprung_method::estimate::{Bound, KnownNoise, KnownTruth, information_bound};

/// Part of the largest parameter with the same unit below which a standard error counts as small for a parameter of zero.
const SMALL_PART: f64 = 0.01;

/// The expected standard error of one parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExpectedError {
    /// Name of the parameter.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Value of the twin, SI units.
    pub value: f64,
    /// Smallest standard error of an unbiased estimate, SI units: the bound of Cramér and Rao.
    pub standard_error: f64,
    /// Whether the standard error is smaller than the value, or than a hundredth of the largest value with its unit.
    pub is_determined: bool,
}

impl Session {
    /// Returns the expected standard errors of a twin's experiment: the Cramér-Rao bound of each unknown parameter for
    /// its motion, its sensors, its noise and its disturbances. The refinement reaches it where the model matches the
    /// robot.
    ///
    /// - `twin`: of this session.
    ///
    /// # Errors
    ///
    /// [`SessionError`] if the loop cannot be simulated, the twin measures a position without error, or the log is too
    /// short.
    ///
    /// # Source
    ///
    /// Ljung, System Identification, chapter 7.
    pub fn expected_errors(
        &self,
        twin: &Recording<'_>,
        progress: &mut dyn Listener,
    ) -> Result<Vec<ExpectedError>, SessionError> {
        let bound = self.bound(twin, progress)?.standard_errors();
        let largest = |unit: &str| {
            (twin.model.parameters().iter().zip(&twin.theta))
                .filter(|(parameter, _)| parameter.unit == unit)
                .fold(0.0, |most: f64, (_, value)| most.max(value.abs()))
        };
        let parameters = twin.model.parameters().iter().zip(&twin.theta);
        Ok((parameters.zip(bound))
            .filter(|((parameter, _), _)| parameter.fixed.is_none())
            .map(|((parameter, &value), standard_error)| ExpectedError {
                name: parameter.name.clone(),
                unit: parameter.unit.to_owned(),
                value,
                standard_error,
                is_determined: standard_error
                    < value.abs().max(SMALL_PART * largest(parameter.unit)),
            })
            .collect())
    }

    /// Returns the smallest covariance of the parameters for the experiment of a twin.
    ///
    /// # Errors
    ///
    /// Those of [`expected_errors`](Self::expected_errors).
    pub(super) fn bound(
        &self,
        twin: &Recording<'_>,
        progress: &mut dyn Listener,
    ) -> Result<Bound, SessionError> {
        let session = match twin.overlay {
            Some(over) => self.with_log(over)?,
            None => self.clone(),
        };
        let experiment = session.experiment();
        twin.require_noise(experiment.robot.joint.len())?;
        let mut log = Vec::new();
        twin.write(&mut log, progress)?;
        let mut open = |_: Option<&Path>| -> IoResult<Box<dyn Input>> {
            Ok(Box::new(Cursor::new(log.clone())))
        };
        let name = twin.named().display().to_string();
        let source = LogSource::files(&name, &mut open);
        let delays = BTreeMap::new();
        let truth = KnownTruth {
            theta: &twin.theta,
            noise: &KnownNoise::from(&twin.settings),
            delays: &delays,
        };
        let bound = information_bound(experiment, &twin.model, truth, &mut [source])?;
        bound.ok_or(SessionError::NoBound)
    }
}
