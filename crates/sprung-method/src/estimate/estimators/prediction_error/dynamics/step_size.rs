//! Number of integration steps that a period needs.

use sprung_core::drives::{Drive, excess_of};

use super::motion::Dynamics;

/// Limits of one integration step: step length times the fastest friction rate, and phase of the fastest spring, rad.
/// Runge-Kutta of order 4 is stable up to 2.7. At 0.7 its error is 1e-3 of an oscillation. Twice the value moves an
/// estimate by 0.07 standard errors, half the value has no effect.
const MAX_DAMPING_PER_STEP: f64 = 1.2;

/// Phase of the fastest oscillation in a step, rad: Runge-Kutta of order 4 has a relative error of 1e-3 at 0.7.
const MAX_PHASE_PER_STEP: f64 = 0.7;

/// Maximum number of integration steps in a period.
const MAX_STEPS: usize = 64;

/// Integration steps of a period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::estimate::estimators::prediction_error) struct Steps {
    pub(in crate::estimate::estimators::prediction_error) count: usize,
    /// Whether friction changes so little during the period that one linearisation holds for all
    /// steps.
    pub(in crate::estimate::estimators::prediction_error) is_smooth: bool,
}

impl Dynamics {
    /// Returns the integration steps that a period needs for the friction and the springs at a
    /// state.
    ///
    /// - `x`: the state, \[2 rows\]; `torque`: \[rows\].
    pub(in crate::estimate::estimators::prediction_error) fn steps(
        &mut self,
        x: &[f64],
        torque: &[f64],
        period: f64,
    ) -> Steps {
        self.accelerate_and_invert(x, torque);
        let robot = self.model.robot();
        let rows = self.rows;
        // Friction is steepest at the slowest velocity of the period.
        let slowest = |row: usize| {
            let (from, change) = (x[rows + row], self.rate[row] * period);
            // The margin of 1.5 covers a period that nearly reaches the reversal.
            let (low, high) = (from.min(from + 1.5 * change), from.max(from + 1.5 * change));
            if low <= 0.0 && high >= 0.0 {
                0.0
            } else {
                low.abs().min(high.abs())
            }
        };
        let mut pull = vec![0.0; rows];
        let mut spring = vec![0.0; rows];
        for term in robot.terms {
            let (joint, motor) = (term.joint, self.motors[term.joint]);
            let drive = Drive {
                deflection: x[motor] - x[joint],
                deflection_rate: x[rows + motor] - x[rows + joint],
                link_velocity: slowest(joint),
                motor_velocity: slowest(motor),
                excess: excess_of(&self.known.excess, joint),
                // Its elements are constant within a period.
                elements: Some([0.0; _]),
            };
            let slopes = term.slopes(&drive, &robot.shapes[joint]);
            let mass = self.inverse[term.row * rows + term.row];
            let value = self.theta[term.column].abs() * mass;
            spring[term.row] += value * slopes.deflection.abs();
            for slope in [
                slopes.deflection_rate,
                slopes.link_velocity,
                slopes.motor_velocity,
            ] {
                pull[term.row] += value * slope.abs();
            }
        }
        let most = |all: &[f64]| all.iter().fold(0.0_f64, |m, x| m.max(*x));
        let by_friction = most(&pull) * period / MAX_DAMPING_PER_STEP;
        let needed = by_friction.max(most(&spring).sqrt() * period / MAX_PHASE_PER_STEP);
        let count = if needed.is_finite() {
            (needed.ceil() as usize).clamp(1, MAX_STEPS)
        } else {
            1
        };
        Steps {
            count,
            is_smooth: by_friction <= 1.0,
        }
    }
}
