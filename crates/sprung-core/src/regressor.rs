//! One sample's regressor `[Y_a | Y_b]`, and the same columns as dynamics.
//!
//! Each row of the regressor touches few parameters, so only the entries that
//! can differ from zero are kept, row after row. Rows 0 to n-1 are those of the
//! joints: link rows of flexible joints, which have no right-hand side, and the
//! only rows of rigid ones. The motor rows of flexible joints follow.

use crate::chain::Chain;
use crate::drives::{State, Term};
use crate::dynamics::{inverse_dynamics, mass_matrix, solve_positive};
use crate::friction::Shape;
use crate::links::{LengthError, Step, Workspace, check, columns, lengths};
use crate::parameters::JointParameter;
use crate::planar_2r::{self, Pose};
use crate::scalar::{Jet, Scalar};
use crate::spatial::BODY;

/// The links of a robot, and which inertial parameters stand in theta.
#[derive(Clone, Copy, Debug)]
pub enum Links<'a> {
    /// The paper's planar arm in closed form.
    Planar2R {
        /// First link entry of each row.
        entries: [usize; planar_2r::JOINTS],
    },
    /// Any tree of joints.
    Tree {
        /// The tree.
        chain: Chain<'a>,
        /// Which of the [`BODY`] parameters each inertial parameter of theta is,
        /// link by link.
        selected: &'a [usize],
        /// Where each link's inertial parameters begin in theta, and where the
        /// last end, \[n + 1\].
        first: &'a [usize],
        /// First entry of joint `i` and link `j`, \[n × n\].
        entries: &'a [usize],
    },
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

/// Accelerations of links and motors, each \[n\]; those of a rigid joint agree.
#[derive(Debug)]
pub struct Accelerations<'o> {
    /// Link accelerations, rad/s² (m/s²).
    pub ddq: &'o mut [f64],
    /// Motor accelerations after gear and coupling, rad/s² (m/s²).
    pub ddphi: &'o mut [f64],
}

/// Torques on a robot from outside its equations.
#[derive(Clone, Copy, Debug)]
pub struct Torques<'t> {
    /// Of the motors, after gear and coupling, \[n\], N·m (N).
    pub motor: &'t [f64],
    /// On the links, \[n\], N·m (N); none if nothing touches them.
    pub link: Option<&'t [f64]>,
}

/// Rotors that a mass matrix takes in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rotors {
    /// Those that move with their links.
    OfRigidJoints,
    /// All, as if no joint had a spring.
    All,
}

/// Inertial parameters of a robot's links, as its dynamics need them.
#[derive(Clone, Copy, Debug)]
pub struct Values<'a> {
    /// The parameter vector, \[p\].
    pub theta: &'a [f64],
    /// Bodies of a tree that move as theta says, \[n\]; empty for a closed form.
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

    /// Writes one sample's regressor, row after row.
    ///
    /// - `momentum`, `rest`: entries of `Y_a` and `Y_b`. With the parameters
    ///   theta, `d/dt(Y_a theta) + Y_b theta = [0; tau]`; the only row of a rigid
    ///   joint has its torque on the right too.
    ///
    /// # Errors
    ///
    /// [`LengthError`] if a slice does not fit the robot.
    ///
    /// # Source
    ///
    /// Eq. (8) and section 3, corrected as said at each column.
    pub fn regressor(
        &self,
        state: &State<'_>,
        workspace: &mut Workspace<'_>,
        momentum: &mut [f64],
        rest: &mut [f64],
    ) -> Result<(), LengthError> {
        self.check(state, workspace)?;
        self.check_entries(momentum, rest)?;
        match self.links {
            Links::Planar2R { entries } => {
                let pose = Pose::new(&pair(state.q));
                let of_momentum = pose.momentum(&pair(state.dq));
                let of_rest = pose.rest(&pair(state.dq));
                for (row, first) in entries.into_iter().enumerate() {
                    // Link 1 does not move in the second row.
                    for column in row..planar_2r::INERTIAL {
                        momentum[first + column - row] = of_momentum[row][column];
                        rest[first + column - row] = of_rest[row][column];
                    }
                }
            }
            Links::Tree {
                chain,
                selected,
                first,
                entries,
            } => {
                let n = self.joints();
                let put = |i: usize, j: usize, of_momentum: &[f64; BODY], of_rest: &[f64; BODY]| {
                    let chosen = &selected[first[j]..first[j + 1]];
                    let at = entries[i * n + j];
                    let momentum = &mut momentum[at..at + chosen.len()];
                    let rest = &mut rest[at..at + chosen.len()];
                    for ((momentum, rest), &k) in momentum.iter_mut().zip(rest).zip(chosen) {
                        *momentum = of_momentum[k];
                        *rest = of_rest[k];
                    }
                };
                columns(&chain, state.q, state.dq, workspace, put)?;
            }
        }
        self.drives(state, workspace, momentum, rest)
    }

    /// Writes the entries of the drives and leaves those of the links alone: all
    /// that motor rows hold.
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
        let n = self.joints();
        let motor_velocity = &mut workspace.numbers[..n];
        self.motor_velocities(state.dphi, motor_velocity);
        for term in self.terms {
            let (of_momentum, of_rest) = term.columns(state, motor_velocity, self.shapes);
            momentum[term.entry] = of_momentum;
            rest[term.entry] = of_rest;
        }
        Ok(())
    }

    /// Writes the accelerations that motor torques cause, as
    /// [`Robot::forced_acceleration`] with nothing on the links.
    ///
    /// - `tau`: motor torques after gear and coupling, \[n\], N·m (N).
    ///
    /// # Errors
    ///
    /// [`LengthError`] if a slice does not fit the robot.
    pub fn acceleration(
        &self,
        values: &Values<'_>,
        state: &State<'_>,
        tau: &[f64],
        workspace: &mut Workspace<'_>,
        out: &mut Accelerations<'_>,
    ) -> Result<(), LengthError> {
        let torques = Torques {
            motor: tau,
            link: None,
        };
        self.forced_acceleration(values, state, &torques, workspace, out)
    }

    /// Writes the accelerations that torques on motors and links cause.
    ///
    /// - `out`: NaN if the mass matrix is not positive.
    ///
    /// The drives' torques are the columns of [`Robot::regressor`] times theta.
    ///
    /// # Errors
    ///
    /// [`LengthError`] if a slice does not fit the robot.
    ///
    /// # Source
    ///
    /// Eq. (1).
    pub fn forced_acceleration(
        &self,
        values: &Values<'_>,
        state: &State<'_>,
        torques: &Torques<'_>,
        workspace: &mut Workspace<'_>,
        out: &mut Accelerations<'_>,
    ) -> Result<(), LengthError> {
        self.check(state, workspace)?;
        let n = self.joints();
        let tau = torques.motor;
        if let Some(link) = torques.link {
            lengths(&[("link torques", link.len())], n)?;
        }
        let Accelerations { ddq, ddphi } = out;
        lengths(
            &[
                ("tau", tau.len()),
                ("ddq", ddq.len()),
                ("ddphi", ddphi.len()),
            ],
            n,
        )?;
        // The torques that the links need while they do not accelerate.
        let zeros = &mut workspace.numbers[..n];
        zeros.fill(0.0);
        let steps = &mut *workspace.steps;
        self.link_torque(values, state.q, state.dq, zeros, steps, ddq)?;
        for (i, (ddq, ddphi)) in ddq.iter_mut().zip(ddphi.iter_mut()).enumerate() {
            *ddphi = tau[i];
            *ddq = if self.motor_rows[i].is_some() {
                -*ddq
            } else {
                tau[i] - *ddq
            };
        }
        for (ddq, torque) in ddq.iter_mut().zip(torques.link.unwrap_or_default()) {
            *ddq += torque;
        }
        let motor_velocity = &mut workspace.numbers[..n];
        self.motor_velocities(state.dphi, motor_velocity);
        for term in self.terms {
            let (_, rest) = term.columns(state, motor_velocity, self.shapes);
            let torque = values.theta[term.column] * rest;
            match term.row.checked_sub(n) {
                None => ddq[term.row] -= torque,
                Some(_) => ddphi[self.joint_of(term.row)] -= torque,
            }
        }
        let mut numbers = core::mem::take(&mut workspace.numbers);
        let (matrix, vectors) = numbers.split_at_mut(n * n);
        let link_masses = self.mass_matrix(values, state.q, workspace, matrix);
        if link_masses.is_ok() {
            self.add_motors(values.theta, Rotors::OfRigidJoints, matrix);
            solve_positive(matrix, ddq);
            self.solve_motors(values.theta, matrix, &mut vectors[..n], ddq, ddphi);
        }
        core::mem::swap(&mut workspace.numbers, &mut numbers);
        link_masses
    }

    /// Writes the mass matrix of the links, \[n × n\], row by row.
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
        match self.links {
            Links::Planar2R { .. } => {
                const N: usize = planar_2r::JOINTS;
                lengths(&[("q", q.len())], N)?;
                lengths(&[("matrix", matrix.len())], N * N)?;
                let pose = Pose::new(&pair(q));
                for (j, dq) in [[1.0, 0.0], [0.0, 1.0]].iter().enumerate() {
                    for (i, row) in pose.momentum(dq).iter().enumerate() {
                        matrix[N * i + j] = row.iter().zip(values.theta).map(|(y, x)| y * x).sum();
                    }
                }
                Ok(())
            }
            Links::Tree { chain, .. } => mass_matrix(&chain, values.bodies, q, workspace, matrix),
        }
    }

    /// Adds what the rotors of rigid joints, or of all, add to a mass matrix.
    pub fn add_motors(&self, theta: &[f64], of: Rotors, matrix: &mut [f64]) {
        let n = self.joints();
        for term in self.terms {
            if term.what != JointParameter::RotorInertia {
                continue;
            }
            let joint = self.joint_of(term.row);
            if of == Rotors::OfRigidJoints && self.motor_rows[joint].is_some() {
                continue;
            }
            for k in 0..n {
                matrix[joint * n + k] += term.gain * self.ratio(term.joint, k) * theta[term.column];
            }
        }
    }

    /// Writes the torques that the links take, without drives, \[n\], N·m (N).
    ///
    /// With Taylor series for numbers it gives the torques' time derivatives.
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
        match self.links {
            Links::Planar2R { .. } => {
                lengths(
                    &[
                        ("q", q.len()),
                        ("dq", dq.len()),
                        ("ddq", ddq.len()),
                        ("tau", tau.len()),
                    ],
                    planar_2r::JOINTS,
                )?;
                let (q, dq, ddq) = (pair(q), pair(dq), pair(ddq));
                let torque = planar_2r::torque(values.theta, &q, &dq, &ddq);
                tau.copy_from_slice(&torque);
                Ok(())
            }
            Links::Tree { chain, .. } => {
                inverse_dynamics(&chain, values.bodies, q, dq, ddq, steps, tau)
            }
        }
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

    fn motor_velocities(&self, dphi: &[f64], out: &mut [f64]) {
        match self.coupling {
            None => out.copy_from_slice(dphi),
            Some(ratios) => {
                for (out, row) in out.iter_mut().zip(ratios.chunks(dphi.len())) {
                    *out = row.iter().zip(dphi).map(|(ratio, v)| ratio * v).sum();
                }
            }
        }
    }

    /// Solves the rotors' equations of flexible joints.
    fn solve_motors(
        &self,
        theta: &[f64],
        matrix: &mut [f64],
        vector: &mut [f64],
        ddq: &[f64],
        ddphi: &mut [f64],
    ) {
        let n = self.joints();
        if self.coupling.is_none() {
            vector.fill(0.0);
            for term in self.terms {
                if term.what == JointParameter::RotorInertia && term.row >= n {
                    vector[term.joint] += theta[term.column];
                }
            }
            for (ddphi, &mut inertia) in ddphi.iter_mut().zip(vector) {
                *ddphi = if inertia > 0.0 {
                    *ddphi / inertia
                } else {
                    f64::NAN
                };
            }
        } else {
            // Rigid joints do not couple to flexible ones: a one on their
            // diagonal leaves the others alone.
            matrix.fill(0.0);
            self.add_motors(theta, Rotors::All, matrix);
            for i in (0..n).filter(|i| self.motor_rows[*i].is_none()) {
                for k in 0..n {
                    matrix[i * n + k] = 0.0;
                    matrix[k * n + i] = 0.0;
                }
                matrix[i * n + i] = 1.0;
            }
            vector.copy_from_slice(ddphi);
            solve_positive(matrix, vector);
            ddphi.copy_from_slice(vector);
        }
        for (i, (ddphi, ddq)) in ddphi.iter_mut().zip(ddq).enumerate() {
            if self.motor_rows[i].is_none() {
                *ddphi = *ddq;
            }
        }
    }

    fn check_entries(&self, momentum: &[f64], rest: &[f64]) -> Result<(), LengthError> {
        let given = [("momentum", momentum.len()), ("rest", rest.len())];
        lengths(&given, self.entries)
    }

    fn check(&self, state: &State<'_>, workspace: &Workspace<'_>) -> Result<(), LengthError> {
        let given = [
            ("q", state.q.len()),
            ("dq", state.dq.len()),
            ("phi", state.phi.len()),
            ("dphi", state.dphi.len()),
        ];
        check(self.joints(), &given, workspace)
    }
}

/// Returns the first two of a slice that was checked to have them.
fn pair<S: Scalar>(values: &[S]) -> [S; 2] {
    core::array::from_fn(|i| values.get(i).copied().unwrap_or(S::ZERO))
}

/// Taylor series that give a torque and its first two time derivatives.
pub type TorqueSeries = Jet<3>;
