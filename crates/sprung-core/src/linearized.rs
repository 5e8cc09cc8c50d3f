//! Derivatives of the accelerations of all coordinates.
//!
//! The residual of the equations of motion is `r = Y(x, a) theta - u`, with the state `x`, the
//! accelerations `a` and the torques `u`. The implicit function theorem gives the derivatives of
//! `a`, with those of `r` at constant `a`: `-M⁻¹ dr/dx` by the state, `M⁻¹` by the torques and
//! `-M⁻¹ Y` by the parameters.

use crate::drives::{Drive, State, Term};
use crate::links::{LengthError, Step, Workspace, lengths};
use crate::parameters::JointParameter;
use crate::robot::{Robot, Values};
use crate::scalar::{Dual, Scalar};

/// Number of variables by which one evaluation differentiates.
const DIRECTIONS: usize = 4;

/// A number in the dynamics of the links, with its partial derivatives.
pub type Partial = Dual<DIRECTIONS>;

/// Scratch memory of [`Robot::derivatives`], owned by the caller.
#[derive(Debug)]
pub struct Partials<'w> {
    /// Positions, velocities, accelerations and torques, \[n\] each.
    pub numbers: [&'w mut [Partial]; 4],
    /// One entry per joint.
    pub steps: &'w mut [Step<Partial>],
}

/// Derivatives of the accelerations, \[rows × rows\] each, row by row.
#[derive(Debug)]
pub struct Derivatives<'o> {
    /// By the positions.
    pub by_position: &'o mut [f64],
    /// By the velocities.
    pub by_velocity: &'o mut [f64],
}

impl Robot<'_> {
    /// Computes the derivatives of the accelerations by the state.
    ///
    /// - `acceleration`, `inverse`: results of [`Robot::motion`] at this state.
    ///
    /// # Errors
    ///
    /// [`LengthError`] if a slice does not fit the robot.
    #[expect(clippy::too_many_arguments, reason = "the state, memory and results")]
    pub fn derivatives(
        &self,
        values: &Values<'_>,
        state: &State<'_>,
        acceleration: &[f64],
        inverse: &[f64],
        workspace: &mut Workspace<'_>,
        partials: &mut Partials<'_>,
        out: &mut Derivatives<'_>,
    ) -> Result<(), LengthError> {
        self.check(state, workspace)?;
        let (n, rows) = (self.joints(), self.rows());
        lengths(&[("acceleration", acceleration.len())], rows)?;
        let square = [
            ("inverse", inverse.len()),
            ("by_position", out.by_position.len()),
            ("by_velocity", out.by_velocity.len()),
        ];
        lengths(&square, rows * rows)?;
        out.by_position.fill(0.0);
        out.by_velocity.fill(0.0);
        self.of_links(values, state, &acceleration[..n], partials, out)?;
        let parts = workspace.parts();
        self.motor_rates(state.dphi, parts.motors);
        // The torque of a rotor inertia depends only on the acceleration.
        let resting = |term: &&Term| term.what != JointParameter::RotorInertia;
        for term in self.terms.iter().filter(resting) {
            let drive = Drive::new(state, parts.motors[term.joint], term.joint);
            let slopes = term.slopes(&drive, &self.shapes[term.joint]);
            self.add_slopes(term, values.theta[term.column], &slopes, out);
        }
        let copy = &mut parts.masses[..rows * rows];
        for matrix in [&mut *out.by_position, &mut *out.by_velocity] {
            copy.copy_from_slice(matrix);
            matrix.fill(0.0);
            for (sum, row) in matrix.chunks_mut(rows).zip(inverse.chunks(rows)) {
                for (factor, other) in row.iter().zip(copy.chunks(rows)) {
                    // The entries of the inverse between links and motors are zero.
                    if *factor != 0.0 {
                        for (sum, x) in sum.iter_mut().zip(other) {
                            *sum -= factor * x;
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// Writes the derivatives of the links' torques by the state, at constant accelerations.
    fn of_links(
        &self,
        values: &Values<'_>,
        state: &State<'_>,
        acceleration: &[f64],
        partials: &mut Partials<'_>,
        out: &mut Derivatives<'_>,
    ) -> Result<(), LengthError> {
        let (n, rows) = (self.joints(), self.rows());
        let [q, dq, ddq, tau] = &mut partials.numbers;
        let given = [("numbers", q.len()), ("numbers", dq.len())];
        lengths(&given, n)?;
        for (dual, value) in ddq.iter_mut().zip(acceleration) {
            *dual = Partial::constant(*value);
        }
        for first in (0..2 * n).step_by(DIRECTIONS) {
            let seed = |value: f64, variable: usize| match variable.checked_sub(first) {
                Some(i) if i < DIRECTIONS => Partial::variable(value, i),
                _ => Partial::constant(value),
            };
            for i in 0..n {
                q[i] = seed(state.q[i], i);
                dq[i] = seed(state.dq[i], n + i);
            }
            self.link_torque(values, q, dq, ddq, partials.steps, tau)?;
            for variable in first..(first + DIRECTIONS).min(2 * n) {
                let (matrix, j) = match variable.checked_sub(n) {
                    None => (&mut *out.by_position, variable),
                    Some(j) => (&mut *out.by_velocity, j),
                };
                for (i, torque) in tau.iter().enumerate() {
                    matrix[i * rows + j] = torque.partials[variable - first];
                }
            }
        }
        Ok(())
    }

    /// Adds the derivatives of the torque of one term by the coordinates.
    fn add_slopes(&self, term: &Term, value: f64, slopes: &Drive, out: &mut Derivatives<'_>) {
        let (row, joint) = (term.row * self.rows(), term.joint);
        let motor = self.motor_coordinate(joint);
        for (matrix, slope) in [
            (&mut *out.by_position, slopes.deflection),
            (&mut *out.by_velocity, slopes.deflection_rate),
        ] {
            matrix[row + motor] += value * slope;
            matrix[row + joint] -= value * slope;
        }
        out.by_velocity[row + joint] += value * slopes.link_velocity;
        if slopes.motor_velocity != 0.0 {
            for k in 0..self.joints() {
                let slope = slopes.motor_velocity * self.ratio(joint, k);
                out.by_velocity[row + self.motor_coordinate(k)] += value * slope;
            }
        }
    }
}
