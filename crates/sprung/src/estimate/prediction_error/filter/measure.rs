//! The measurement update: an innovation corrects the state by its gain.

use super::state::Filter;
use crate::estimate::prediction_error::covariance::measurement_update;
use crate::estimate::prediction_error::matrix::add_outer;
use crate::estimate::prediction_error::measurements::{Measurement, Sensor, observe};
use crate::estimate::prediction_error::vector::add;

/// Innovation of a measurement: the measured minus the expected position.
#[derive(Clone, Copy, Debug)]
pub(super) struct Innovation<'f> {
    /// e, rad (m).
    pub(super) value: f64,
    /// Square root of S, rad (m).
    pub(super) deviation: f64,
    /// ∂e/∂z with the gains held, \[unknowns\].
    pub(super) gradient: &'f [f64],
    /// K, \[3 rows\].
    pub(super) gains: &'f [f64],
}

impl Filter<'_> {
    /// Updates the state by a measurement y of a sensor with the offset b.
    ///
    /// ```text
    /// e = y − b − H x        S = H P Hᵀ + R        K = P Hᵀ / S
    /// x ← x + K e            P ← P − K S Kᵀ
    /// ∂e/∂z = −H ∂x/∂z − ∂b/∂z − ∂(H x)/∂z         ∂x/∂z ← ∂x/∂z + K ∂e/∂z
    /// ```
    ///
    /// H depends on z if z contains delays.
    pub(super) fn measure(&mut self, sensor: &Sensor, measurement: &Measurement) -> Innovation<'_> {
        let rows = self.dynamics.rows();
        let observation = sensor.observation(measurement, rows);
        let offset = self.unknowns.offset(self.z, measurement.sensor);
        let value = innovation(&self.x, measurement, offset, observation.clone());
        let variance = measurement_update(
            &mut self.covariance,
            observation.clone(),
            self.levels.measurement_variance(measurement),
            &mut self.cross_covariance,
        );
        for (gain, cross) in self.gains.iter_mut().zip(&self.cross_covariance) {
            *gain = cross / variance;
        }
        self.differentiate(sensor, measurement, observation);
        add(&mut self.x, value, &self.gains);
        Innovation {
            value,
            deviation: variance.sqrt(),
            gradient: &self.innovation_gradient,
            gains: &self.gains,
        }
    }

    /// Writes ∂e/∂z and updates ∂x/∂z.
    fn differentiate(
        &mut self,
        sensor: &Sensor,
        measurement: &Measurement,
        observation: impl Iterator<Item = (usize, f64)>,
    ) {
        let (rows, count) = (self.dynamics.rows(), self.unknowns.columns());
        let gradient = &mut self.innovation_gradient;
        gradient.fill(0.0);
        for (state, weight) in observation {
            let own = &self.tangent.sensitivity[state * count..(state + 1) * count];
            add(gradient, -weight, own);
        }
        let velocity = &self.x[rows..2 * rows];
        let coordinates = &sensor.coordinates;
        (self.unknowns).innovation(gradient, measurement.sensor, coordinates, velocity);
        add_outer(&mut self.tangent.sensitivity, 1.0, &self.gains, gradient);
    }
}

/// Returns `e = y − b − H x`, rad (m).
pub(super) fn innovation(
    x: &[f64],
    measurement: &Measurement,
    offset: f64,
    observation: impl Iterator<Item = (usize, f64)>,
) -> f64 {
    measurement.value - (offset + observe(x, observation))
}
