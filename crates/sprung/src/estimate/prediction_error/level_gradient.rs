//! Derivatives of the loss by the levels, gathered on the way back.

use super::filter::Levels;
use super::levels::Level;
use super::likelihood::Part;

/// Returns the variance that a period adds to a disturbance.
pub(super) fn fresh(levels: &Levels, row: usize, left: f64) -> f64 {
    levels.drift[row].powi(2) * (1.0 - left * left)
}

/// Derivatives of the loss by the logarithms of all levels, and of each the part
/// that the innovations found, whose expectation the rest is.
pub(super) struct Gradient {
    white: Vec<(f64, f64)>,
    drift: Vec<(f64, f64)>,
    sensor: Vec<(f64, f64)>,
    corner: f64,
}

impl Gradient {
    pub(super) fn new(levels: &Levels) -> Self {
        let zeros = |all: &[f64]| vec![(0.0, 0.0); all.len()];
        Self {
            white: zeros(&levels.white),
            drift: zeros(&levels.drift),
            sensor: zeros(&levels.sensor),
            corner: 0.0,
        }
    }

    pub(super) fn of(&self, level: Level) -> f64 {
        match level {
            Level::White(row) => self.white[row].0,
            Level::Drift(row) => self.drift[row].0,
            Level::Sensor(sensor) => self.sensor[sensor].0,
            Level::Corner => self.corner,
        }
    }

    pub(super) fn found(&self, level: Level) -> f64 {
        match level {
            Level::White(row) => self.white[row].1,
            Level::Drift(row) => self.drift[row].1,
            Level::Sensor(sensor) => self.sensor[sensor].1,
            Level::Corner => 0.0,
        }
    }

    pub(super) fn by_start(&mut self, by_covariance: &[f64], weight: &[f64], levels: &Levels) {
        let states = weight.len();
        for (row, (own, found)) in self.drift.iter_mut().enumerate() {
            let at = 2 * states / 3 + row;
            let variance = levels.drift[row].powi(2);
            *own += 2.0 * variance * by_covariance[at * (states + 1)];
            *found += variance * weight[at] * weight[at];
        }
    }

    /// - `drift`: disturbances before the period.
    pub(super) fn by_drift(
        &mut self,
        by_covariance: &[f64],
        weight: &[f64],
        levels: &Levels,
        part: &Part<'_>,
        drift: &[f64],
    ) {
        let states = weight.len();
        for (row, (own, found)) in self.drift.iter_mut().enumerate() {
            let at = 2 * states / 3 + row;
            let by_variance = by_covariance[at * (states + 1)];
            let variance = fresh(levels, row, part.left);
            *own += 2.0 * variance * by_variance;
            *found += variance * weight[at] * weight[at];
            let less = 2.0 * part.left * part.slope * levels.drift[row].powi(2);
            self.corner -= less * by_variance + weight[at] * part.slope * drift[row];
        }
    }

    /// - `pulled`: as [`pull_product`] wrote it.
    pub(super) fn by_white(
        &mut self,
        pulled: &[f64],
        by_covariance: &[f64],
        weight: &[f64],
        levels: &Levels,
        transition: &[f64],
        left: f64,
    ) {
        let states = weight.len();
        let moving = 2 * states / 3;
        for (row, (own, found)) in self.white.iter_mut().enumerate() {
            let variance = levels.white[row].powi(2);
            if variance == 0.0 {
                continue;
            }
            let at = (moving + row) * states;
            let (mut both, mut alone) = (0.0, 0.0);
            for i in 0..moving {
                let a = transition[i * states + moving + row];
                both += a * (pulled[at + i] - left * by_covariance[at + i]);
                alone += a * weight[i];
            }
            *own += 2.0 * variance * both;
            *found += variance * alone * alone;
        }
    }

    /// - `covariance`: of the disturbances with all states before the period.
    pub(super) fn by_decay(&mut self, pulled: &[f64], covariance: &[f64], slope: f64) {
        let rows = self.drift.len();
        let states = 3 * rows;
        for (row, own) in covariance.chunks(states).enumerate() {
            let column = pulled[2 * rows + row..].iter().step_by(states);
            let sum: f64 = own.iter().zip(column).map(|(a, b)| a * b).sum();
            self.corner += 2.0 * slope * sum;
        }
    }

    pub(super) fn by_sensor(
        &mut self,
        sensor: usize,
        by_variance: f64,
        error: f64,
        levels: &Levels,
    ) {
        let variance = levels.sensor[sensor].powi(2);
        let (own, found) = &mut self.sensor[sensor];
        *own += 2.0 * variance * by_variance;
        *found += variance * error * error;
    }
}
