//! Backward pass: derivatives of the loss by state and covariance.

use sprung_core::linear::dot;

use super::forward::Forward;
use super::level_gradient::LevelGradient;
use super::linear_run::{LinearRun, Period};
use crate::estimate::estimators::prediction_error::covariance::{
    AdjointMemory, adjoint_covariance, adjoint_product, adjoint_state,
};
use crate::estimate::estimators::prediction_error::matrix::add_rows;
use crate::estimate::estimators::prediction_error::measurements::Measurement;
use crate::estimate::estimators::prediction_error::vector::widen;

/// Results of the backward pass.
#[derive(Default)]
pub(super) struct Backward {
    /// r at the end of the period after each sample, \[samples × states\].
    pub(super) state_adjoint: Vec<f64>,
    /// u of each measurement.
    pub(super) smoothing_error: Vec<f64>,
    /// Derivative of the disturbances' part of r by the logarithm of the corner, at the end of the
    /// period after each sample, \[samples × rows\].
    pub(super) corner_adjoint: Vec<f64>,
    /// Smoothed disturbances, given all measurements, \[samples × rows\].
    pub(super) smoothed: Vec<f64>,
    /// r and its derivative by the logarithm of the corner at the start of the segment.
    pub(super) start: (Vec<f64>, Vec<f64>),
}

/// Derivatives of the loss during the backward pass.
struct Adjoint {
    /// D, derivative by the covariance, \[states × states\], symmetric.
    covariance: Vec<f64>,
    /// r, minus the derivative by the state, \[states\].
    state: Vec<f64>,
    /// Derivative of the disturbances' part of r by the logarithm of the corner, \[rows\].
    corner: Vec<f64>,
    product: Vec<f64>,
    memory: Vec<f64>,
    gains: Vec<f64>,
    of_covariance: AdjointMemory,
}

impl Adjoint {
    fn new(rows: usize, states: usize) -> Self {
        Self {
            covariance: vec![0.0; states * states],
            state: vec![0.0; states],
            corner: vec![0.0; rows],
            product: vec![0.0; states * states],
            memory: vec![0.0; states],
            gains: Vec::with_capacity(states),
            of_covariance: AdjointMemory::new(rows),
        }
    }
}

/// Propagates the derivatives of the loss by state and covariance backward, and adds up those by
/// the levels.
///
/// ```text
/// over a period        r ← Fᵀ r        D ← Fᵀ D F
/// over a measurement   u = e/S − Kᵀ r        r ← r + Hᵀ u
///                      D ← (1 − K H)ᵀ D (1 − K H) + terms of e, S and r
/// ```
///
/// A measurement of the burn-in has no part in the loss, so u has no e/S.
pub(super) fn backward(
    linear: &LinearRun<'_>,
    forward: &Forward,
    gradient: &mut LevelGradient,
) -> Backward {
    let (rows, states) = (linear.rows, linear.states);
    let segment = linear.segment;
    let mut measurement = forward.variance.len();
    let mut backward = Backward {
        state_adjoint: vec![0.0; linear.samples * states],
        smoothing_error: vec![0.0; measurement],
        corner_adjoint: vec![0.0; linear.samples * rows],
        smoothed: forward.disturbances.clone(),
        start: Default::default(),
    };
    let mut adjoint = Adjoint::new(rows, states);
    let (mut covariance, mut transition) = (Vec::new(), Vec::new());
    for k in (0..linear.samples).rev() {
        let range = k * states..(k + 1) * states;
        backward.state_adjoint[range].copy_from_slice(&adjoint.state);
        let range = k * rows..(k + 1) * rows;
        backward.corner_adjoint[range.clone()].copy_from_slice(&adjoint.corner);
        let of_disturbances = &forward.covariance[range.start * states..range.end * states];
        widen(&mut covariance, of_disturbances);
        let period = linear.period(k, &mut transition);
        let before = (covariance.as_slice(), &forward.disturbances[range.clone()]);
        adjoint.back_over_period(linear, &period, before, gradient);
        // The smoothed disturbance is the filtered one plus P r.
        let covariance = covariance.chunks(states);
        for (smoothed, covariance) in backward.smoothed[range].iter_mut().zip(covariance) {
            *smoothed += dot(covariance, &adjoint.state);
        }
        for event in segment.at(k).iter().rev() {
            measurement -= 1;
            let index = (measurement, segment.counts(k));
            let error = adjoint.back_over_measurement(linear, event, index, forward, gradient);
            backward.smoothing_error[measurement] = error;
        }
    }
    gradient.add_start(&adjoint.covariance, &adjoint.state, linear.levels);
    backward.start = (adjoint.state, adjoint.corner);
    backward
}

impl Adjoint {
    /// Propagates the derivatives back over a period.
    ///
    /// - `covariance`, `disturbances`: rows of P for the disturbances, and the disturbances, before
    ///   the period.
    fn back_over_period(
        &mut self,
        linear: &LinearRun<'_>,
        period: &Period<'_>,
        (covariance, disturbances): (&[f64], &[f64]),
        gradient: &mut LevelGradient,
    ) {
        let (rows, levels) = (linear.rows, linear.levels);
        let (transition, decay) = (period.transition, period.decay);
        for (corner, adjoint) in self.corner.iter_mut().zip(&self.state[2 * rows..]) {
            *corner = decay.factor * *corner + decay.by_log_corner * adjoint;
        }
        gradient.add_disturbance(&self.covariance, &self.state, levels, decay, disturbances);
        adjoint_product(
            &self.covariance,
            transition,
            decay.factor,
            &mut self.product,
            &mut self.of_covariance,
        );
        gradient.add_torque_noise(&self.product, &self.covariance, &self.state, levels, period);
        gradient.add_decay(&self.product, covariance, decay);
        adjoint_covariance(
            &self.product,
            transition,
            decay.factor,
            &mut self.covariance,
            &mut self.of_covariance,
        );
        adjoint_state(&mut self.state, transition, decay.factor, &mut self.memory);
    }

    /// Propagates the derivatives back over a measurement. Returns its smoothing error u.
    ///
    /// - `index`: of the measurement; `counts`: whether it is a part of the loss.
    fn back_over_measurement(
        &mut self,
        linear: &LinearRun<'_>,
        measurement: &Measurement,
        (index, counts): (usize, bool),
        forward: &Forward,
        gradient: &mut LevelGradient,
    ) -> f64 {
        let states = linear.states;
        let gains = &mut self.gains;
        widen(gains, &forward.gains[index * states..(index + 1) * states]);
        let (scaled, variance) = (forward.scaled_innovation[index], forward.variance[index]);
        let observation = linear.observation(measurement);
        // D K.
        // D is symmetric.
        let moved = &mut self.memory;
        moved.fill(0.0);
        add_rows(moved, gains, &self.covariance);
        let ahead = dot(&self.state, gains);
        let (direct_by_variance, direct_error) = if counts {
            (0.5 * (1.0 / variance - scaled * scaled), scaled)
        } else {
            (0.0, 0.0)
        };
        let by_variance = direct_by_variance + ahead * scaled + dot(moved, gains);
        let error = direct_error - ahead;
        gradient.add_sensor_noise(measurement.sensor, by_variance, error, linear.levels);
        for (state, factor) in observation.clone() {
            for (i, (moved, adjoint)) in moved.iter().zip(&self.state).enumerate() {
                let both = -factor * (moved + 0.5 * scaled * adjoint);
                self.covariance[state * states + i] += both;
                self.covariance[i * states + state] += both;
            }
            for (other, by) in observation.clone() {
                self.covariance[state * states + other] += by_variance * factor * by;
            }
        }
        for (state, factor) in observation {
            self.state[state] += error * factor;
        }
        error
    }
}
