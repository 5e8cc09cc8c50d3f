//! Columns of a joint's drive: rotor inertia, spring and friction.
//!
//! Each [`Term`] puts one parameter into one row: a link row, the motor row of
//! a flexible joint, or the only row of a rigid one.

use crate::friction::Shape;
use crate::parameters::{JointParameter, Side};

/// One parameter of a drive in one row of the regressor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// Row of the regressor.
    pub row: usize,
    /// Entry of the regressor.
    pub entry: usize,
    /// Index in theta.
    pub column: usize,
    /// What the parameter means.
    pub what: JointParameter,
    /// Joint, or motor, whose coordinate it acts on.
    pub joint: usize,
    /// How much of it the row takes: -1 for a spring in a link row, the ratio of
    /// a coupled transmission for a motor's friction and inertia, otherwise 1.
    pub gain: f64,
}

/// Positions and velocities of all joints, each \[n\]; a rigid joint's motor
/// moves with its link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<'s> {
    /// Link positions, rad (m).
    pub q: &'s [f64],
    /// Link velocities, rad/s (m/s).
    pub dq: &'s [f64],
    /// Motor positions after gear and coupling, rad (m).
    pub phi: &'s [f64],
    /// Motor velocities after gear and coupling, rad/s (m/s).
    pub dphi: &'s [f64],
}

impl Term {
    /// Returns the entries of `Y_a` and `Y_b`.
    ///
    /// - `motor_velocity`: of the motors, before a coupling, \[n\], rad/s.
    ///
    /// # Source
    ///
    /// Eq. (1): `F_v1 dq + f_c1(dq) + K (q - phi)` in a link row,
    /// `M_2 ddphi + F_v2 dphi + f_c2(dphi) + K (phi - q)` in a motor row.
    #[must_use]
    #[inline]
    pub fn columns(
        &self,
        state: &State<'_>,
        motor_velocity: &[f64],
        shapes: &[Shape],
    ) -> (f64, f64) {
        let i = self.joint;
        let deflection = || state.phi[i] - state.q[i];
        let rest = match self.what {
            JointParameter::RotorInertia => return (self.gain * motor_velocity[i], 0.0),
            JointParameter::Stiffness => deflection(),
            JointParameter::CubicStiffness => {
                let d = deflection();
                d * d * d
            }
            JointParameter::Damping => state.dphi[i] - state.dq[i],
            JointParameter::Preload => -1.0,
            JointParameter::Friction(Side::Link, law) => law.column(state.dq[i], &shapes[i]),
            JointParameter::Friction(Side::Motor, law) => law.column(motor_velocity[i], &shapes[i]),
        };
        (0.0, self.gain * rest)
    }
}
