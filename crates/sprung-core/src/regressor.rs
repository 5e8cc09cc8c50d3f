//! The regressor `[Y_a | Y_b]` of one sample, and the regressor of the torque.
//!
//! Each row depends on few parameters, so only the entries that can differ from zero are stored,
//! row after row.

use crate::drives::{Drive, State};
use crate::links::{LengthError, Workspace, columns, lengths, torque_columns};
use crate::robot::{Links, Robot};

impl Robot<'_> {
    /// Computes the regressor of one sample, row after row.
    ///
    /// - `momentum`, `rest`: entries of `Y_a` and `Y_b`. With the parameters theta,
    ///   `d/dt(Y_a theta) + Y_b theta = [0; tau]`. The right-hand side of the only row of a rigid
    ///   joint is its torque.
    ///
    /// # Errors
    ///
    /// [`LengthError`] if a slice does not fit the robot.
    ///
    /// # Source
    ///
    /// Eq. (8) and section 3, with the corrections that the columns name.
    pub fn regressor(
        &self,
        state: &State<'_>,
        workspace: &mut Workspace<'_>,
        momentum: &mut [f64],
        rest: &mut [f64],
    ) -> Result<(), LengthError> {
        self.check(state, workspace)?;
        self.check_entries(momentum, rest)?;
        let (links, n) = (&self.links, self.joints());
        columns(
            &links.chain,
            state.q,
            state.dq,
            workspace,
            |i, j, of_momentum, of_rest| {
                let chosen = links.chosen(j);
                let at = links.entries[i * n + j];
                let range = at..at + chosen.len();
                let entries = momentum[range.clone()].iter_mut().zip(&mut rest[range]);
                for ((momentum, rest), &k) in entries.zip(chosen) {
                    *momentum = of_momentum[k];
                    *rest = of_rest[k];
                }
            },
        )?;
        links.share(momentum);
        links.share(rest);
        self.drives(state, workspace, momentum, rest)
    }

    /// Computes the entries of the drives. Motor rows have no other entries. The entries of the
    /// links stay unchanged.
    ///
    /// # Errors
    ///
    /// [`LengthError`] if a slice does not fit the robot.
    pub fn drives(
        &self,
        state: &State<'_>,
        workspace: &mut Workspace<'_>,
        momentum: &mut [f64],
        rest: &mut [f64],
    ) -> Result<(), LengthError> {
        self.check(state, workspace)?;
        self.check_entries(momentum, rest)?;
        let motor_velocity = workspace.parts().motors;
        self.motor_rates(state.dphi, motor_velocity);
        // The terms of a joint follow one another.
        for terms in self.terms.chunk_by(|one, next| one.joint == next.joint) {
            let joint = terms[0].joint;
            let drive = Drive::new(state, motor_velocity[joint], joint);
            for term in terms {
                momentum[term.entry] = term.momentum(motor_velocity[joint]);
                rest[term.entry] = term.rest(&drive, &self.shapes[joint]);
            }
        }
        Ok(())
    }

    /// Computes the entries of `Y(x, a)`. `Y` times the parameters is the torque on each
    /// coordinate.
    ///
    /// - `acceleration`: acceleration of each coordinate, \[rows\], rad/s² (m/s²).
    /// - `entries`: entries of `Y` in the order of [`Robot::regressor`].
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
        let (links, n) = (&self.links, self.joints());
        lengths(&[("acceleration", acceleration.len())], self.rows())?;
        lengths(&[("entries", entries.len())], self.entries)?;
        let motion = [state.q, state.dq, &acceleration[..n]];
        torque_columns(&links.chain, motion, workspace, |i, j, columns| {
            let joint_entries = entries[links.entries[i * n + j]..].iter_mut();
            for (entry, &k) in joint_entries.zip(links.chosen(j)) {
                *entry = columns[k];
            }
        })?;
        links.share(entries);
        let parts = workspace.parts();
        let (motor_velocity, after) = (parts.motors, &mut parts.vector[..n]);
        self.motor_rates(state.dphi, motor_velocity);
        for (joint, after) in after.iter_mut().enumerate() {
            *after = acceleration[self.motor_coordinate(joint)];
        }
        let motor_acceleration = parts.more;
        self.motor_rates(after, motor_acceleration);
        for term in self.terms {
            let joint = term.joint;
            let drive = Drive::new(state, motor_velocity[joint], joint);
            entries[term.entry] =
                term.momentum(motor_acceleration[joint]) + term.rest(&drive, &self.shapes[joint]);
        }
        Ok(())
    }

    fn check_entries(&self, momentum: &[f64], rest: &[f64]) -> Result<(), LengthError> {
        let given = [("momentum", momentum.len()), ("rest", rest.len())];
        lengths(&given, self.entries)
    }
}

impl Links<'_> {
    /// Returns the columns of a link that are in theta.
    pub(crate) fn chosen(&self, link: usize) -> &[usize] {
        &self.selected[self.first[link]..self.first[link + 1]]
    }

    /// Adds the effect of parameters of theta that occur in two bodies.
    fn share(&self, entries: &mut [f64]) {
        for share in self.shares {
            entries[share.entry] += share.factor * entries[share.of];
        }
    }
}
