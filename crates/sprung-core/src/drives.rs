//! Columns of a joint's drive: rotor inertia, spring and friction.
//!
//! Each [`Term`] puts one parameter into one row: a link row, the motor row of
//! a flexible joint, or the only row of a rigid one.

use crate::friction::{Conditions, Shape};
use crate::parameters::{JointParameter, Side};
use crate::scalar::{Dual, Scalar};

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

/// A joint as its drive sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive<S = f64> {
    /// Motor position minus link position, rad (m).
    pub deflection: S,
    /// Motor velocity minus link velocity, rad/s (m/s).
    pub deflection_rate: S,
    /// Link velocity, rad/s (m/s).
    pub link_velocity: S,
    /// Velocity of the motor itself, before a coupling, rad/s (m/s).
    pub motor_velocity: S,
}

impl Drive {
    /// Returns the drive of a joint.
    ///
    /// - `motor_velocity`: of its motor, before a coupling, rad/s (m/s).
    #[inline]
    pub(crate) fn new(state: &State<'_>, motor_velocity: f64, joint: usize) -> Self {
        Self {
            deflection: state.phi[joint] - state.q[joint],
            deflection_rate: state.dphi[joint] - state.dq[joint],
            link_velocity: state.dq[joint],
            motor_velocity,
        }
    }
}

impl<S: Scalar> Drive<S> {
    /// Returns what friction on a side sees.
    #[must_use]
    #[inline]
    pub fn conditions(&self, side: Side, shape: &Shape) -> Conditions<S> {
        Conditions {
            velocity: match side {
                Side::Link => self.link_velocity,
                Side::Motor => self.motor_velocity,
            },
            load: self.deflection * shape.load_stiffness,
        }
    }
}

impl Term {
    /// Returns the entry of `Y_a`, or its rate: what the row takes of the
    /// parameter's momentum.
    ///
    /// - `motor_rate`: velocity of the motor, before a coupling, rad/s (m/s); with
    ///   its acceleration instead, the entry's rate.
    ///
    /// # Source
    ///
    /// Eq. (1): `M_2 ddphi` in a motor row.
    #[must_use]
    #[inline]
    pub fn momentum(&self, motor_rate: f64) -> f64 {
        match self.what {
            JointParameter::RotorInertia => self.gain * motor_rate,
            _ => 0.0,
        }
    }

    /// Returns the entry of `Y_b`: what the row takes of the parameter's torque.
    ///
    /// # Source
    ///
    /// Eq. (1): `F_v1 dq + f_c1(dq) + K (q - phi)` in a link row,
    /// `F_v2 dphi + f_c2(dphi) + K (phi - q)` in a motor row.
    #[must_use]
    #[inline]
    pub fn rest<S: Scalar>(&self, drive: &Drive<S>, shape: &Shape) -> S {
        let torque = match self.what {
            JointParameter::RotorInertia => return S::ZERO,
            JointParameter::Stiffness => drive.deflection,
            JointParameter::CubicStiffness => {
                drive.deflection * drive.deflection * drive.deflection
            }
            JointParameter::Damping => drive.deflection_rate,
            JointParameter::Preload => S::constant(-1.0),
            JointParameter::Friction(side, law) => {
                law.column(&drive.conditions(side, shape), shape)
            }
        };
        torque * self.gain
    }
    /// Returns the derivatives of [`Term::rest`] by what the drive sees.
    #[must_use]
    pub fn slopes(&self, drive: &Drive, shape: &Shape) -> Drive {
        let at = Drive {
            deflection: Dual::<4>::variable(drive.deflection, 0),
            deflection_rate: Dual::variable(drive.deflection_rate, 1),
            link_velocity: Dual::variable(drive.link_velocity, 2),
            motor_velocity: Dual::variable(drive.motor_velocity, 3),
        };
        let [deflection, deflection_rate, link_velocity, motor_velocity] =
            self.rest(&at, shape).partials;
        Drive {
            deflection,
            deflection_rate,
            link_velocity,
            motor_velocity,
        }
    }
}
