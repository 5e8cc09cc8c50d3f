//! What keeps logs from being identified.

use super::lsff::LsffError;
use crate::check::Refusal;
use crate::log::{ChannelError, LogError};
use crate::model::ModelError;
use crate::prepare::PrepareError;
use crate::progress::Stopped;
use crate::regression::PassError;

/// What keeps a log from being identified.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IdentifyError {
    /// The logs cannot be prepared.
    #[error(transparent)]
    Prepare(PrepareError),
    /// Output error has no controller to simulate.
    #[error(
        "estimator \"output-error\" simulates the closed loop, and {0}; or use \"least-squares\", which \
         needs no controller"
    )]
    Controller(&'static str),
    /// The refinement is to start from values that the file does not give.
    #[error("[identify] start = \"nominal\" needs nominal values: {0}")]
    Start(ModelError),
    /// LSFF cannot be built.
    #[error(transparent)]
    Lsff(#[from] LsffError),
    /// The log is wrong, or does not fit the filters.
    #[error(transparent)]
    Pass(PassError),
    /// The caller stopped it.
    #[error(transparent)]
    Stopped(#[from] Stopped),
    /// The log is not what the experiment file says.
    #[error("{0}; to go on nevertheless set on_check_error = \"go-on\" in [identify]")]
    Refused(Refusal),
    /// The numbers leave the range that can be computed with.
    #[error(
        "the regression of {file} holds numbers that are not finite; are the units of its columns \
         right?"
    )]
    NotFinite {
        /// Name of the log.
        file: String,
    },
}

impl From<PassError> for IdentifyError {
    fn from(error: PassError) -> Self {
        match error {
            PassError::Stopped(stopped) => Self::Stopped(stopped),
            error => Self::Pass(error),
        }
    }
}

impl From<LogError> for IdentifyError {
    fn from(error: LogError) -> Self {
        Self::Pass(error.into())
    }
}

impl From<PrepareError> for IdentifyError {
    fn from(error: PrepareError) -> Self {
        match error {
            PrepareError::Log(error) => error.into(),
            PrepareError::Stopped(stopped) => Self::Stopped(stopped),
            error => Self::Prepare(error),
        }
    }
}

impl From<ChannelError> for IdentifyError {
    fn from(error: ChannelError) -> Self {
        Self::Prepare(error.into())
    }
}
