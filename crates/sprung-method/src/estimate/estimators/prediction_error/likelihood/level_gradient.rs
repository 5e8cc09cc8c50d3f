//! Derivatives of the loss by the levels, summed in the backward pass.

use super::linear_run::Period;
use crate::estimate::estimators::prediction_error::levels::{Decay, Level, Levels};
use crate::estimate::estimators::prediction_error::state_layout::{moving_states, state_count};

/// Derivative by the logarithm of a level.
#[derive(Clone, Copy, Debug, Default)]
struct ByLevel {
    gradient: f64,
    /// Quadratic part by the innovations. The gradient is the expectation of this part minus this
    /// part.
    found: f64,
}

/// Derivatives of the loss by the logarithms of all levels.
pub(super) struct LevelGradient {
    torque_noise: Vec<ByLevel>,
    reversal_noise: Vec<ByLevel>,
    disturbance: Vec<ByLevel>,
    sensor_noise: Vec<ByLevel>,
    corner: f64,
}

impl LevelGradient {
    pub(super) fn new(levels: &Levels) -> Self {
        let zeros = |all: &[f64]| vec![ByLevel::default(); all.len()];
        Self {
            torque_noise: zeros(&levels.torque_noise),
            reversal_noise: zeros(&levels.reversal_noise),
            disturbance: zeros(&levels.disturbance),
            sensor_noise: zeros(&levels.sensor_noise),
            corner: 0.0,
        }
    }

    fn by_level(&self, level: Level) -> ByLevel {
        match level {
            Level::TorqueNoise(row) => self.torque_noise[row],
            Level::ReversalNoise(row) => self.reversal_noise[row],
            Level::Disturbance(row) => self.disturbance[row],
            Level::SensorNoise(sensor) => self.sensor_noise[sensor],
            Level::Corner => ByLevel {
                gradient: self.corner,
                found: 0.0,
            },
        }
    }

    /// Returns the derivative by the logarithm of a level.
    pub(super) fn gradient(&self, level: Level) -> f64 {
        self.by_level(level).gradient
    }

    /// Returns the quadratic part of the derivative by the innovations.
    pub(super) fn found(&self, level: Level) -> f64 {
        self.by_level(level).found
    }

    /// Adds the derivative by the disturbances at the start of a segment.
    ///
    /// - `covariance_adjoint`: D, `state_adjoint`: r, both at the start.
    pub(super) fn add_start(
        &mut self,
        covariance_adjoint: &[f64],
        state_adjoint: &[f64],
        levels: &Levels,
    ) {
        let states = state_adjoint.len();
        for (row, disturbance) in self.disturbance.iter_mut().enumerate() {
            let at = moving_states(states) + row;
            let variance = levels.disturbance[row].powi(2);
            disturbance.gradient += 2.0 * variance * covariance_adjoint[at * (states + 1)];
            disturbance.found += variance * state_adjoint[at] * state_adjoint[at];
        }
    }

    /// Adds the derivatives by the new disturbances of a period.
    ///
    /// - `covariance_adjoint`: D, `state_adjoint`: r, both at the end of the period.
    /// - `disturbances`: d before the period.
    pub(super) fn add_disturbance(
        &mut self,
        covariance_adjoint: &[f64],
        state_adjoint: &[f64],
        levels: &Levels,
        decay: Decay,
        disturbances: &[f64],
    ) {
        let states = state_adjoint.len();
        for (row, disturbance) in self.disturbance.iter_mut().enumerate() {
            let at = moving_states(states) + row;
            let by_variance = covariance_adjoint[at * (states + 1)];
            let variance = levels.added_variance(row, decay);
            disturbance.gradient += 2.0 * variance * by_variance;
            disturbance.found += variance * state_adjoint[at] * state_adjoint[at];
            let less = 2.0 * decay.factor * decay.by_log_corner * levels.disturbance[row].powi(2);
            self.corner -=
                less * by_variance + state_adjoint[at] * decay.by_log_corner * disturbances[row];
        }
    }

    /// Adds the derivatives by the torque noise of a period, at reversals and always.
    ///
    /// - `product`: `Fᵀ D`.
    /// - `covariance_adjoint`: D, `state_adjoint`: r, both at the end of the period.
    pub(super) fn add_torque_noise(
        &mut self,
        product: &[f64],
        covariance_adjoint: &[f64],
        state_adjoint: &[f64],
        levels: &Levels,
        period: &Period<'_>,
    ) {
        let states = state_adjoint.len();
        let moving = moving_states(states);
        let (transition, decay) = (period.transition, period.decay.factor);
        for (row, reversal) in period.reversals.iter().enumerate() {
            let always = levels.torque_noise[row].powi(2);
            let reversing = reversal * levels.reversal_noise[row].powi(2);
            if always + reversing == 0.0 {
                continue;
            }
            let at = (moving + row) * states;
            let (mut both, mut alone) = (0.0, 0.0);
            for i in 0..moving {
                let a = transition[i * states + moving + row];
                both += a * (product[at + i] - decay * covariance_adjoint[at + i]);
                alone += a * state_adjoint[i];
            }
            let noises = [&mut self.torque_noise, &mut self.reversal_noise];
            for (noise, variance) in noises.into_iter().zip([always, reversing]) {
                noise[row].gradient += 2.0 * variance * both;
                noise[row].found += variance * alone * alone;
            }
        }
    }

    /// Adds the derivative by the decay of the disturbances in a period.
    ///
    /// - `product`: `Fᵀ D`; `covariance`: rows of P for the disturbances before the period.
    pub(super) fn add_decay(&mut self, product: &[f64], covariance: &[f64], decay: Decay) {
        let rows = self.disturbance.len();
        let states = state_count(rows);
        for (row, covariance_row) in covariance.chunks(states).enumerate() {
            let column = product[2 * rows + row..].iter().step_by(states);
            let sum: f64 = covariance_row.iter().zip(column).map(|(a, b)| a * b).sum();
            self.corner += 2.0 * decay.by_log_corner * sum;
        }
    }

    /// Adds the derivative by the noise of a sensor.
    ///
    /// - `by_variance`: derivative of the loss by R; `error`: u.
    pub(super) fn add_sensor_noise(
        &mut self,
        sensor: usize,
        by_variance: f64,
        error: f64,
        levels: &Levels,
    ) {
        let variance = levels.sensor_noise[sensor].powi(2);
        let noise = &mut self.sensor_noise[sensor];
        noise.gradient += 2.0 * variance * by_variance;
        noise.found += variance * error * error;
    }
}
