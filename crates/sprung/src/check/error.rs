//! What keeps logs from being checked.

use crate::log::{ChannelError, LogError};
use crate::prepare::{DelayError, FactorError, PrepareError};
use crate::progress::Stopped;

/// What keeps a log from being checked.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckError {
    /// The experiment names no log.
    #[error("the experiment has no [log]; say which file to check")]
    NoLog,
    /// The description of the log is not complete.
    #[error(transparent)]
    Channel(#[from] ChannelError),
    /// A delay cannot be estimated.
    #[error(transparent)]
    Delay(#[from] DelayError),
    /// A sign or a gain cannot be estimated.
    #[error(transparent)]
    Factor(FactorError),
    /// The log cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The caller stopped it.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl From<PrepareError> for CheckError {
    fn from(error: PrepareError) -> Self {
        match error {
            PrepareError::NoLog => Self::NoLog,
            PrepareError::Channel(error) => Self::Channel(error),
            PrepareError::Delay(error) => Self::Delay(error),
            PrepareError::Factor(error) => Self::Factor(error),
            PrepareError::Log(error) => Self::Log(error),
            PrepareError::Stopped(stopped) => Self::Stopped(stopped),
        }
    }
}
