//! The gradient of a weighted sum of the entries of the regressor by the motion.
//!
//! A search for a motion needs it: the information of an experiment depends on the entries, and the
//! entries on the motion.

use crate::drives::{Drive, State};
use crate::linearized::Partial;
use crate::links::{LengthError, Workspace, lengths, torque_columns};
use crate::robot::Robot;
use crate::scalar::Scalar;

/// Derivatives by positions, velocities and accelerations of links and motors, \[n\] each.
#[derive(Debug)]
pub struct Gradient<'o> {
    /// By those of the links.
    pub link: [&'o mut [f64]; 3],
    /// By those of the motors after gear and coupling.
    pub motor: [&'o mut [f64]; 3],
}

/// Number of variables by which one evaluation differentiates.
const DIRECTIONS: usize = 4;

impl Robot<'_> {
    /// Adds the gradient of the sum of `weights` times the entries of [`Robot::torque_entries`]. The
    /// motor of a rigid joint moves with its link: its derivatives are those by the link.
    ///
    /// - `acceleration`: acceleration of each coordinate, \[rows\], rad/s² (m/s²).
    /// - `weights`: \[entries\]; changed where parameters share bodies.
    /// - `numbers`: positions, velocities and accelerations of the links, \[n\] each; work memory.
    ///
    /// # Errors
    ///
    /// [`LengthError`] if a slice does not fit the robot.
    pub fn pull(
        &self,
        state: &State<'_>,
        acceleration: &[f64],
        weights: &mut [f64],
        workspace: &mut Workspace<'_, Partial>,
        numbers: [&mut [Partial]; 3],
        out: &mut Gradient<'_>,
    ) -> Result<(), LengthError> {
        let n = self.joints();
        lengths(&[("acceleration", acceleration.len())], self.rows())?;
        lengths(&[("weights", weights.len())], self.entries)?;
        for vector in &numbers {
            lengths(&[("numbers", vector.len())], n)?;
        }
        for term in self.terms {
            let weight = weights[term.entry];
            if weight == 0.0 {
                continue;
            }
            let drive = self.drive(state, term.joint);
            let slopes = term.slopes(&drive, &self.shapes[term.joint]);
            self.pull_term(term.joint, &slopes, weight, out);
            let by_acceleration = weight * term.momentum(1.0);
            if by_acceleration != 0.0 {
                for k in 0..n {
                    let ratio = self.ratio(term.joint, k);
                    self.motor_part(k, 2, by_acceleration * ratio, out);
                }
            }
        }
        for share in self.links.shares {
            weights[share.of] += share.factor * weights[share.entry];
        }
        self.pull_links(state, acceleration, weights, workspace, numbers, out)
    }

    fn pull_term(&self, joint: usize, slopes: &Drive, weight: f64, out: &mut Gradient<'_>) {
        for (order, slope) in [slopes.deflection, slopes.deflection_rate]
            .into_iter()
            .enumerate()
        {
            // The motor of a rigid joint has no separate position and no deflection.
            if self.motor_rows[joint].is_some() {
                out.motor[order][joint] += weight * slope;
                out.link[order][joint] -= weight * slope;
            }
        }
        out.link[1][joint] += weight * slopes.link_velocity;
        if slopes.motor_velocity != 0.0 {
            for k in 0..self.joints() {
                let ratio = self.ratio(joint, k);
                self.motor_part(k, 1, weight * slopes.motor_velocity * ratio, out);
            }
        }
    }

    /// Adds a derivative by the motion of a motor.
    fn motor_part(&self, joint: usize, order: usize, by: f64, out: &mut Gradient<'_>) {
        let side = if self.motor_rows[joint].is_some() {
            &mut out.motor
        } else {
            &mut out.link
        };
        side[order][joint] += by;
    }

    fn pull_links(
        &self,
        state: &State<'_>,
        acceleration: &[f64],
        weights: &[f64],
        workspace: &mut Workspace<'_, Partial>,
        mut numbers: [&mut [Partial]; 3],
        out: &mut Gradient<'_>,
    ) -> Result<(), LengthError> {
        let (links, n) = (&self.links, self.joints());
        let variables = 3 * n;
        for first in (0..variables).step_by(DIRECTIONS) {
            let seed = |value: f64, variable: usize| match variable.checked_sub(first) {
                Some(i) if i < DIRECTIONS => Partial::variable(value, i),
                _ => Partial::constant(value),
            };
            let values = [state.q, state.dq, &acceleration[..n]];
            for (order, (numbers, values)) in numbers.iter_mut().zip(values).enumerate() {
                for (i, (number, value)) in numbers.iter_mut().zip(values).enumerate() {
                    *number = seed(*value, order * n + i);
                }
            }
            let mut sum = Partial::ZERO;
            let motion = [&*numbers[0], &*numbers[1], &*numbers[2]];
            torque_columns(&links.chain, motion, workspace, |i, j, columns| {
                let joint_weights = weights[links.entries[i * n + j]..].iter();
                for (weight, &k) in joint_weights.zip(links.chosen(j)) {
                    if *weight != 0.0 {
                        sum = sum + columns[k] * *weight;
                    }
                }
            })?;
            for (i, partial) in sum.partials.into_iter().enumerate() {
                let variable = first + i;
                if variable < variables {
                    out.link[variable / n][variable % n] += partial;
                }
            }
        }
        Ok(())
    }
}
