//! Link columns of the paper's planar arm: two revolute joints with parallel
//! vertical axes, so that gravity does no work.
//!
//! The three link parameters are, with the rotor of joint 2 on the tip of
//! link 1 (the paper's Table II puts it elsewhere):
//!
//! - `theta1 = I1 + I2 + m1 l1² + (m2 + m_r2) L1² + m2 l2²`,
//! - `theta2 = m2 L1 l2`,
//! - `theta3 = I2 + m2 l2²`.
//!
//! They assume that the centre of mass of link 2 lies on the link's axis.

use crate::drives::Term;
use crate::friction::{Law, Shape};
use crate::parameters::JointParameter::{self, Friction, RotorInertia, Stiffness};
use crate::parameters::Side::{Link, Motor};
use crate::regressor::{Links, Robot};
use crate::scalar::Scalar;

/// Number of joints.
pub const JOINTS: usize = 2;

/// Number of link inertial parameters.
pub const INERTIAL: usize = 3;

/// Names and units of the link inertial parameters.
pub const INERTIAL_NAMES: [(&str, &str); INERTIAL] = [
    ("link1.inertia_total", "kg·m²"),
    ("link2.coupling", "kg·m²"),
    ("link2.inertia", "kg·m²"),
];

/// Link columns: one row per joint, one column per link parameter.
pub type LinkColumns<S> = [[S; INERTIAL]; JOINTS];

/// What the columns need to know of the link positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose<S> {
    sin: S,
    cos: S,
}

impl<S: Scalar> Pose<S> {
    /// Returns the pose at the link positions `q`, \[2\], rad.
    #[must_use]
    pub fn new(q: &[S; JOINTS]) -> Self {
        let (sin, cos) = q[1].sin_cos();
        Self { sin, cos }
    }

    /// Returns the momentum columns: times the link parameters they give
    /// `M_1(q) dq`, in N·m·s.
    ///
    /// - `dq`: link velocities, \[2\], rad/s.
    ///
    /// # Source
    ///
    /// `Y_a` of section 3. The printed entry (1, 2) is `2 (dq1 + dq2) cos q2`,
    /// which contradicts the paper's own `M_1`; it is `(2 dq1 + dq2) cos q2`.
    #[must_use]
    pub fn momentum(&self, dq: &[S; JOINTS]) -> LinkColumns<S> {
        [
            [dq[0], (dq[0] * 2.0 + dq[1]) * self.cos, dq[1]],
            [S::ZERO, dq[0] * self.cos, dq[0] + dq[1]],
        ]
    }

    /// Returns the columns that stand beside the time derivative of the
    /// momentum: times the link parameters they give `-dT/dq`, in N·m.
    ///
    /// - `dq`: link velocities, \[2\], rad/s.
    ///
    /// # Source
    ///
    /// Link part of `Y_b` of section 3: `(-dM_1/dt + C_A) dq`.
    #[must_use]
    pub fn rest(&self, dq: &[S; JOINTS]) -> LinkColumns<S> {
        let zero = S::ZERO;
        [
            [zero, zero, zero],
            [zero, (dq[0] * dq[1] + dq[0] * dq[0]) * self.sin, zero],
        ]
    }
}

/// Returns the columns of the joint torques at given accelerations.
///
/// - `q`, `dq`, `ddq`: link positions, velocities and accelerations, \[2\].
///
/// They are the time derivative of the momentum columns, which are linear in
/// the velocities, plus what stands beside it.
#[must_use]
pub fn torque_columns<S: Scalar>(
    q: &[S; JOINTS],
    dq: &[S; JOINTS],
    ddq: &[S; JOINTS],
) -> LinkColumns<S> {
    let pose = Pose::new(q);
    let mut columns = pose.momentum(ddq);
    // The rate of cos q2 along the motion.
    let turning = Pose {
        sin: S::ZERO,
        cos: -(pose.sin * dq[1]),
    };
    let (turned, rest) = (turning.momentum(dq), pose.rest(dq));
    for (i, row) in columns.iter_mut().enumerate() {
        for (column, rate) in row.iter_mut().enumerate() {
            *rate = *rate + rest[i][column];
        }
        // The only momentum column that depends on the pose.
        row[1] = row[1] + turned[i][1];
    }
    columns
}

/// Returns the joint torques that a motion of the links takes, \[2\], N·m.
///
/// - `theta`: parameters, the three inertial ones first.
/// - `q`, `dq`, `ddq`: link positions, velocities and accelerations, \[2\].
#[must_use]
pub fn torque<S: Scalar>(
    theta: &[f64],
    q: &[S; JOINTS],
    dq: &[S; JOINTS],
    ddq: &[S; JOINTS],
) -> [S; JOINTS] {
    torque_columns(q, dq, ddq).map(|row| {
        let products = row.into_iter().zip(theta);
        products.fold(S::ZERO, |sum, (column, value)| sum + column * *value)
    })
}

/// Number of parameters of the paper's arm.
pub const PARAMETERS: usize = 15;

/// Number of entries of its regressor that can differ from zero.
pub const ENTRIES: usize = 19;

/// Columns of theta that each of its rows touches: two link rows, two motor
/// rows.
pub const ROW_COLUMNS: [&[usize]; 2 * JOINTS] = [
    &[0, 1, 2, 5, 9, 11],
    &[1, 2, 6, 10, 12],
    &[3, 7, 9, 13],
    &[4, 8, 10, 14],
];

const fn term(row: usize, entry: usize, column: usize, what: JointParameter, gain: f64) -> Term {
    Term {
        row,
        entry,
        column,
        what,
        joint: row % JOINTS,
        gain,
    }
}

const TERMS: [Term; 14] = [
    term(0, 3, 5, Friction(Link, Law::Viscous), 1.0),
    term(0, 4, 9, Stiffness, -1.0),
    term(0, 5, 11, Friction(Link, Law::Coulomb), 1.0),
    term(1, 8, 6, Friction(Link, Law::Viscous), 1.0),
    term(1, 9, 10, Stiffness, -1.0),
    term(1, 10, 12, Friction(Link, Law::Coulomb), 1.0),
    term(2, 11, 3, RotorInertia, 1.0),
    term(2, 12, 7, Friction(Motor, Law::Viscous), 1.0),
    term(2, 13, 9, Stiffness, 1.0),
    term(2, 14, 13, Friction(Motor, Law::Coulomb), 1.0),
    term(3, 15, 4, RotorInertia, 1.0),
    term(3, 16, 8, Friction(Motor, Law::Viscous), 1.0),
    term(3, 17, 10, Stiffness, 1.0),
    term(3, 18, 14, Friction(Motor, Law::Coulomb), 1.0),
];

/// Returns the paper's arm: 15 parameters in its order.
#[must_use]
pub const fn robot(shapes: &[Shape; JOINTS]) -> Robot<'_> {
    Robot {
        links: Links::Planar2R { entries: [0, 6] },
        terms: &TERMS,
        shapes,
        coupling: None,
        motor_rows: &[Some(2), Some(3)],
        entries: ENTRIES,
    }
}
