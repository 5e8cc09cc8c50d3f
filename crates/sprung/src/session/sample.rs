//! Draws robots from the posterior of an identification.

use super::error::SessionError;
use super::export::result_of;
use super::load::Session;
use super::parameters::Parameters;
use sprung_method::estimate::{Posterior, Samples, Verdict};

/// What robots are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleRequest {
    /// Number of robots, 1 to 100 000.
    pub count: usize,
    /// Random seed. The same seed gives the same robots.
    pub seed: u64,
    /// Index of the result, one for each estimator of the identification.
    pub set: usize,
    /// Whether robots are drawn from a result whose verdict is *unusable* as well.
    pub accept_unusable: bool,
}

impl Default for SampleRequest {
    /// 1000 robots of the first result, unless it is unusable.
    fn default() -> Self {
        Self {
            count: 1000,
            seed: 0,
            set: 0,
            accept_unusable: false,
        }
    }
}

impl Session {
    /// Draws robots that can exist from the posterior of an identification.
    ///
    /// - `parameters`: those of an identification, from [`Parameters::open`] or `Parameters::from`.
    ///
    /// # Errors
    ///
    /// [`SessionError::NoPosterior`] if the parameters come from no identification, [`SessionError::NoResult`] if there is no
    /// such result, [`SessionError::UnusableResult`] for a verdict *unusable*, and [`SessionError::Posterior`] if the result
    /// has no covariance, belongs to another robot, or no robot can exist.
    pub fn sample(
        &self,
        parameters: &Parameters,
        request: &SampleRequest,
    ) -> Result<Samples, SessionError> {
        let found = (parameters.identification.as_ref()).ok_or(SessionError::NoPosterior)?;
        let result = result_of(found, request.set)?;
        if result.verdict == Verdict::Unusable && !request.accept_unusable {
            return Err(SessionError::UnusableResult {
                estimator: result.estimator.clone(),
                because: result.decision.because.clone(),
            });
        }
        let (experiment, model) = self.described_by(parameters)?;
        let posterior = Posterior::new(&model, &experiment.identify.physical, result)?;
        Ok(posterior.sample(request.count, request.seed)?)
    }
}
