//! Errors of an identification.

use super::lsff::LsffError;
use crate::check::Refusal;
use crate::log::{ChannelError, LogError};
use crate::model::ModelError;
use crate::prepare::PrepareError;
use crate::progress::Stopped;
use crate::regression::PassError;

/// Reason why logs cannot be identified.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IdentifyError {
    /// The logs cannot be prepared.
    #[error(transparent)]
    Prepare(PrepareError),
    /// The refinement is to start from nominal values, but the experiment does not give all of
    /// them.
    #[error("[identify] start = \"nominal\" needs nominal values: {0}")]
    Start(ModelError),
    /// LSFF cannot be built.
    #[error(transparent)]
    Lsff(#[from] LsffError),
    /// A log is faulty, or it does not fit the filters.
    #[error(transparent)]
    Pass(PassError),
    /// The caller stopped the identification.
    #[error(transparent)]
    Stopped(#[from] Stopped),
    /// A log contradicts the experiment file.
    #[error("{0}; to go on nevertheless set on_check_error = \"go-on\" in [identify]")]
    Refused(Refusal),
    /// Given values and limits exclude each other.
    #[error(
        "no robot can exist with the given values and limits: {0}; compare fixed, assume_zero, total_mass_kg and \
         mass_kg with the robot, or set constraints = \"none\" in [identify]"
    )]
    NoRobot(String),
    /// The regression or its solution is not finite.
    #[error(
        "the regression of {file} holds numbers that are not finite; are the units of its columns \
         right?"
    )]
    NotFinite {
        /// Names of the logs.
        file: String,
    },
}

impl From<PassError> for IdentifyError {
    #[expect(clippy::wildcard_enum_match_arm, reason = "all other errors pass")]
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
    #[expect(clippy::wildcard_enum_match_arm, reason = "all other errors pass")]
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
