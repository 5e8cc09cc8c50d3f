//! Levels of noise and disturbances, known and unknown ones.

use super::measurements::{Measurement, Measurements};
use crate::estimate::statistics::NEGLIGIBLE_SHARE;

/// Bounds of the torque levels, relative to the torque's standard deviation. A larger disturbance is an effect that the
/// model lacks. White noise may be larger, for example that of a current sensor. Twice the value moves an estimate of a
/// short log of the demo by 2.6 standard errors, half the value by 0.3.
const MIN_TORQUE_LEVEL: f64 = 1e-4;

/// Largest noise of a torque, relative to its standard deviation.
const MAX_TORQUE_NOISE: f64 = 0.5;

/// The same if the noise contains errors of the model, and while friction reverses: a joint that friction holds at rest
/// needs a noise of several times the torque.
const MAX_WITH_MODEL_ERROR: f64 = 10.0;

/// Largest disturbance, relative to the standard deviation of the torque; a larger one replaces the model.
const MAX_DISTURBANCE: f64 = 0.25;

/// Bounds of a sensor's noise, relative to the standard deviation of its readings.
const MIN_SENSOR_NOISE: f64 = 1e-8;

/// Largest noise of a sensor relative to the standard deviation of its reading.
const MAX_SENSOR_NOISE: f64 = 0.3;

/// Bounds of the corner frequency of the disturbances, Hz. A log with small disturbances does not determine the corner.
/// Half or twice both values moves an estimate of a short log by 0.15 standard errors.
const CORNER_BOUNDS_HZ: (f64, f64) = (0.2, 10.0);

/// Levels of noise and disturbances. They determine Q and R of the filter.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Levels {
    /// White noise of the logged torque, held for a period: `σ_w`, N·m (N), \[rows\].
    pub(super) torque_noise: Vec<f64>,
    /// Further white noise of the torque while the row's Coulomb friction reverses: `σ_t`, N·m
    /// (N), \[rows\]; zero in rows without Coulomb friction.
    pub(super) reversal_noise: Vec<f64>,
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

    /// Returns the variance of a row's white torque noise over a period.
    ///
    /// - `reversal`: how near the row's friction is to a reversal, from 0 to 1.
    pub(super) fn torque_variance(&self, row: usize, reversal: f64) -> f64 {
        self.torque_noise[row].powi(2) + reversal * self.reversal_noise[row].powi(2)
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
    ReversalNoise(usize),
    Disturbance(usize),
    SensorNoise(usize),
    Corner,
}

/// Freedom of the slow disturbances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Disturbances {
    /// Their levels have only the fixed bounds.
    Free,
    /// Their spectrum at zero frequency is at most this multiple of that of the torque's white
    /// noise: `2 σ_d²/ω_d ≤ R σ_w² T`. The corner is the expected one.
    Capped(f64),
    /// They are zero.
    Zero,
}

/// The levels that are unknown.
#[derive(Clone, Debug)]
pub(super) struct Unknown {
    /// Whether each row has white torque noise of unknown level.
    pub(super) torques: Vec<bool>,
    /// Whether each row has noise of unknown level while its friction reverses.
    pub(super) reversals: Vec<bool>,
    pub(super) disturbances: Disturbances,
    /// Whether each sensor has noise beyond the noise that its samples show.
    pub(super) sensors: Vec<bool>,
}

/// The unknown levels and their bounds.
#[derive(Clone, Debug)]
pub(super) struct UnknownLevels {
    pub(super) all: Vec<Level>,
    pub(super) bounds: Vec<(f64, f64)>,
    /// `R T` of capped disturbances, s.
    cap: Option<f64>,
}

impl UnknownLevels {
    pub(super) fn new(measurements: &Measurements, unknown: &Unknown) -> Self {
        let scales = &measurements.torque_scale;
        let indices = |noisy: &[bool]| -> Vec<usize> {
            (0..noisy.len()).filter(|&index| noisy[index]).collect()
        };
        let torques = indices(&unknown.torques).into_iter();
        let reversals = indices(&unknown.reversals).into_iter();
        let sensors = indices(&unknown.sensors).into_iter();
        let (disturbed, corner) = match unknown.disturbances {
            Disturbances::Zero => (0, None),
            // A higher corner would raise the cap, which is not evidence for a high corner.
            Disturbances::Capped(_) => (scales.len(), None),
            Disturbances::Free => (scales.len(), Some(Level::Corner)),
        };
        let all: Vec<Level> = (torques.map(Level::TorqueNoise))
            .chain(reversals.map(Level::ReversalNoise))
            .chain((0..disturbed).map(Level::Disturbance))
            .chain(corner)
            .chain(sensors.map(Level::SensorNoise))
            .collect();
        let of_torque =
            |row: usize, most: f64| (MIN_TORQUE_LEVEL * scales[row], most * scales[row]);
        let (most_noise, most_disturbance) = match unknown.disturbances {
            Disturbances::Free => (MAX_TORQUE_NOISE, MAX_DISTURBANCE),
            // The white noise also covers effects that the model lacks, and the cap limits the
            // disturbances.
            Disturbances::Capped(_) | Disturbances::Zero => {
                (MAX_WITH_MODEL_ERROR, MAX_WITH_MODEL_ERROR)
            }
        };
        let bounds = all.iter().map(|level| match *level {
            Level::TorqueNoise(row) => of_torque(row, most_noise),
            Level::ReversalNoise(row) => of_torque(row, MAX_WITH_MODEL_ERROR),
            Level::Disturbance(row) => of_torque(row, most_disturbance),
            Level::SensorNoise(sensor) => {
                let scale = measurements.sensors[sensor].scale;
                (MIN_SENSOR_NOISE * scale, MAX_SENSOR_NOISE * scale)
            }
            Level::Corner => CORNER_BOUNDS_HZ,
        });
        let period = measurements.segments.first().map_or(0.0, |s| s.period);
        Self {
            bounds: bounds.collect(),
            all,
            cap: match unknown.disturbances {
                Disturbances::Capped(ratio) => Some(ratio * period),
                Disturbances::Free | Disturbances::Zero => None,
            },
        }
    }

    /// Returns the logarithms of the unknown levels.
    pub(super) fn logarithms(&self, levels: &Levels) -> Vec<f64> {
        let value = |level: &Level| match *level {
            Level::TorqueNoise(row) => levels.torque_noise[row],
            Level::ReversalNoise(row) => levels.reversal_noise[row],
            Level::Disturbance(row) => levels.disturbance[row],
            Level::SensorNoise(sensor) => levels.sensor_noise[sensor],
            Level::Corner => levels.corner,
        };
        self.all.iter().map(|level| value(level).ln()).collect()
    }

    /// Returns the levels with other logarithms of the unknown ones, limited to their bounds and to
    /// the cap of the disturbances.
    pub(super) fn levels(&self, known: &Levels, logarithms: &[f64]) -> Levels {
        let mut levels = known.clone();
        for ((level, log), (low, high)) in self.all.iter().zip(logarithms).zip(&self.bounds) {
            let value = log.exp().clamp(*low, *high);
            match *level {
                Level::TorqueNoise(row) => levels.torque_noise[row] = value,
                Level::ReversalNoise(row) => levels.reversal_noise[row] = value,
                Level::Disturbance(row) => levels.disturbance[row] = value,
                Level::SensorNoise(sensor) => levels.sensor_noise[sensor] = value,
                Level::Corner => levels.corner = value,
            }
        }
        for row in 0..levels.disturbance.len() {
            if let Some(most) = self.cap(&levels, row) {
                levels.disturbance[row] = levels.disturbance[row].min(most);
            }
        }
        levels
    }

    /// Returns the maximum disturbance of a row, `σ_w √(R T π f_d)`; `None` without a cap.
    pub(super) fn cap(&self, levels: &Levels, row: usize) -> Option<f64> {
        let factor = (self.cap? * std::f64::consts::PI * levels.corner).sqrt();
        Some(factor * levels.torque_noise[row])
    }

    /// Returns the index of a level; `None` if it is known.
    pub(super) fn index(&self, level: Level) -> Option<usize> {
        self.all.iter().position(|other| *other == level)
    }

    /// Returns whether the disturbance of a row is at its upper bound.
    pub(super) fn disturbance_at_bound(&self, levels: &Levels, row: usize) -> bool {
        self.index(Level::Disturbance(row)).is_some_and(|at| {
            levels.disturbance[row] > (1.0 - NEGLIGIBLE_SHARE) * self.bounds[at].1
        })
    }
}
