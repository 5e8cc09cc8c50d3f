//! Accelerations of all coordinates and their derivatives.
//!
//! A coordinate belongs to each row: the link positions first, then the motor
//! positions of flexible joints. With the residual `r = Y(x, a) theta - u` of the
//! equations of motion, the implicit function theorem gives the derivatives of the
//! accelerations `a` from those of `r` at constant `a`: with respect to the state
//! `-M⁻¹ dr/dx`, to the torques `M⁻¹`, to the parameters `-M⁻¹ Y`.

use crate::drives::{State, Term};
use crate::links::{LengthError, Step, Workspace, lengths, torque_columns};
use crate::parameters::{JointParameter, Side};
use crate::planar_2r;
use crate::regressor::{Links, Robot, Values, pair};
use crate::scalar::{Dual, Scalar};

/// Directions that are differentiated at a time.
const DIRECTIONS: usize = 4;

/// A number of the links' dynamics with its derivatives.
pub type Partial = Dual<DIRECTIONS>;

/// Memory for derivatives, which the caller owns.
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
    /// With respect to the positions.
    pub by_position: &'o mut [f64],
    /// With respect to the velocities.
    pub by_velocity: &'o mut [f64],
}

impl Robot<'_> {
    /// Returns the row whose coordinate is the motor position of a joint.
    #[must_use]
    pub fn motor_coordinate(&self, joint: usize) -> usize {
        self.motor_rows[joint].unwrap_or(joint)
    }

    /// Writes the accelerations that torques cause, and the inverse of the mass
    /// matrix.
    ///
    /// - `torque`: on each coordinate, \[rows\], N·m (N): those of the motors in
    ///   the rows that have them, other torques on the links in the others.
    /// - `acceleration`: \[rows\]; NaN if the mass matrix is not positive.
    /// - `inverse`: \[rows × rows\], row by row.
    ///
    /// # Errors
    ///
    /// [`LengthError`] if a slice does not fit the robot.
    ///
    /// # Source
    ///
    /// Eq. (1).
    pub fn motion(
        &self,
        values: &Values<'_>,
        state: &State<'_>,
        torque: &[f64],
        workspace: &mut Workspace<'_>,
        acceleration: &mut [f64],
        inverse: &mut [f64],
    ) -> Result<(), LengthError> {
        self.check(state, workspace)?;
        let (n, rows) = (self.joints(), self.rows());
        let given = [
            ("torque", torque.len()),
            ("acceleration", acceleration.len()),
        ];
        lengths(&given, rows)?;
        lengths(&[("inverse", inverse.len())], rows * rows)?;
        let zeros = &mut workspace.numbers[..n];
        zeros.fill(0.0);
        let links = &mut acceleration[..n];
        self.link_torque(values, state.q, state.dq, zeros, workspace.steps, links)?;
        for (i, (sum, own)) in acceleration.iter_mut().zip(torque).enumerate() {
            *sum = if i < n { own - *sum } else { *own };
        }
        let motor_velocity = &mut workspace.numbers[..n];
        self.motor_velocities(state.dphi, motor_velocity);
        for term in self.terms {
            let (_, rest) = term.columns(state, motor_velocity, self.shapes);
            acceleration[term.row] -= values.theta[term.column] * rest;
        }
        self.full_mass_matrix(values, state.q, workspace, inverse)?;
        invert_positive(inverse, rows);
        let vector = &mut workspace.numbers[..rows];
        vector.copy_from_slice(acceleration);
        for (sum, row) in acceleration.iter_mut().zip(inverse.chunks(rows)) {
            *sum = row.iter().zip(&*vector).map(|(a, b)| a * b).sum();
        }
        Ok(())
    }

    /// Writes the mass matrix of all coordinates, \[rows × rows\], row by row.
    fn full_mass_matrix(
        &self,
        values: &Values<'_>,
        q: &[f64],
        workspace: &mut Workspace<'_>,
        matrix: &mut [f64],
    ) -> Result<(), LengthError> {
        let (n, rows) = (self.joints(), self.rows());
        self.mass_matrix(values, q, workspace, &mut matrix[..n * n])?;
        if rows > n {
            // From n to more numbers in a row, the last row first.
            for i in (0..n).rev() {
                matrix.copy_within(i * n..(i + 1) * n, i * rows);
                matrix[i * rows + n..(i + 1) * rows].fill(0.0);
            }
            matrix[n * rows..].fill(0.0);
        }
        for term in self.terms {
            if term.what == JointParameter::RotorInertia {
                for k in 0..n {
                    let ratio = self.ratio(term.joint, k);
                    if ratio != 0.0 {
                        let at = term.row * rows + self.motor_coordinate(k);
                        matrix[at] += term.gain * ratio * values.theta[term.column];
                    }
                }
            }
        }
        Ok(())
    }

    /// Writes the derivatives of the accelerations with respect to the state.
    ///
    /// - `acceleration`, `inverse`: as [`Robot::motion`] wrote them.
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
        let motor_velocity = &mut workspace.numbers[..n];
        self.motor_velocities(state.dphi, motor_velocity);
        for term in self.terms {
            self.of_term(term, values.theta[term.column], state, motor_velocity, out);
        }
        for matrix in [&mut *out.by_position, &mut *out.by_velocity] {
            let column = &mut workspace.numbers[..rows];
            for j in 0..rows {
                for (i, entry) in column.iter_mut().enumerate() {
                    *entry = matrix[i * rows + j];
                }
                for (i, row) in inverse.chunks(rows).enumerate() {
                    let sum: f64 = row.iter().zip(&*column).map(|(a, b)| a * b).sum();
                    matrix[i * rows + j] = -sum;
                }
            }
        }
        Ok(())
    }

    /// Writes what the links' torques at constant acceleration change by.
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

    /// Adds what the torque of a drive's term changes by.
    fn of_term(
        &self,
        term: &Term,
        value: f64,
        state: &State<'_>,
        motor_velocity: &[f64],
        out: &mut Derivatives<'_>,
    ) {
        let rows = self.rows();
        let (row, joint) = (term.row * rows, term.joint);
        let motor = self.motor_coordinate(joint);
        let torque = term.gain * value;
        let shape = &self.shapes[joint];
        let across = |matrix: &mut [f64], slope: f64| {
            matrix[row + motor] += torque * slope;
            matrix[row + joint] -= torque * slope;
        };
        match term.what {
            JointParameter::RotorInertia | JointParameter::Preload => {}
            JointParameter::Stiffness => across(out.by_position, 1.0),
            JointParameter::CubicStiffness => {
                let deflection = state.phi[joint] - state.q[joint];
                across(out.by_position, 3.0 * deflection * deflection);
            }
            JointParameter::Damping => across(out.by_velocity, 1.0),
            JointParameter::Friction(Side::Link, law) => {
                let (_, slope) = law.column_and_slope(state.dq[joint], shape);
                out.by_velocity[row + joint] += torque * slope;
            }
            JointParameter::Friction(Side::Motor, law) => {
                let (_, slope) = law.column_and_slope(motor_velocity[joint], shape);
                for k in 0..self.joints() {
                    let ratio = self.ratio(joint, k);
                    if ratio != 0.0 {
                        out.by_velocity[row + self.motor_coordinate(k)] += torque * slope * ratio;
                    }
                }
            }
        }
    }

    /// Writes the entries of `Y(x, a)`, whose product with the parameters is the
    /// torque on each coordinate.
    ///
    /// - `acceleration`: \[rows\].
    /// - `entries`: as [`Robot::regressor`] orders them.
    ///
    /// # Errors
    ///
    /// [`LengthError`] if a slice does not fit the robot.
    pub fn torque_entries(
        &self,
        state: &State<'_>,
        acceleration: &[f64],
        workspace: &mut Workspace<'_>,
        entries: &mut [f64],
    ) -> Result<(), LengthError> {
        self.check(state, workspace)?;
        let n = self.joints();
        lengths(&[("acceleration", acceleration.len())], self.rows())?;
        lengths(&[("entries", entries.len())], self.entries)?;
        let links = &acceleration[..n];
        match self.links {
            Links::Planar2R { entries: first } => {
                let columns =
                    planar_2r::torque_columns(&pair(state.q), &pair(state.dq), &pair(links));
                for (row, first) in first.into_iter().enumerate() {
                    let own = &columns[row][row..];
                    entries[first..first + own.len()].copy_from_slice(own);
                }
            }
            Links::Tree {
                chain,
                selected,
                first,
                entries: places,
            } => {
                let motion = [state.q, state.dq, links];
                torque_columns(&chain, motion, workspace, |i, j, columns| {
                    let chosen = &selected[first[j]..first[j + 1]];
                    let own = entries[places[i * n + j]..].iter_mut();
                    for (entry, &k) in own.zip(chosen) {
                        *entry = columns[k];
                    }
                })?;
            }
        }
        let motor_velocity = &mut workspace.numbers[..n];
        self.motor_velocities(state.dphi, motor_velocity);
        for term in self.terms {
            entries[term.entry] = if term.what == JointParameter::RotorInertia {
                let of =
                    |k: usize| self.ratio(term.joint, k) * acceleration[self.motor_coordinate(k)];
                term.gain * (0..n).map(of).sum::<f64>()
            } else {
                term.columns(state, motor_velocity, self.shapes).1
            };
        }
        Ok(())
    }
}

/// Inverts a symmetric positive definite matrix in place; NaN if it is not one.
fn invert_positive(a: &mut [f64], n: usize) {
    for k in 0..n {
        let pivot = a[k * n + k];
        let inverse = if pivot > 0.0 { 1.0 / pivot } else { f64::NAN };
        for i in (0..n).filter(|i| *i != k) {
            let factor = a[i * n + k] * inverse;
            if factor != 0.0 {
                for j in (0..n).filter(|j| *j != k) {
                    a[i * n + j] -= factor * a[k * n + j];
                }
                a[i * n + k] = -factor;
            }
        }
        for j in (0..n).filter(|j| *j != k) {
            a[k * n + j] *= inverse;
        }
        a[k * n + k] = inverse;
    }
}

#[cfg(test)]
mod tests {
    use super::invert_positive;

    #[test]
    fn inverse_times_matrix_is_one() {
        let a = [4.0, 2.0, -2.0, 2.0, 10.0, 5.0, -2.0, 5.0, 6.0];
        let mut inverse = a;
        invert_positive(&mut inverse, 3);
        for i in 0..3 {
            for j in 0..3 {
                let entry: f64 = (0..3).map(|k| a[3 * i + k] * inverse[3 * k + j]).sum();
                assert!((entry - f64::from(u8::from(i == j))).abs() < 1e-14);
            }
        }
        let mut indefinite = [1.0, 2.0, 2.0, 1.0];
        invert_positive(&mut indefinite, 2);
        assert!(indefinite.iter().any(|x| x.is_nan()));
    }
}
