//! Friction laws: one row of a table and one formula each.
//!
//! A law that is linear in its parameter is a column: the friction torque is
//! the column times the parameter. What a law is not linear in stands in
//! [`Shape`]. Formulas are written over [`Scalar`], so that regression,
//! simulation and derivatives share them.

use crate::chain::JointKind;
use crate::scalar::Scalar;

/// What acts in a joint, as a friction law sees it. A law that needs more, as
/// the temperature, gets it as one more field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditions<S = f64> {
    /// Velocity of the side that the law acts on, rad/s (m/s).
    pub velocity: S,
    /// Torque that the spring carries, N·m (N), from the stiffness in
    /// [`Shape`]; zero in a rigid joint.
    pub load: S,
}

/// What a law is not linear in: values that stay while its parameter is
/// estimated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// beta of `tanh(beta v)`, s/rad (s/m), positive.
    pub sharpness: f64,
    /// Velocity at which Stribeck friction has fallen to 1/e, rad/s (m/s),
    /// positive.
    pub stribeck_velocity: f64,
    /// Stiffness that turns a deflection into a load, N·m/rad (N/m).
    pub load_stiffness: f64,
}

/// What the parameter of a law is measured in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unit {
    Torque,
    TorquePerVelocity,
}

/// Whether a law can feed energy into the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Power {
    /// It takes energy out if its parameter is positive.
    Taken,
    /// It does either: no friction by itself, but found with it.
    Either,
}

/// Declares the laws, one row each, under the family and the word that choose
/// them.
macro_rules! laws {
    ($($(#[$about:meta])* $family:ident $word:literal: {
        $(#[doc = $doc:literal] $law:ident $name:literal, $unit:ident, $power:ident;)*
    })*) => {
        /// A friction law with one parameter.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Law {
            $($(#[doc = $doc] $law,)*)*
        }

        /// Laws that a description chooses together.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Family {
            $($(#[$about])* $family,)*
        }

        impl Family {
            /// All families, in the order of their parameters.
            pub const ALL: &[Self] = &[$(Self::$family),*];

            /// Returns the word that chooses the family.
            #[must_use]
            pub const fn word(self) -> &'static str {
                match self {
                    $(Self::$family => $word,)*
                }
            }

            /// Returns its laws.
            #[must_use]
            pub const fn laws(self) -> &'static [Law] {
                match self {
                    $(Self::$family => &[$(Law::$law),*],)*
                }
            }
        }

        impl Law {
            /// Returns what the law is, as a noun with a full stop.
            #[must_use]
            pub const fn about(self) -> &'static str {
                match self {
                    $($(Self::$law => $doc,)*)*
                }
            }

            /// Returns the names of the parameter on the link's and on the
            /// motor's side.
            pub(crate) const fn names(self) -> [&'static str; 2] {
                match self {
                    $($(Self::$law => [concat!("link_", $name), concat!("motor_", $name)],)*)*
                }
            }

            const fn measured_in(self) -> Unit {
                match self {
                    $($(Self::$law => Unit::$unit,)*)*
                }
            }

            const fn power(self) -> Power {
                match self {
                    $($(Self::$law => Power::$power,)*)*
                }
            }
        }
    };
}

laws! {
    /// In proportion to the velocity.
    Viscous "viscous": {
        /// Viscous friction.
        Viscous "viscous", TorquePerVelocity, Taken;
    }
    /// Of one size, against the motion.
    Coulomb "coulomb": {
        /// Coulomb friction.
        Coulomb "coulomb", Torque, Taken;
    }
    /// A constant torque, as by the zero of a current sensor.
    Offset "offset": {
        /// Constant torque.
        Offset "offset", Torque, Either;
    }
    /// Viscous, with a value for each direction.
    ViscousAsymmetric "viscous-asymmetric": {
        /// Viscous friction of positive velocities.
        ViscousPositive "viscous_positive", TorquePerVelocity, Taken;
        /// Viscous friction of negative velocities.
        ViscousNegative "viscous_negative", TorquePerVelocity, Taken;
    }
    /// Coulomb, with a value for each direction.
    CoulombAsymmetric "coulomb-asymmetric": {
        /// Coulomb friction of positive velocities.
        CoulombPositive "coulomb_positive", Torque, Taken;
        /// Coulomb friction of negative velocities.
        CoulombNegative "coulomb_negative", Torque, Taken;
    }
    /// More friction at low velocity than at high.
    Stribeck "stribeck": {
        /// Stribeck friction.
        Stribeck "stribeck", Torque, Either;
    }
}

/// How a law depends on the velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Form<S> {
    /// Its column.
    Smooth(S),
    /// What `tanh(beta v)` is multiplied with to give its column.
    Jump(S),
}

impl Law {
    /// Returns the law: its only definition.
    ///
    /// # Source
    ///
    /// Eq. (1), `F_v`, and eq. (2), `tanh(beta v)`. The paper's `Y_b4` prints
    /// positions where velocities belong.
    fn form<S: Scalar>(self, at: &Conditions<S>, shape: &Shape) -> Form<S> {
        match self {
            Self::Viscous => Form::Smooth(at.velocity),
            Self::ViscousPositive => Form::Smooth(at.velocity * forwards(at)),
            Self::ViscousNegative => Form::Smooth(at.velocity * backwards(at)),
            Self::Offset => Form::Smooth(S::constant(1.0)),
            Self::Coulomb => Form::Jump(S::constant(1.0)),
            Self::CoulombPositive => Form::Jump(S::constant(forwards(at))),
            Self::CoulombNegative => Form::Jump(S::constant(backwards(at))),
            Self::Stribeck => Form::Jump(bell(at, shape)),
        }
    }

    /// Returns the column of the law: times the parameter it is the friction
    /// torque.
    ///
    /// At zero velocity, where a half begins, the derivative is that of the side
    /// where it acts.
    #[must_use]
    pub fn column<S: Scalar>(self, at: &Conditions<S>, shape: &Shape) -> S {
        match self.form(at, shape) {
            Form::Smooth(column) => column,
            Form::Jump(height) => (at.velocity * shape.sharpness).tanh() * height,
        }
    }

    /// Returns what `tanh(beta v)` is multiplied with in the column of a law that
    /// jumps at zero velocity; nothing for a smooth law.
    #[must_use]
    pub fn jump(self, at: &Conditions, shape: &Shape) -> Option<f64> {
        match self.form(at, shape) {
            Form::Smooth(_) => None,
            Form::Jump(height) => Some(height),
        }
    }

    /// Returns the unit of the parameter, at a joint that turns or slides.
    #[must_use]
    pub const fn unit(self, kind: JointKind) -> &'static str {
        match (self.measured_in(), kind) {
            (Unit::Torque, JointKind::Revolute) => "N·m",
            (Unit::Torque, JointKind::Prismatic) => "N",
            (Unit::TorquePerVelocity, JointKind::Revolute) => "N·m·s/rad",
            (Unit::TorquePerVelocity, JointKind::Prismatic) => "N·s/m",
        }
    }

    /// Returns whether the law takes energy out of the robot.
    #[must_use]
    pub const fn takes_energy(self) -> bool {
        matches!(self.power(), Power::Taken)
    }
}

/// Returns 1 where the joint does not move backwards, 0 elsewhere.
fn forwards<S: Scalar>(at: &Conditions<S>) -> f64 {
    if at.velocity.value() >= 0.0 { 1.0 } else { 0.0 }
}

/// Returns 1 where the joint does not move forwards, 0 elsewhere.
fn backwards<S: Scalar>(at: &Conditions<S>) -> f64 {
    if at.velocity.value() <= 0.0 { 1.0 } else { 0.0 }
}

/// Returns how much of Stribeck friction is left at a velocity.
///
/// # Source
///
/// Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 1994:
/// `exp(-(v / v_s)²)`.
fn bell<S: Scalar>(at: &Conditions<S>, shape: &Shape) -> S {
    let part = at.velocity * (1.0 / shape.stribeck_velocity);
    (-(part * part)).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Dual;

    const SHAPE: Shape = Shape {
        sharpness: 100.0,
        stribeck_velocity: 0.1,
        load_stiffness: 300.0,
    };

    /// Velocities on both sides of zero, beside which nothing bends sharply.
    const VELOCITIES: [f64; 5] = [-0.7, -0.02, 0.003, 0.05, 0.4];

    fn all() -> impl Iterator<Item = Law> {
        Family::ALL.iter().flat_map(|family| family.laws()).copied()
    }

    fn column(law: Law, velocity: f64, load: f64) -> f64 {
        law.column(&Conditions { velocity, load }, &SHAPE)
    }

    #[test]
    fn friction_takes_power_at_any_velocity() {
        for velocity in [-3.0, -1e-3, 0.0, 1e-3, 3.0] {
            for law in all().filter(|law| *law != Law::Offset) {
                assert!(velocity * column(law, velocity, -40.0) >= 0.0, "{law:?}");
            }
            assert!(column(Law::Coulomb, velocity, 0.0).abs() <= 1.0);
        }
    }

    #[test]
    fn derivatives_are_limits_of_differences() {
        let h = 1e-6;
        for (velocity, load) in VELOCITIES.into_iter().zip([3.0, -40.0, 7.0, -0.5, 20.0]) {
            for law in all() {
                let at = Conditions {
                    velocity: Dual::<2>::variable(velocity, 0),
                    load: Dual::variable(load, 1),
                };
                let dual = law.column(&at, &SHAPE);
                let value = column(law, velocity, load);
                assert_eq!(dual.value.to_bits(), value.to_bits(), "{law:?}");
                let slope = |ahead: f64, behind: f64| (ahead - behind) / (2.0 * h);
                let by_velocity = slope(
                    column(law, velocity + h, load),
                    column(law, velocity - h, load),
                );
                let by_load = slope(
                    column(law, velocity, load + h),
                    column(law, velocity, load - h),
                );
                for (found, difference) in dual.partials.iter().zip([by_velocity, by_load]) {
                    assert!((found - difference).abs() < 1e-5, "{law:?} at {velocity}");
                }
            }
        }
    }

    #[test]
    fn halves_have_their_slope_at_zero_too() {
        let slope = |law: Law, velocity: f64| {
            let at = Conditions {
                velocity: Dual::<1>::variable(velocity, 0),
                load: Dual::constant(0.0),
            };
            law.column(&at, &SHAPE).partials[0]
        };
        for (law, whole) in [
            (Law::ViscousPositive, Law::Viscous),
            (Law::ViscousNegative, Law::Viscous),
            (Law::CoulombPositive, Law::Coulomb),
            (Law::CoulombNegative, Law::Coulomb),
        ] {
            assert!(
                (slope(law, 0.0) - slope(whole, 0.0)).abs() < 1e-15,
                "{law:?}"
            );
        }
    }

    #[test]
    fn jumps_are_what_the_transition_is_multiplied_with() {
        for velocity in VELOCITIES {
            let at = Conditions {
                velocity,
                load: 5.0,
            };
            for law in all() {
                if let Some(jump) = law.jump(&at, &SHAPE) {
                    let expected = jump * libm::tanh(100.0 * velocity);
                    assert!(
                        (law.column(&at, &SHAPE) - expected).abs() < 1e-15,
                        "{law:?}"
                    );
                }
            }
            assert_eq!(Law::Viscous.jump(&at, &SHAPE), None);
            assert_eq!(Law::Offset.jump(&at, &SHAPE), None);
        }
    }

    #[test]
    fn halves_make_a_whole_and_the_bell_is_gone_at_speed() {
        for velocity in [-0.7, -0.02, 0.0, 0.005, 0.4] {
            let column = |law: Law| column(law, velocity, 0.0);
            let sum = |a: Law, b: Law| column(a) + column(b);
            let viscous = sum(Law::ViscousPositive, Law::ViscousNegative);
            assert!((viscous - column(Law::Viscous)).abs() < 1e-15);
            let coulomb = sum(Law::CoulombPositive, Law::CoulombNegative);
            assert!((coulomb - column(Law::Coulomb)).abs() < 1e-15);
        }
        let bell = |v: f64| column(Law::Stribeck, v, 0.0) / column(Law::Coulomb, v, 0.0);
        assert!((bell(0.1) - libm::exp(-1.0)).abs() < 1e-15);
        assert!(bell(1.0) < 1e-40);
    }
}
