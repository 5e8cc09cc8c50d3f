//! A robot as its rows, links and drives.
//!
//! Rows 0 to n-1 are those of the joints: link rows of flexible joints, which
//! have no right-hand side, and the only rows of rigid ones. The motor rows of
//! flexible joints follow. A coordinate belongs to each row: link positions
//! first, then the motor positions of flexible joints.

use crate::chain::Chain;
use crate::drives::{Drive, State, Term};
use crate::friction::Shape;
use crate::links::{LengthError, Workspace, check, lengths};
use crate::spatial::BODY;

/// The links of a robot, and which inertial parameters stand in theta.
#[derive(Clone, Copy, Debug)]
pub struct Links<'a> {
    /// The tree of joints.
    pub chain: Chain<'a>,
    /// Which of the [`BODY`] parameters each inertial parameter of theta is,
    /// link by link.
    pub selected: &'a [usize],
    /// Where each link's inertial parameters begin in theta, and where the
    /// last end, \[n + 1\].
    pub first: &'a [usize],
    /// First entry of joint `i` and link `j`, \[n × n\].
    pub entries: &'a [usize],
    /// What a parameter of theta does to a body beyond the one it is; none if
    /// each is that of one body.
    pub shares: &'a [Share],
}

/// An inertial parameter of theta that stands in two bodies: in the regressor,
/// its entry takes a share of another one's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// Entry of the parameter.
    pub entry: usize,
    /// Entry of the other body's parameter in the same row.
    pub of: usize,
    /// How much of it.
    pub factor: f64,
}

/// A robot as its rows and entries.
#[derive(Clone, Copy, Debug)]
pub struct Robot<'a> {
    /// Links.
    pub links: Links<'a>,
    /// Drives.
    pub terms: &'a [Term],
    /// Shapes of the friction laws, \[n\].
    pub shapes: &'a [Shape],
    /// Motor positions per joint position, \[n × n\] with ones on the diagonal
    /// and zeros between rigid and flexible joints; nothing if each motor drives
    /// its joint alone.
    pub coupling: Option<&'a [f64]>,
    /// Motor row of each joint; nothing if it is rigid, \[n\].
    pub motor_rows: &'a [Option<usize>],
    /// Number of entries.
    pub entries: usize,
}

/// Torques on a robot from outside its equations.
#[derive(Clone, Copy, Debug)]
pub struct Torques<'t> {
    /// Of the motors, after gear and coupling, \[n\], N·m (N).
    pub motor: &'t [f64],
    /// On the links, \[n\], N·m (N); none if nothing touches them.
    pub link: Option<&'t [f64]>,
}

/// Values of a robot's parameters, as its dynamics need them.
#[derive(Clone, Copy, Debug)]
pub struct Values<'a> {
    /// The parameter vector, \[p\].
    pub theta: &'a [f64],
    /// Bodies that move as theta says, \[n\].
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

    /// Returns the joint that a row belongs to.
    #[must_use]
    pub fn joint_of(&self, row: usize) -> usize {
        if row < self.joints() {
            row
        } else {
            let mut rows = self.motor_rows.iter();
            rows.position(|own| *own == Some(row)).unwrap_or(0)
        }
    }

    /// Returns the row whose coordinate is the motor position of a joint: the one
    /// that has the motor torque on its right-hand side.
    #[must_use]
    pub fn motor_coordinate(&self, joint: usize) -> usize {
        self.motor_rows[joint].unwrap_or(joint)
    }

    /// Returns the motor positions per joint position of a coupled
    /// transmission.
    #[must_use]
    pub fn ratio(&self, motor: usize, joint: usize) -> f64 {
        match self.coupling {
            Some(ratios) => ratios[motor * self.joints() + joint],
            None if motor == joint => 1.0,
            None => 0.0,
        }
    }

    /// Writes the torque on each coordinate, \[rows\], N·m (N).
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

    /// Writes the velocities of the motors before a coupling, or with their
    /// accelerations after it, those before it.
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

    /// Returns a joint as its drive sees it.
    #[must_use]
    pub fn drive(&self, state: &State<'_>, joint: usize) -> Drive {
        let motor_velocity = match self.coupling {
            None => state.dphi[joint],
            Some(_) => (state.dphi.iter().enumerate())
                .map(|(k, dphi)| self.ratio(joint, k) * dphi)
                .sum(),
        };
        Drive::new(state, motor_velocity, joint)
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
