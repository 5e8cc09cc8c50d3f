//! Start levels of a refinement, and the levels that are searched.

use super::level_search::EXPECTED_CORNER_HZ;
use super::levels::{Levels, UnknownLevels};
use super::measurements::{Measurements, Noise};
use crate::log::Channels;
use crate::model::Model;

/// Start levels relative to the torque's standard deviation: noise and disturbance of motor
/// torques, disturbance of links, and noise of a torque that is declared exact.
const START_MOTOR_LEVEL: f64 = 0.01;
const START_LINK_LEVEL: f64 = 0.003;
const EXACT_TORQUE_NOISE: f64 = 1e-3;

/// Start level of a sensor's noise, relative to the standard deviation of its readings.
const START_SENSOR_NOISE: f64 = 1e-3;

/// Accuracy of the logged torque.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TorqueNoise {
    /// The logged torque is the acting torque.
    Exact,
    /// The logged torque has white noise of unknown level.
    Unknown,
}

impl TorqueNoise {
    /// Returns the accuracy that the description of the columns states.
    pub(super) fn of(channels: &Channels) -> Self {
        if channels.exact_torque {
            Self::Exact
        } else {
            Self::Unknown
        }
    }
}

/// Returns the start levels of a refinement.
pub(super) fn start_levels(
    model: &Model,
    measurements: &Measurements,
    torque_noise: TorqueNoise,
) -> Levels {
    let noise = match torque_noise {
        TorqueNoise::Exact => EXACT_TORQUE_NOISE,
        TorqueNoise::Unknown => START_MOTOR_LEVEL,
    };
    let scaled = |motor: f64, link: f64| -> Vec<f64> {
        (measurements.torque_scale.iter().enumerate())
            .map(|(row, scale)| {
                let part = if model.is_torque_row(row) {
                    motor
                } else {
                    link
                };
                scale * part
            })
            .collect()
    };
    let sensors = measurements.sensors.iter();
    Levels {
        torque_noise: scaled(noise, 0.0),
        disturbance: scaled(START_MOTOR_LEVEL, START_LINK_LEVEL),
        corner: EXPECTED_CORNER_HZ,
        sensor_noise: sensors
            .map(|sensor| match sensor.noise {
                Noise::Counts(_) => 0.0,
                Noise::White(_) => START_SENSOR_NOISE * sensor.scale,
            })
            .collect(),
    }
}

/// Returns levels in which every sensor has noise.
pub(super) fn with_sensor_noise(mut levels: Levels, measurements: &Measurements) -> Levels {
    for (level, sensor) in levels.sensor_noise.iter_mut().zip(&measurements.sensors) {
        *level = level.max(START_SENSOR_NOISE * sensor.scale);
    }
    levels
}

/// Sets of levels to be searched.
#[derive(Clone, Debug)]
pub(super) struct Searches {
    /// Levels with noise only of the sensors that show noise.
    pub(super) shown: UnknownLevels,
    /// Levels with noise of every sensor.
    pub(super) every_sensor: UnknownLevels,
}

impl Searches {
    /// - `levels`: start levels. A sensor whose level is not zero shows noise.
    pub(super) fn new(
        model: &Model,
        measurements: &Measurements,
        torque_noise: TorqueNoise,
        levels: &Levels,
    ) -> Self {
        let torques: Vec<bool> = (0..model.rows())
            .map(|row| model.is_torque_row(row) && torque_noise == TorqueNoise::Unknown)
            .collect();
        let shown: Vec<bool> = (measurements.sensors.iter().zip(&levels.sensor_noise))
            .map(|(sensor, level)| matches!(sensor.noise, Noise::White(_)) || *level > 0.0)
            .collect();
        Self {
            every_sensor: UnknownLevels::new(measurements, &torques, &vec![true; shown.len()]),
            shown: UnknownLevels::new(measurements, &torques, &shown),
        }
    }
}
