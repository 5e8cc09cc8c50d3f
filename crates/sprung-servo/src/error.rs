//! Errors of a servo's identification.

use crate::log::LogError;
use crate::progress::Stopped;

/// Errors of a servo's identification.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ServoError {
    /// A log cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The caller stopped the run.
    #[error(transparent)]
    Stopped(#[from] Stopped),
    /// The servo does not move in a log.
    #[error(
        "the position in {log} stays within a few steps of its sensor; record a log in which the servo \
         moves, and check that motor_position names the measured position"
    )]
    NoMotion {
        /// Name of the log.
        log: String,
    },
    /// A switch has another value than 0 or 1.
    #[error(
        "{log}, column \"{column}\" at {time} s: drive_on is {value}; it must be 1 while the drive is on and \
         0 while it is off"
    )]
    NotASwitch {
        /// Name of the log.
        log: String,
        /// Name of the column.
        column: String,
        /// Time, s.
        time: f64,
        /// The value.
        value: f64,
    },
    /// The torque by the drive law is against the motion.
    #[error(
        "the targets do not drive the positions: the torque by the drive law has the wrong sign or no \
         effect; check that motor_target and motor_position have the same zero, unit and sign, that \
         gain_duty_per_rad or gain_a_per_rad is that of the firmware, and that the payload hangs where \
         com_m says"
    )]
    NotDriven,
}
