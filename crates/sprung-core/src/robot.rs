//! A robot: rows, links and drives.
//!
//! Rows 0 to n-1 belong to the joints: the link row of a flexible joint, whose right-hand side is
//! zero, or the only row of a rigid joint. The motor rows of flexible joints follow. Each row has
//! one coordinate: the link position, or in a motor row the motor position.

use crate::chain::Chain;
use crate::drives::{Drive, State, Term};
use crate::friction::Shape;
use crate::links::{LengthError, Workspace, check, lengths};
use crate::spatial::BODY;

/// The links of a robot, and their inertial parameters in theta.
#[derive(Clone, Copy, Debug)]
pub struct Links<'a> {
    /// The tree of joints.
    pub chain: Chain<'a>,
    /// For each inertial parameter of theta, link by link: its index among the [`BODY`] parameters
    /// of the link.
    pub selected: &'a [usize],
    /// Index in theta of the first inertial parameter of each link, and after it the end of the
    /// last link, \[n + 1\].
    pub first: &'a [usize],
    /// Index of the first entry of joint `i` and link `j`, \[n × n\].
    pub entries: &'a [usize],
    /// Parameters of theta that occur in a second body; empty if each parameter belongs to one
    /// body.
    pub shares: &'a [Share],
}

/// An inertial parameter of theta that occurs in two bodies. The regressor adds `factor` times the
/// entry `of` to its entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// Index of the parameter's entry.
    pub entry: usize,
    /// Index of the entry of the other body's parameter in the same row.
    pub of: usize,
    /// Factor of the other entry.
    pub factor: f64,
}

/// A robot as rows and entries of the regressor.
#[derive(Clone, Copy, Debug)]
pub struct Robot<'a> {
    /// The links.
    pub links: Links<'a>,
    /// Terms of the drives.
    pub terms: &'a [Term],
    /// Shapes of the friction laws, \[n\].
    pub shapes: &'a [Shape],
    /// Motor positions per joint position of a coupled transmission, \[n × n\], with ones on the
    /// diagonal and zeros between rigid and flexible joints; `None` if each motor drives only its
    /// own joint.
    pub coupling: Option<&'a [f64]>,
    /// Motor row of each joint, \[n\]; `None` for a rigid joint.
    pub motor_rows: &'a [Option<usize>],
    /// Number of entries of the regressor.
    pub entries: usize,
}

/// External torques on a robot.
#[derive(Clone, Copy, Debug)]
pub struct Torques<'t> {
    /// Torques of the motors, after gear and coupling, \[n\], N·m (N).
    pub motor: &'t [f64],
    /// External torques on the links, \[n\], N·m (N); `None` if there are none.
    pub link: Option<&'t [f64]>,
}

/// Values of a robot's parameters, in the forms that the dynamics need.
#[derive(Clone, Copy, Debug)]
pub struct Values<'a> {
    /// The parameter vector, \[p\].
    pub theta: &'a [f64],
    /// Inertial parameters of the links, \[n\], with the same dynamics as the inertial parameters
    /// in theta.
    pub bodies: &'a [[f64; BODY]],
}

impl Robot<'_> {
    /// Returns the number of joints `n`.
    #[must_use]
    pub fn joints(&self) -> usize {
        self.shapes.len()
    }

    /// Returns the number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.joints() + self.motor_rows.iter().flatten().count()
    }

    /// Returns the joint of a row.
    #[must_use]
    pub fn joint_of(&self, row: usize) -> usize {
        if row < self.joints() {
            row
        } else {
            let mut rows = self.motor_rows.iter();
            rows.position(|other| *other == Some(row)).unwrap_or(0)
        }
    }

    /// Returns the row whose coordinate is the motor position of a joint. Its right-hand side is
    /// the motor torque.
    #[must_use]
    pub fn motor_coordinate(&self, joint: usize) -> usize {
        self.motor_rows[joint].unwrap_or(joint)
    }

    /// Returns the position of a motor per position of a joint in the transmission.
    #[must_use]
    pub fn ratio(&self, motor: usize, joint: usize) -> f64 {
        match self.coupling {
            Some(ratios) => ratios[motor * self.joints() + joint],
            None if motor == joint => 1.0,
            None => 0.0,
        }
    }

    /// Writes the external torque on each coordinate, \[rows\], N·m (N).
    ///
    /// # Errors
    ///
    /// [`LengthError`] if a slice does not fit the robot.
    pub fn coordinate_torques(
        &self,
        torques: &Torques<'_>,
        out: &mut [f64],
    ) -> Result<(), LengthError> {
        let n = self.joints();
        let link = torques.link.unwrap_or_default();
        lengths(&[("motor torques", torques.motor.len())], n)?;
        if torques.link.is_some() {
            lengths(&[("link torques", link.len())], n)?;
        }
        lengths(&[("torques", out.len())], self.rows())?;
        out.fill(0.0);
        for (joint, torque) in torques.motor.iter().enumerate() {
            out[self.motor_coordinate(joint)] += torque;
        }
        for (out, torque) in out.iter_mut().zip(link) {
            *out += torque;
        }
        Ok(())
    }

    /// Converts velocities of the motors after the coupling to velocities before the coupling,
    /// \[n\]; accelerations likewise.
    pub(crate) fn motor_rates(&self, after: &[f64], before: &mut [f64]) {
        match self.coupling {
            None => before.copy_from_slice(after),
            Some(ratios) => {
                for (before, row) in before.iter_mut().zip(ratios.chunks(after.len())) {
                    *before = row.iter().zip(after).map(|(ratio, v)| ratio * v).sum();
                }
            }
        }
    }

    /// Returns the motion of one joint, as the columns of its drive need it.
    #[must_use]
    pub fn drive(&self, state: &State<'_>, joint: usize) -> Drive {
        Drive::new(state, self.motor_velocity(state, joint), joint)
    }

    /// Returns the velocity of the motor of a joint before the coupled transmission, rad/s (m/s).
    #[must_use]
    #[inline]
    pub fn motor_velocity(&self, state: &State<'_>, joint: usize) -> f64 {
        match self.coupling {
            None => state.dphi[joint],
            Some(_) => (state.dphi.iter().enumerate())
                .map(|(k, dphi)| self.ratio(joint, k) * dphi)
                .sum(),
        }
    }

    pub(crate) fn check(
        &self,
        state: &State<'_>,
        workspace: &Workspace<'_>,
    ) -> Result<(), LengthError> {
        let given = [
            ("q", state.q.len()),
            ("dq", state.dq.len()),
            ("phi", state.phi.len()),
            ("dphi", state.dphi.len()),
        ];
        check(self.joints(), &given, workspace)
    }
}
