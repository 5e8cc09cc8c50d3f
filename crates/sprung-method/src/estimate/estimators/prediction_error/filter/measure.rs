//! The measurement update: an innovation corrects the state by its gain.

use super::state::{Filter, Taken};
use crate::estimate::estimators::prediction_error::matrix::add_product;
use crate::estimate::estimators::prediction_error::measurements::{Measurement, Sensor, observe};
use crate::estimate::estimators::prediction_error::state_layout::state_count;
use crate::estimate::estimators::prediction_error::vector::{Short, add};

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
    /// H depends on z if z contains delays. For a torque sensor b contains the rest of the spring's torque, which
    /// depends on x and z, and H is the one of the start. [`Filter::correct`] updates P and ∂x/∂z by all measurements
    /// of a sample. A replay holds the gains as short numbers, so those of the filter are short too.
    pub(super) fn measure(&mut self, sensor: &Sensor, measurement: &Measurement) -> Innovation<'_> {
        let rows = self.dynamics.rows();
        let observation = sensor.observation(measurement, rows);
        let state = (self.x.as_slice(), rows);
        let offset = (self.unknowns).beyond_observation(self.z, (sensor, measurement), state);
        let value = innovation(&self.x, measurement, offset, observation.clone());
        self.differentiate(sensor, measurement);
        let noise = self.levels.measurement_variance(measurement);
        let correction = &mut self.correction;
        let (cross, variance) = correction.measure(&self.covariance, observation, noise);
        let (states, count) = (state_count(rows), self.unknowns.columns());
        let (gains, gradients) = (&mut self.taken.gains, &self.taken.gradients);
        let start = gains.len();
        let short = |cross: &f64| f64::from(Short::new(cross / variance));
        gains.extend(cross.iter().map(short));
        add(&mut self.x, value, &gains[start..]);
        Innovation {
            value,
            deviation: variance.sqrt(),
            gradient: &gradients[gradients.len() - count..],
            gains: &gains[gains.len() - states..],
        }
    }

    /// Updates P and ∂x/∂z by the measurements since the last call.
    pub(super) fn correct(&mut self) {
        self.correction.apply(&mut self.covariance);
        let count = self.unknowns.columns();
        let Taken { gains, gradients } = &mut self.taken;
        add_product(gains, gradients, count, &mut self.tangent.sensitivity);
        gains.clear();
        gradients.clear();
    }

    /// Appends ∂e/∂z of a measurement. The measurements before it have moved ∂x/∂z by their gains.
    fn differentiate(&mut self, sensor: &Sensor, measurement: &Measurement) {
        let (rows, count) = (self.dynamics.rows(), self.unknowns.columns());
        let observation = sensor.observation(measurement, rows);
        let Taken { gains, gradients } = &mut self.taken;
        let before = gradients.len();
        gradients.resize(before + count, 0.0);
        let (earlier, gradient) = gradients.split_at_mut(before);
        let state = (self.x.as_slice(), rows);
        let measured = (sensor, measurement);
        let more = (self.unknowns).spring_innovation(gradient, self.z, measured, state);
        let observation = observation.chain(more.into_iter().flatten());
        for (state, weight) in observation.clone() {
            let sensitivity = &self.tangent.sensitivity[state * count..(state + 1) * count];
            add(gradient, -weight, sensitivity);
        }
        for (gains, earlier) in gains
            .chunks(state_count(rows))
            .zip(earlier.chunks(count.max(1)))
        {
            add(gradient, -observe(gains, observation.clone()), earlier);
        }
        let (moving, coordinates) = (&self.x[..2 * rows], &sensor.coordinates);
        (self.unknowns).innovation(gradient, measurement.sensor, coordinates, moving);
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
