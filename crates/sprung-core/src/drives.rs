//! Regressor columns of a joint's drive: rotor inertia, spring, friction and back-EMF.
//!
//! Each [`Term`] is one parameter in one row: a link row, the motor row of a flexible joint, the
//! only row of a rigid joint, or the row of a torque sensor.

use crate::covariate::Covariate;
use crate::friction::{Conditions, Scale, Shape};
use crate::parameters::{JointParameter, Side};
use crate::presliding::{ALL_ELEMENTS, ELEMENTS};
use crate::scalar::{Dual, Scalar};

/// One parameter of a drive in one row of the regressor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// Row of the regressor.
    pub row: usize,
    /// Index of the entry of the regressor.
    pub entry: usize,
    /// Index in theta.
    pub column: usize,
    /// Kind of the parameter.
    pub what: JointParameter,
    /// Joint, or motor, on whose coordinate the parameter acts.
    pub joint: usize,
    /// Factor of the parameter in this row: -1 for a spring in a link row, the ratio of a coupled
    /// transmission for friction and inertia of a motor, otherwise 1.
    pub gain: f64,
}

/// Positions and velocities of all joints, each \[n\], and covariates. The motor of a rigid joint moves
/// with its link.
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
    /// Covariates of each joint minus their references, \[n × [`Covariate::COUNT`]\]; empty if no
    /// friction depends on any.
    pub excess: &'s [f64],
    /// Elements of presliding friction and hysteresis of each joint, \[n × [`ALL_ELEMENTS`]\]; empty if no
    /// joint has any, or the motion until now is not known and all elements slide.
    pub elements: &'s [f64],
}

/// Motion of one joint, as the columns of its drive need it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive<S = f64> {
    /// Motor position minus link position, rad (m).
    pub deflection: S,
    /// Motor velocity minus link velocity, rad/s (m/s).
    pub deflection_rate: S,
    /// Link velocity, rad/s (m/s).
    pub link_velocity: S,
    /// Velocity of the motor before the coupled transmission, rad/s (m/s).
    pub motor_velocity: S,
    /// Covariates minus their references.
    pub excess: [f64; Covariate::COUNT],
    /// Elements of presliding friction of the motor, then those of the spring's hysteresis; `None` if
    /// all slide.
    pub elements: Option<[S; ALL_ELEMENTS]>,
}

impl Drive {
    /// Returns the motion of one joint.
    ///
    /// - `motor_velocity`: velocity of its motor before the coupled transmission, rad/s (m/s).
    #[inline]
    pub(crate) fn new(state: &State<'_>, motor_velocity: f64, joint: usize) -> Self {
        Self {
            deflection: state.phi[joint] - state.q[joint],
            deflection_rate: state.dphi[joint] - state.dq[joint],
            link_velocity: state.dq[joint],
            motor_velocity,
            excess: excess_of(state.excess, joint),
            elements: (!state.elements.is_empty()).then(|| of_joint(state.elements, joint)),
        }
    }
}

/// Returns the covariates of one joint minus their references; zero if there are none.
///
/// - `all`: of all joints, \[n × [`Covariate::COUNT`]\], or empty.
#[must_use]
#[inline]
pub fn excess_of(all: &[f64], joint: usize) -> [f64; Covariate::COUNT] {
    of_joint(all, joint)
}

/// Returns the numbers of one joint among those of all; zeros if there are none.
fn of_joint<const COUNT: usize>(all: &[f64], joint: usize) -> [f64; COUNT] {
    let mut numbers = [0.0; COUNT];
    if let Some(given) = all.get(joint * COUNT..(joint + 1) * COUNT) {
        numbers.copy_from_slice(given);
    }
    numbers
}

impl<S: Scalar> Drive<S> {
    /// Returns the quantities on which a friction law on one side of the spring depends.
    #[must_use]
    #[inline]
    pub fn conditions(&self, side: Side) -> Conditions<S> {
        Conditions {
            velocity: match side {
                Side::Link => self.link_velocity,
                Side::Motor => self.motor_velocity,
            },
            deflection: self.deflection,
            presliding: match side {
                Side::Link => None,
                Side::Motor => (self.elements).map(|all| core::array::from_fn(|at| all[at])),
            },
        }
    }
}

impl Term {
    /// Returns the entry of `Y_a`: the momentum of the parameter in this row, per unit of the
    /// parameter.
    ///
    /// - `motor_rate`: velocity of the motor before the coupled transmission, rad/s (m/s). With the
    ///   motor's acceleration instead, the result is the time derivative of the entry.
    ///
    /// # Source
    ///
    /// Eq. (1): `M_2 ddphi` in a motor row.
    #[must_use]
    #[inline]
    pub fn momentum(&self, motor_rate: f64) -> f64 {
        match self.what {
            JointParameter::RotorInertia => self.gain * motor_rate,
            JointParameter::Stiffness
            | JointParameter::CubicStiffness
            | JointParameter::Damping
            | JointParameter::Hysteresis(_)
            | JointParameter::Preload
            | JointParameter::Friction(..)
            | JointParameter::Change(..)
            | JointParameter::BackEmf
            | JointParameter::TorqueOffset => 0.0,
        }
    }

    /// Returns the entry of `Y_b`: the torque of the parameter in this row, per unit of the
    /// parameter.
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
            JointParameter::Stiffness => behind_play(drive.deflection, shape),
            JointParameter::CubicStiffness => {
                drive.deflection * drive.deflection * drive.deflection
            }
            JointParameter::Damping => drive.deflection_rate,
            JointParameter::Hysteresis(at) => match drive.elements {
                Some(elements) => elements[ELEMENTS + at as usize],
                None => (drive.deflection_rate * shape.sharpness).tanh(),
            },
            JointParameter::Preload => S::constant(-1.0),
            JointParameter::BackEmf => drive.motor_velocity,
            JointParameter::TorqueOffset => S::constant(1.0),
            JointParameter::Friction(side, law) => law.column(&drive.conditions(side), shape),
            JointParameter::Change(side, law, with) => {
                law.column(&drive.conditions(side), shape) * drive.excess[with as usize]
            }
        };
        torque * self.gain
    }

    /// Returns the derivative of [`Term::rest`] by the logarithm of the sharpness or of the Stribeck velocity.
    #[must_use]
    pub fn by_log(&self, of: Scale, drive: &Drive, shape: &Shape) -> f64 {
        match self.what {
            JointParameter::Friction(side, law) => {
                self.gain * law.by_log(of, &drive.conditions(side), shape)
            }
            JointParameter::Change(side, law, with) => {
                let by_log = law.by_log(of, &drive.conditions(side), shape);
                self.gain * by_log * drive.excess[with as usize]
            }
            JointParameter::RotorInertia
            | JointParameter::Stiffness
            | JointParameter::CubicStiffness
            | JointParameter::Damping
            | JointParameter::Hysteresis(_)
            | JointParameter::Preload
            | JointParameter::BackEmf
            | JointParameter::TorqueOffset => 0.0,
        }
    }

    /// Returns the derivatives of [`Term::rest`] by the deflection, its rate and both velocities.
    #[must_use]
    pub fn slopes(&self, drive: &Drive, shape: &Shape) -> Drive {
        let at = Drive {
            deflection: Dual::<4>::variable(drive.deflection, 0),
            deflection_rate: Dual::variable(drive.deflection_rate, 1),
            link_velocity: Dual::variable(drive.link_velocity, 2),
            motor_velocity: Dual::variable(drive.motor_velocity, 3),
            excess: drive.excess,
            elements: (drive.elements).map(|elements| elements.map(Dual::constant)),
        };
        let [deflection, deflection_rate, link_velocity, motor_velocity] =
            self.rest(&at, shape).partials;
        Drive {
            deflection,
            deflection_rate,
            link_velocity,
            motor_velocity,
            excess: [0.0; Covariate::COUNT],
            elements: None,
        }
    }
}

/// Returns the deflection of a spring behind its play.
fn behind_play<S: Scalar>(deflection: S, shape: &Shape) -> S {
    if shape.play <= 0.0 {
        return deflection;
    }
    let from_centre = deflection - S::constant(shape.play_centre);
    let [over, under] =
        [shape.play, -shape.play].map(|edge| (from_centre + S::constant(edge)).abs());
    from_centre - (over - under) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPE: Shape = Shape {
        sharpness: 100.0,
        stribeck_velocity: 0.1,
        presliding_width: 0.5,
        hysteresis_width: 0.05,
        play: 0.01,
        play_centre: 0.002,
    };

    const DRIVE: Drive = Drive {
        deflection: -0.04,
        deflection_rate: 0.3,
        link_velocity: 0.02,
        motor_velocity: -0.01,
        excess: [3.0, -2.0, 0.5, 1.0, 4.0, -1.0],
        elements: Some([
            1.0, -1.0, 0.7, -0.4, 0.1, 0.0, 0.2, -0.3, 0.4, -0.5, 0.6, 1.0,
        ]),
    };

    #[test]
    fn laws_see_the_velocity_of_their_side_and_the_deflection() {
        let [link, motor] = [Side::Link, Side::Motor].map(|side| DRIVE.conditions(side));
        assert!((link.velocity - 0.02).abs() < 1e-15);
        assert!((motor.velocity + 0.01).abs() < 1e-15);
        assert!((link.deflection + 0.04).abs() < 1e-15 && (motor.deflection + 0.04).abs() < 1e-15);
    }

    #[test]
    fn slopes_are_limits_of_differences() {
        let h = 1e-6;
        // h² f‴ / 6: a tanh has the third derivative 2 s³ or less, with the sharpness s, its products with other laws
        // less than 3 s³.
        let limit = 0.5 * h * h * SHAPE.sharpness * SHAPE.sharpness * SHAPE.sharpness;
        let step = |at: usize, by: f64| {
            let mut drive = DRIVE;
            *[
                &mut drive.deflection,
                &mut drive.deflection_rate,
                &mut drive.link_velocity,
                &mut drive.motor_velocity,
            ][at] += by;
            drive
        };
        for what in JointParameter::ALL {
            let term = Term {
                row: 0,
                entry: 0,
                column: 0,
                what,
                joint: 0,
                gain: -0.7,
            };
            let slopes = term.slopes(&DRIVE, &SHAPE);
            let found = [
                slopes.deflection,
                slopes.deflection_rate,
                slopes.link_velocity,
                slopes.motor_velocity,
            ];
            for (at, found) in found.into_iter().enumerate() {
                let [ahead, behind] = [h, -h].map(|by| term.rest(&step(at, by), &SHAPE));
                let difference = (ahead - behind) / (2.0 * h);
                assert!((found - difference).abs() < limit, "{what:?}");
            }
        }
    }
}
