//! The time update: the dynamics move the state over a period.

use super::state::Filter;
use crate::estimate::prediction_error::covariance::{add_process_noise, propagate};
use crate::estimate::prediction_error::measurements::Segment;
use crate::estimate::prediction_error::vector::scale;

impl Filter<'_> {
    /// Moves the state by a period T. Returns the number of integration steps.
    ///
    /// ```text
    /// [q; v] ← Φ(q, v, τ + d, θ)        d ← a d
    /// P ← F P Fᵀ + Q                    ∂x/∂z ← F ∂x/∂z + ∂Φ/∂z
    /// ```
    ///
    /// Φ is the flow of the equations of motion over T with the torque held. F is its derivative by
    /// the state. Q is the covariance of torque noise and new disturbances.
    pub(super) fn predict(&mut self, segment: &Segment, sample: usize) -> usize {
        let rows = self.dynamics.rows();
        let period = segment.period;
        let decay = self.levels.decay(period);
        self.seed_tangent(segment, sample);
        let (moving, disturbance) = self.x.split_at_mut(2 * rows);
        self.velocities.copy_from_slice(&moving[rows..]);
        segment.write_torque(sample, disturbance, &mut self.torque);
        let steps = self.dynamics.steps(moving, &self.torque, period);
        let tangent = &mut self.tangent;
        (self.dynamics).advance_tangent(moving, &self.torque, period, steps, tangent);
        (self.friction).write(&self.velocities, &moving[rows..], &mut self.reversals);
        scale(disturbance, decay.factor);
        self.read_tangent(decay.factor);
        let (covariance, transition) = (&mut self.covariance, &self.transition);
        propagate(covariance, transition, &mut self.product, decay.factor);
        let reversals = &self.reversals;
        add_process_noise(covariance, transition, self.levels, reversals, decay);
        steps
    }

    /// Writes the derivatives at the beginning of a period, by the state there and by z.
    fn seed_tangent(&mut self, segment: &Segment, sample: usize) {
        let (rows, count) = (self.dynamics.rows(), self.unknowns.columns());
        let (states, width) = (3 * rows, self.tangent.columns);
        let by_z = |state: usize| &self.sensitivity[state * count..(state + 1) * count];
        for (i, row) in self.tangent.state.chunks_mut(width).enumerate() {
            row[..states].fill(0.0);
            row[i] = 1.0;
            row[states..].copy_from_slice(by_z(i));
        }
        for (i, row) in self.tangent.torque.chunks_mut(width).enumerate() {
            row[..states].fill(0.0);
            row[2 * rows + i] = 1.0;
            row[states..].copy_from_slice(by_z(2 * rows + i));
            self.unknowns.torque(&mut row[states..], segment, sample, i);
        }
    }

    /// Reads F and ∂x/∂z at the end of a period.
    fn read_tangent(&mut self, decay: f64) {
        let (rows, count) = (self.dynamics.rows(), self.unknowns.columns());
        let (states, width) = (3 * rows, self.tangent.columns);
        for (i, row) in self.tangent.state.chunks(width).enumerate() {
            self.transition[i * states..(i + 1) * states].copy_from_slice(&row[..states]);
            self.sensitivity[i * count..(i + 1) * count].copy_from_slice(&row[states..]);
        }
        scale(&mut self.sensitivity[2 * rows * count..], decay);
    }
}
