//! The time update: the dynamics move the state over a period.

use super::state::Filter;
use crate::estimate::estimators::prediction_error::covariance::propagate;
use crate::estimate::estimators::prediction_error::measurements::Segment;
use crate::estimate::estimators::prediction_error::vector::scale;

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
        self.differentiate_torques(segment, sample);
        let (moving, disturbance) = self.x.split_at_mut(2 * rows);
        self.velocities.copy_from_slice(&moving[rows..]);
        segment.write_torque(sample, disturbance, &mut self.torque);
        self.dynamics.set_known(segment.known(sample));
        self.dynamics.set_ramp(segment.ramp(sample));
        let steps = self.dynamics.steps(moving, &self.torque, period);
        let tangent = &mut self.tangent;
        (self.dynamics).advance_tangent(moving, &self.torque, period, steps, tangent);
        (self.friction).write(&self.velocities, &moving[rows..], &mut self.reversals);
        scale(disturbance, decay.factor);
        let disturbances = 2 * rows * tangent.columns;
        scale(&mut tangent.sensitivity[disturbances..], decay.factor);
        propagate(
            &mut self.covariance,
            &tangent.transition,
            self.levels,
            &self.reversals,
            decay,
            &mut self.propagation,
        );
        steps.count
    }

    /// Writes the derivatives of the logged torques by z.
    fn differentiate_torques(&mut self, segment: &Segment, sample: usize) {
        let (columns, rows) = (self.tangent.columns, self.dynamics.rows());
        self.tangent.torque.fill(0.0);
        for (row, sensitivity) in (self.tangent.torque.chunks_mut(columns.max(1))).enumerate() {
            let moving = &self.x[..2 * rows];
            self.unknowns
                .torque(sensitivity, (segment, sample), row, moving);
        }
    }
}
