//! Levels that a refinement starts from, and those that it searches.

use super::level_search::EXPECTED_CORNER_HZ;
use super::levels::{Levels, UnknownLevels};
use super::measurements::{Measurements, Noise};
use crate::log::Channels;
use crate::model::Model;

/// Levels of motor torques, of torques on links, and of the noise of a torque that is said
/// to be exact, as parts of the torque's standard deviation.
const START_MOTOR_LEVEL: f64 = 0.01;
const START_LINK_LEVEL: f64 = 0.003;
const EXACT_TORQUE_NOISE: f64 = 1e-3;

/// Noise of a sensor without counts, as a part of the standard deviation of what it shows.
const START_SENSOR_NOISE: f64 = 1e-3;

/// What is known of the logged torque.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TorqueNoise {
    /// It is what acted.
    Exact,
    /// It has white noise of a level that is unknown.
    Unknown,
}

impl TorqueNoise {
    /// Returns what the columns of a log say.
    pub(super) fn of(channels: &Channels) -> Self {
        if channels.exact_torque {
            Self::Exact
        } else {
            Self::Unknown
        }
    }
}

/// Returns the levels that a refinement starts from.
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

/// Returns levels with noise of every sensor.
pub(super) fn with_sensor_noise(mut levels: Levels, measurements: &Measurements) -> Levels {
    for (level, sensor) in levels.sensor_noise.iter_mut().zip(&measurements.sensors) {
        *level = level.max(START_SENSOR_NOISE * sensor.scale);
    }
    levels
}

/// Levels to search.
#[derive(Clone, Debug)]
pub(super) struct Searches {
    /// With noise of the sensors that show some.
    pub(super) shown: UnknownLevels,
    /// With noise of every sensor.
    pub(super) every_sensor: UnknownLevels,
}

impl Searches {
    /// - `levels`: at the start; a sensor whose noise is not zero shows some.
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
