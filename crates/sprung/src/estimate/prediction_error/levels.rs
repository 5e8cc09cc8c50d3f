//! Levels of noise and disturbances, and which of them are unknown.

use super::measurements::{Measurement, Measurements};

/// Bounds of the torque levels, relative to the torque's standard deviation. A larger disturbance
/// is an effect that the model lacks. White noise may be larger, for example that of a current
/// sensor.
const MIN_TORQUE_LEVEL: f64 = 1e-4;
const MAX_TORQUE_NOISE: f64 = 0.5;
const MAX_DISTURBANCE: f64 = 0.25;

/// Bounds of a sensor's noise, relative to the standard deviation of its readings.
const MIN_SENSOR_NOISE: f64 = 1e-8;
const MAX_SENSOR_NOISE: f64 = 0.3;

/// Bounds of the corner frequency of the disturbances, Hz. A log with small disturbances does not
/// determine the corner.
const CORNER_BOUNDS_HZ: (f64, f64) = (0.2, 10.0);

/// A level above this fraction of its upper bound is at the bound.
const AT_BOUND: f64 = 0.99;

/// Levels of noise and disturbances. They determine Q and R of the filter.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Levels {
    /// White noise of the logged torque, held for a period: `σ_w`, N·m (N), \[rows\].
    pub(super) torque_noise: Vec<f64>,
    /// Slow disturbance, a torque with a first-order spectrum: `σ_d`, N·m (N), \[rows\].
    pub(super) disturbance: Vec<f64>,
    /// Corner frequency of that spectrum: `f_d`, Hz.
    pub(super) corner: f64,
    /// Noise of each sensor beyond the noise that its samples show: `σ_s`, rad (m).
    pub(super) sensor_noise: Vec<f64>,
}

impl Levels {
    /// Returns the variance R of a measurement.
    pub(super) fn measurement_variance(&self, measurement: &Measurement) -> f64 {
        measurement.variance + self.sensor_noise[measurement.sensor].powi(2)
    }

    /// Returns the decay of a disturbance over a period.
    ///
    /// - `period`: s.
    pub(super) fn decay(&self, period: f64) -> Decay {
        Decay::new(self.corner, period)
    }

    /// Returns the variance that a period adds to a disturbance, `σ_d² (1 − a²)`.
    pub(super) fn added_variance(&self, row: usize, decay: Decay) -> f64 {
        self.disturbance[row].powi(2) * (1.0 - decay.factor * decay.factor)
    }
}

/// Decay of a disturbance over a period.
#[derive(Clone, Copy, Debug)]
pub(super) struct Decay {
    /// `a = exp(−2π f_d T)`.
    pub(super) factor: f64,
    /// Derivative of the factor by the logarithm of the corner.
    pub(super) by_log_corner: f64,
}

impl Decay {
    /// - `corner`: Hz; `period`: s.
    pub(super) fn new(corner: f64, period: f64) -> Self {
        let factor = (-std::f64::consts::TAU * corner * period).exp();
        Self {
            factor,
            by_log_corner: factor * factor.ln(),
        }
    }
}

/// One level: of a row, of a sensor, or the corner of all disturbances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Level {
    TorqueNoise(usize),
    Disturbance(usize),
    SensorNoise(usize),
    Corner,
}

/// The unknown levels and their bounds.
#[derive(Clone, Debug)]
pub(super) struct UnknownLevels {
    pub(super) all: Vec<Level>,
    pub(super) bounds: Vec<(f64, f64)>,
}

impl UnknownLevels {
    /// - `noisy_torques`: whether each row has white noise of unknown level.
    /// - `noisy_sensors`: whether each sensor has noise beyond the noise that its samples show.
    pub(super) fn new(
        measurements: &Measurements,
        noisy_torques: &[bool],
        noisy_sensors: &[bool],
    ) -> Self {
        let scales = &measurements.torque_scale;
        let indices = |noisy: &[bool]| -> Vec<usize> {
            (0..noisy.len()).filter(|&index| noisy[index]).collect()
        };
        let torques = indices(noisy_torques).into_iter();
        let sensors = indices(noisy_sensors).into_iter();
        let all: Vec<Level> = (torques.map(Level::TorqueNoise))
            .chain((0..scales.len()).map(Level::Disturbance))
            .chain([Level::Corner])
            .chain(sensors.map(Level::SensorNoise))
            .collect();
        let bounds = all.iter().map(|level| match *level {
            Level::TorqueNoise(row) => (
                MIN_TORQUE_LEVEL * scales[row],
                MAX_TORQUE_NOISE * scales[row],
            ),
            Level::Disturbance(row) => (
                MIN_TORQUE_LEVEL * scales[row],
                MAX_DISTURBANCE * scales[row],
            ),
            Level::SensorNoise(sensor) => {
                let scale = measurements.sensors[sensor].scale;
                (MIN_SENSOR_NOISE * scale, MAX_SENSOR_NOISE * scale)
            }
            Level::Corner => CORNER_BOUNDS_HZ,
        });
        Self {
            bounds: bounds.collect(),
            all,
        }
    }

    /// Returns the logarithms of the unknown levels.
    pub(super) fn logarithms(&self, levels: &Levels) -> Vec<f64> {
        let value = |level: &Level| match *level {
            Level::TorqueNoise(row) => levels.torque_noise[row],
            Level::Disturbance(row) => levels.disturbance[row],
            Level::SensorNoise(sensor) => levels.sensor_noise[sensor],
            Level::Corner => levels.corner,
        };
        self.all.iter().map(|level| value(level).ln()).collect()
    }

    /// Returns the levels with other logarithms of the unknown ones, limited to their bounds.
    pub(super) fn levels(&self, known: &Levels, logarithms: &[f64]) -> Levels {
        let mut levels = known.clone();
        for ((level, log), (low, high)) in self.all.iter().zip(logarithms).zip(&self.bounds) {
            let value = log.exp().clamp(*low, *high);
            match *level {
                Level::TorqueNoise(row) => levels.torque_noise[row] = value,
                Level::Disturbance(row) => levels.disturbance[row] = value,
                Level::SensorNoise(sensor) => levels.sensor_noise[sensor] = value,
                Level::Corner => levels.corner = value,
            }
        }
        levels
    }

    /// Returns whether the disturbance of a row is at its upper bound.
    pub(super) fn disturbance_at_bound(&self, levels: &Levels, row: usize) -> bool {
        let values = self.logarithms(levels);
        (self.all.iter().zip(&self.bounds).zip(values)).any(|((level, (_, high)), log)| {
            *level == Level::Disturbance(row) && log.exp() > AT_BOUND * high
        })
    }
}
