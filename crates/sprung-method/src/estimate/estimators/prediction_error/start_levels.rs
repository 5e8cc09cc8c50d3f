//! Start levels of a refinement, and the levels that are searched.

use super::level_search::EXPECTED_CORNER_HZ;
use super::levels::{Levels, Unknown, UnknownLevels};
use super::measurements::{Measurements, Noise};
use super::rung::Rung;
use crate::log::Channels;
use crate::model::Model;

/// Start level relative to the standard deviation of the torque: of noise and disturbance of motors, and of links while
/// friction reverses. Half the value moves an estimate by 0.05 standard errors, twice the value by 0.02.
const START: f64 = 0.01;

/// Start level of motors while friction reverses, and largest start level of the torque's noise. Twice the value moves
/// an estimate by 0.03 standard errors, half the value by less than 0.01.
const LARGE_START: f64 = 0.1;

/// Noise of a torque that is declared exact, which the likelihood needs above zero, and start level of a sensor's
/// noise, relative to the standard deviation of its readings.
const SMALL_START: f64 = 1e-3;

/// Start level of links: they have no motor, so disturbances are smaller. Half or twice the value moves an estimate by
/// 0.03 standard errors.
const START_LINK_LEVEL: f64 = 0.003;

/// Accuracy of the logged torque.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TorqueNoise {
    /// The logged torque is the acting torque.
    Exact,
    /// The logged torque has white noise of unknown level.
    Unknown,
}

impl TorqueNoise {
    /// Returns the rows whose logged torque has noise.
    pub(super) fn rows(self, model: &Model) -> Vec<usize> {
        let rows = 0..model.coordinates();
        match self {
            Self::Exact => Vec::new(),
            Self::Unknown => rows.filter(|&row| model.is_torque_row(row)).collect(),
        }
    }

    /// Returns the accuracy that the description of the columns states. If a controller holds torques for a shorter
    /// time than the period of the log, the log has only one of them per period.
    ///
    /// - `period`: of the log, s.
    pub(super) fn of(channels: &Channels, period: f64) -> Self {
        let lacks_torques = (channels.torque_hold).is_some_and(|hold| hold.lacks_torques(period));
        if channels.exact_torque && !lacks_torques {
            Self::Exact
        } else {
            Self::Unknown
        }
    }
}

/// Returns the start levels of a rung.
pub(super) fn start_levels(
    model: &Model,
    measurements: &Measurements,
    torque_noise: TorqueNoise,
    rung: Rung,
) -> Levels {
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
    let mut reversal_noise = scaled(LARGE_START, START);
    for (noise, reverses) in reversal_noise.iter_mut().zip(measurements.reversals.rows()) {
        if !reverses {
            *noise = 0.0;
        }
    }
    let mut noise = match (torque_noise, rung) {
        (TorqueNoise::Exact, Rung::Free) => scaled(SMALL_START, START_LINK_LEVEL),
        _ => scaled(START, START_LINK_LEVEL),
    };
    // Too little noise at the start biases the inertia of a light rotor, and then the levels
    // attribute the error to disturbances.
    for row in torque_noise.rows(model) {
        let scale = measurements.torque_scale[row];
        let fast = measurements.fast_noise[row];
        noise[row] = fast.clamp(SMALL_START * scale, LARGE_START * scale);
    }
    let sensors = measurements.sensors.iter();
    Levels {
        torque_noise: noise,
        reversal_noise,
        disturbance: match rung {
            Rung::Flat => vec![0.0; model.coordinates()],
            Rung::Free | Rung::Cap10 | Rung::Cap3 => scaled(START, START_LINK_LEVEL),
        },
        corner: EXPECTED_CORNER_HZ,
        sensor_noise: sensors
            .map(|sensor| match sensor.noise {
                Noise::Counts(_) => 0.0,
                Noise::White(_) => SMALL_START * sensor.scale,
            })
            .collect(),
    }
}

/// Returns the start levels of a rung after another rung: its levels, but white noise and noise at
/// reversals of at least the usual start, because they explain more on a lower rung.
pub(super) fn levels_after(before: &Levels, usual: &Levels, rung: Rung) -> Levels {
    let at_least = |values: &[f64], least: &[f64]| -> Vec<f64> {
        values.iter().zip(least).map(|(a, b)| a.max(*b)).collect()
    };
    Levels {
        torque_noise: at_least(&before.torque_noise, &usual.torque_noise),
        reversal_noise: at_least(&before.reversal_noise, &usual.reversal_noise),
        disturbance: match rung {
            Rung::Flat => usual.disturbance.clone(),
            Rung::Free | Rung::Cap10 | Rung::Cap3 => before.disturbance.clone(),
        },
        corner: usual.corner,
        sensor_noise: before.sensor_noise.clone(),
    }
}

/// Returns levels in which every sensor has noise.
pub(super) fn with_sensor_noise(mut levels: Levels, measurements: &Measurements) -> Levels {
    for (level, sensor) in levels.sensor_noise.iter_mut().zip(&measurements.sensors) {
        *level = level.max(SMALL_START * sensor.scale);
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
        rung: Rung,
        levels: &Levels,
    ) -> Self {
        // Without free disturbances white noise also covers effects that the model lacks.
        let exact = torque_noise == TorqueNoise::Exact && rung == Rung::Free;
        let torques: Vec<bool> = (0..model.coordinates())
            .map(|row| !(exact && model.is_torque_row(row)))
            .collect();
        let shown: Vec<bool> = (measurements.sensors.iter().zip(&levels.sensor_noise))
            .map(|(sensor, level)| matches!(sensor.noise, Noise::White(_)) || *level > 0.0)
            .collect();
        let levels = |sensors: Vec<bool>| {
            let unknown = Unknown {
                torques: torques.clone(),
                reversals: measurements.reversals.rows(),
                disturbances: rung.disturbances(),
                sensors,
            };
            UnknownLevels::new(measurements, &unknown)
        };
        Self {
            every_sensor: levels(vec![true; shown.len()]),
            shown: levels(shown),
        }
    }
}
