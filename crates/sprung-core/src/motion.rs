//! The equations of motion: the mass matrix of all coordinates, the torques that are left to
//! accelerate them, and the accelerations.
//!
//! The torques of drives are the columns of the regressor times theta. The torques of links are
//! sums of the same bilinear form, from [`dynamics`](crate::dynamics).

use crate::drives::{Drive, State};
use crate::dynamics::{bias_and_masses, inverse_dynamics, mass_matrix};
use crate::linear::{factor, invert, solve};
use crate::links::{LengthError, Parts, Step, Workspace, lengths};
use crate::parameters::JointParameter;
use crate::robot::{Robot, Values};
use crate::scalar::Scalar;

impl Robot<'_> {
    /// Computes the joint torques of a motion of the links, without drives, \[n\], N·m (N).
    ///
    /// With numbers of type [`Jet`](crate::scalar::Jet), the result also contains the time
    /// derivatives of the torques.
    ///
    /// # Errors
    ///
    /// [`LengthError`] if a slice does not fit the robot.
    pub fn link_torque<S: Scalar>(
        &self,
        values: &Values<'_>,
        q: &[S],
        dq: &[S],
        ddq: &[S],
        steps: &mut [Step<S>],
        tau: &mut [S],
    ) -> Result<(), LengthError> {
        inverse_dynamics(&self.links.chain, values.bodies, q, dq, ddq, steps, tau)
    }

    /// Computes the mass matrix of all coordinates, \[rows × rows\], row by row.
    ///
    /// # Errors
    ///
    /// [`LengthError`] if a slice does not fit the robot.
    pub fn mass_matrix(
        &self,
        values: &Values<'_>,
        q: &[f64],
        workspace: &mut Workspace<'_>,
        matrix: &mut [f64],
    ) -> Result<(), LengthError> {
        let (n, rows) = (self.joints(), self.rows());
        lengths(&[("matrix", matrix.len())], rows * rows)?;
        mass_matrix(
            &self.links.chain,
            values.bodies,
            q,
            workspace.steps,
            &mut matrix[..n * n],
        )?;
        if rows > n {
            // Widens the rows from n to `rows` numbers, the last row first.
            for i in (0..n).rev() {
                matrix.copy_within(i * n..(i + 1) * n, i * rows);
                matrix[i * rows + n..(i + 1) * rows].fill(0.0);
            }
            matrix[n * rows..].fill(0.0);
        }
        self.add_rotors(values.theta, matrix);
        Ok(())
    }

    /// Adds the rotor inertias to a mass matrix of all coordinates.
    fn add_rotors(&self, theta: &[f64], matrix: &mut [f64]) {
        let rows = self.rows();
        for term in self.terms {
            if term.what != JointParameter::RotorInertia {
                continue;
            }
            for k in 0..self.joints() {
                let ratio = self.ratio(term.joint, k);
                if ratio != 0.0 {
                    let at = term.row * rows + self.motor_coordinate(k);
                    matrix[at] += theta[term.column] * term.momentum(ratio);
                }
            }
        }
    }

    /// Computes the torque that each coordinate needs for a motion, \[rows\], N·m (N): the torques of
    /// [`Robot::torque_entries`] times theta, with a tenth of the operations.
    ///
    /// - `acceleration`: acceleration of each coordinate, \[rows\], rad/s² (m/s²).
    ///
    /// # Errors
    ///
    /// [`LengthError`] if a slice does not fit the robot.
    pub fn required_torques(
        &self,
        values: &Values<'_>,
        state: &State<'_>,
        acceleration: &[f64],
        workspace: &mut Workspace<'_>,
        torque: &mut [f64],
    ) -> Result<(), LengthError> {
        self.check(state, workspace)?;
        let (n, rows) = (self.joints(), self.rows());
        let given = [
            ("acceleration", acceleration.len()),
            ("torque", torque.len()),
        ];
        lengths(&given, rows)?;
        let (links, motors) = torque.split_at_mut(n);
        let motion = [state.q, state.dq, &acceleration[..n]];
        self.link_torque(
            values,
            motion[0],
            motion[1],
            motion[2],
            workspace.steps,
            links,
        )?;
        motors.fill(0.0);
        let parts = workspace.parts();
        let (velocity, after, before) = (parts.motors, &mut parts.vector[..n], parts.more);
        self.motor_rates(state.dphi, velocity);
        for (joint, after) in after.iter_mut().enumerate() {
            *after = acceleration[self.motor_coordinate(joint)];
        }
        self.motor_rates(after, before);
        for term in self.terms.iter().filter(|term| term.row < rows) {
            let joint = term.joint;
            let drive = Drive::new(state, velocity[joint], joint);
            let entry = term.momentum(before[joint]) + term.rest(&drive, &self.shapes[joint]);
            torque[term.row] += values.theta[term.column] * entry;
        }
        Ok(())
    }

    /// Computes the accelerations that torques cause.
    ///
    /// - `torque`: torque on each coordinate, \[rows\], N·m (N), from
    ///   [`Robot::coordinate_torques`].
    /// - `acceleration`: acceleration of each coordinate, \[rows\], rad/s² (m/s²); NaN if the mass
    ///   matrix is not positive definite.
    ///
    /// # Errors
    ///
    /// [`LengthError`] if a slice does not fit the robot.
    ///
    /// # Source
    ///
    /// Eq. (1).
    pub fn acceleration(
        &self,
        values: &Values<'_>,
        state: &State<'_>,
        torque: &[f64],
        workspace: &mut Workspace<'_>,
        acceleration: &mut [f64],
    ) -> Result<(), LengthError> {
        self.assemble(values, state, torque, workspace, acceleration)?;
        let rows = self.rows();
        let masses = &mut workspace.parts().masses[..rows * rows];
        if factor(masses, rows) {
            solve(masses, acceleration);
        } else {
            acceleration.fill(f64::NAN);
        }
        Ok(())
    }

    /// Computes the accelerations like [`Robot::acceleration`], and the inverse of the mass matrix.
    ///
    /// - `inverse`: \[rows × rows\], row by row; NaN if the mass matrix is not positive definite.
    ///
    /// # Errors
    ///
    /// [`LengthError`] if a slice does not fit the robot.
    pub fn motion(
        &self,
        values: &Values<'_>,
        state: &State<'_>,
        torque: &[f64],
        workspace: &mut Workspace<'_>,
        acceleration: &mut [f64],
        inverse: &mut [f64],
    ) -> Result<(), LengthError> {
        let rows = self.rows();
        lengths(&[("inverse", inverse.len())], rows * rows)?;
        self.acceleration(values, state, torque, workspace, acceleration)?;
        if acceleration.iter().any(|a| a.is_nan()) {
            inverse.fill(f64::NAN);
            return Ok(());
        }
        let factors = &workspace.parts().masses[..rows * rows];
        invert(factors, rows, inverse);
        Ok(())
    }

    /// Writes the mass matrix M into the workspace, and M times the accelerations into `left`: the
    /// torques minus those of the equations at zero accelerations.
    fn assemble(
        &self,
        values: &Values<'_>,
        state: &State<'_>,
        torque: &[f64],
        workspace: &mut Workspace<'_>,
        left: &mut [f64],
    ) -> Result<(), LengthError> {
        self.check(state, workspace)?;
        let (n, rows) = (self.joints(), self.rows());
        lengths(&[("bodies", values.bodies.len())], n)?;
        lengths(
            &[("torque", torque.len()), ("acceleration", left.len())],
            rows,
        )?;
        let numbers = core::mem::take(&mut workspace.numbers);
        let parts = Parts::new(numbers, n);
        let masses = &mut parts.masses[..rows * rows];
        masses.fill(0.0);
        parts.more.fill(0.0);
        let motion = [state.q, state.dq, &*parts.more];
        bias_and_masses(
            &self.links.chain,
            values.bodies,
            motion,
            workspace,
            &mut left[..n],
            rows,
            masses,
        );
        self.add_rotors(values.theta, masses);
        for (i, (left, torque)) in left.iter_mut().zip(torque).enumerate() {
            *left = if i < n { torque - *left } else { *torque };
        }
        self.motor_rates(state.dphi, parts.motors);
        for term in self.terms {
            let drive = Drive::new(state, parts.motors[term.joint], term.joint);
            let rest = term.rest(&drive, &self.shapes[term.joint]);
            left[term.row] -= values.theta[term.column] * rest;
        }
        workspace.numbers = numbers;
        Ok(())
    }
}
