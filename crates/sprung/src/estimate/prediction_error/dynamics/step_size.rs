//! How many steps the integration of a period needs.

use sprung_core::drives::Drive;

use super::motion::Dynamics;

/// What the fastest friction may pull a velocity in one step of the integration,
/// and the phase that the fastest spring may swing through, rad: Runge-Kutta of
/// order 4 is stable to 2.7, and off by 1e-3 of a swing at 0.7.
const MAX_DAMPING_PER_STEP: f64 = 1.2;
const MAX_PHASE_PER_STEP: f64 = 0.7;

/// Steps of the integration in a period, at most.
const MAX_STEPS: usize = 64;

impl Dynamics<'_> {
    /// Returns how many steps the integration of a period needs: friction and
    /// springs say how fast the motion can change.
    ///
    /// - `x`: the state, \[2 rows\]; `torque`: \[rows\].
    pub(in crate::estimate::prediction_error) fn steps(
        &mut self,
        x: &[f64],
        torque: &[f64],
        period: f64,
    ) -> usize {
        self.accelerate_and_invert(x, torque);
        let robot = self.model.robot();
        let rows = self.rows;
        // Friction at the slowest velocity that the period comes by.
        let slowest = |row: usize| {
            let (from, change) = (x[rows + row], self.rate[row] * period);
            // A period that misses the reversal by little may end in it.
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
        let needed = (most(&pull) * period / MAX_DAMPING_PER_STEP)
            .max(most(&spring).sqrt() * period / MAX_PHASE_PER_STEP);
        if needed.is_finite() {
            (needed.ceil() as usize).clamp(1, MAX_STEPS)
        } else {
            1
        }
    }
}
