//! Columns of one joint's drive: rotor inertia, spring and friction.
//!
//! A link row holds its link columns and [`link_side`]; a motor row holds
//! [`motor_side`] alone.

use crate::friction::{coulomb, viscous};
use crate::parameters::JointParameter;

/// Kinds of the columns that [`link_side`] returns, in that order.
pub const LINK_SIDE: [JointParameter; 3] = [
    JointParameter::LinkViscous,
    JointParameter::Stiffness,
    JointParameter::LinkCoulomb,
];

/// Kinds of the columns that [`motor_side`] returns, in that order.
pub const MOTOR_SIDE: [JointParameter; 4] = [
    JointParameter::RotorInertia,
    JointParameter::MotorViscous,
    JointParameter::Stiffness,
    JointParameter::MotorCoulomb,
];

/// Returns the link row's drive columns, those of `Y_b`; `Y_a` has none.
///
/// - `deflection`: `phi - q`, rad; `dq`: rad/s; `sharpness`: beta, s/rad.
///
/// # Source
///
/// Eq. (1), first line: `F_v1 dq + f_c1(dq) + K (q - phi)`.
#[must_use]
pub fn link_side(deflection: f64, dq: f64, sharpness: f64) -> [f64; 3] {
    [viscous(dq), -deflection, coulomb(dq, sharpness)]
}

/// Returns the motor row's momentum columns (`Y_a`) and remaining columns
/// (`Y_b`).
///
/// - `deflection`: `phi - q`, rad; `dphi`: rad/s; `sharpness`: beta, s/rad.
///
/// # Source
///
/// Eq. (1), second line: `M_2 ddphi + F_v2 dphi + f_c2(dphi) + K (phi - q)`.
#[must_use]
pub fn motor_side(deflection: f64, dphi: f64, sharpness: f64) -> ([f64; 4], [f64; 4]) {
    (
        [dphi, 0.0, 0.0, 0.0],
        [0.0, viscous(dphi), deflection, coulomb(dphi, sharpness)],
    )
}
