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
