//! Link columns of the paper's planar arm in closed form. Its two revolute joints have parallel vertical axes, so
//! gravity does no work. The formulas are independent of the columns of trees.
//!
//! The three link parameters are, with the rotor of joint 2 on the tip of
//! link 1 (the paper's Table II puts it elsewhere):
//!
//! - `theta1 = I1 + I2 + m1 l1² + (m2 + m_r2) L1² + m2 l2²`,
//! - `theta2 = m2 L1 l2`,
//! - `theta3 = I2 + m2 l2²`.
//!
//! They assume that the centre of mass of link 2 lies on the link's axis.

use sprung_core::scalar::Scalar;

use crate::planar_2r::JOINTS;

/// Number of link inertial parameters.
pub(crate) const INERTIAL: usize = 3;

/// Link columns: one row per joint, one column per link parameter.
pub(crate) type LinkColumns<S> = [[S; INERTIAL]; JOINTS];

/// Functions of the link positions that the columns contain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pose<S> {
    sin: S,
    cos: S,
}

impl<S: Scalar> Pose<S> {
    /// Returns the pose at the link positions `q`, \[2\], rad.
    pub(crate) fn new(q: &[S; JOINTS]) -> Self {
        let (sin, cos) = q[1].sin_cos();
        Self { sin, cos }
    }

    /// Returns the momentum columns. Their product with the link parameters is `M_1(q) dq`, in N·m·s.
    ///
    /// - `dq`: link velocities, \[2\], rad/s.
    ///
    /// # Source
    ///
    /// `Y_a` of section 3. The printed entry (1, 2) is `2 (dq1 + dq2) cos q2`,
    /// which contradicts the paper's own `M_1`; it is `(2 dq1 + dq2) cos q2`.
    pub(crate) fn momentum(&self, dq: &[S; JOINTS]) -> LinkColumns<S> {
        [
            [dq[0], (dq[0] * 2.0 + dq[1]) * self.cos, dq[1]],
            [S::ZERO, dq[0] * self.cos, dq[0] + dq[1]],
        ]
    }

    /// Returns the columns beside the time derivative of the momentum. Their product with the link parameters is
    /// `-dT/dq`, in N·m.
    ///
    /// - `dq`: link velocities, \[2\], rad/s.
    ///
    /// # Source
    ///
    /// Link part of `Y_b` of section 3: `(-dM_1/dt + C_A) dq`.
    pub(crate) fn rest(&self, dq: &[S; JOINTS]) -> LinkColumns<S> {
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
/// They are the sum of the time derivative of the momentum columns, which are linear in the velocities, and the
/// columns beside it.
pub(crate) fn torque_columns<S: Scalar>(
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

/// Returns the joint torques of a motion of the links, \[2\], N·m.
///
/// - `theta`: parameters, the three inertial ones first.
/// - `q`, `dq`, `ddq`: link positions, velocities and accelerations, \[2\].
pub(crate) fn torque<S: Scalar>(
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
