//! Errors of a validation.

use crate::log::ChannelError;
use crate::model::ModelError;
use crate::progress::Stopped;
use crate::regression::PassError;

/// Errors of a validation.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ValidateError {
    /// The experiment has no `[[validate]]` block.
    #[error(
        "the experiment has no [[validate]] block; add one with a name, a log and a controller"
    )]
    NoRuns,
    /// The experiment names no log.
    #[error("the experiment has no [log]; say which columns its logs have")]
    NoLog,
    /// The description of a log is not complete.
    #[error(transparent)]
    Channel(#[from] ChannelError),
    /// A delay is to be estimated, but only an identification estimates delays.
    #[error(
        "the delay of \"{column}\" is to be estimated, but the parameter file does not contain the \
         estimate; give it as a number in delay_s"
    )]
    UnknownDelay {
        /// Name of the column.
        column: String,
    },
    /// A sign or a gain is to be estimated, but only an identification estimates them.
    #[error(
        "the sign or gain of \"{column}\" is to be estimated, but the parameter file does not contain the \
         estimate; give it as a number"
    )]
    UnknownFactor {
        /// Name of the column.
        column: String,
    },
    /// Sensors on the links move the link positions, which an observer on line does not do.
    #[error(
        "sprung watch needs link encoders, torque sensors or motor torques; it does not use gyroscopes and accelerometers"
    )]
    InertialSensors,
    /// Every log of the healthy robot has a payload that is not known.
    #[error(
        "every log of the experiment carries an unknown payload; name one without it, or give the payload, to learn from it"
    )]
    NoHealthyLog,
    /// A log to watch has another sampling rate than the healthy ones.
    #[error(
        "{file} has {found:.0} samples per second, and the healthy logs have {learned:.0}, so their thresholds do not hold; log \
         both at the same rate"
    )]
    OtherRate {
        /// Name of the log.
        file: String,
        /// Its rate, Hz.
        found: f64,
        /// Rate of the healthy logs, Hz.
        learned: f64,
    },
    /// The model has no parameter with a name of the parameter file.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A log is faulty or does not fit the filters.
    #[error(transparent)]
    Pass(PassError),
    /// The caller stopped the validation.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl From<PassError> for ValidateError {
    #[expect(clippy::wildcard_enum_match_arm, reason = "all other errors pass")]
    fn from(error: PassError) -> Self {
        match error {
            PassError::Stopped(stopped) => Self::Stopped(stopped),
            error => Self::Pass(error),
        }
    }
}
