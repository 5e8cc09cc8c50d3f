//! Friction laws: each law is one row of a table and one formula.
//!
//! Every law is linear in its parameter, so it is a column of the regressor: the friction torque is
//! the column times the parameter. [`Shape`] contains the values in which a law is not linear. The
//! formulas are written over [`Scalar`], so regression, simulation and derivatives use the same
//! formula.

use crate::chain::JointKind;
use crate::covariate::{Covariate, names_of_changes, units_of_changes};
use crate::presliding::ELEMENTS;
use crate::scalar::Scalar;

/// Quantities on which a friction law depends. A law that needs another quantity needs another field
/// here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditions<S = f64> {
    /// Velocity of the side that the law acts on, rad/s (m/s).
    pub velocity: S,
    /// Deflection of the spring, rad (m). It is zero in a rigid joint.
    pub deflection: S,
    /// Elements of presliding friction, from −1 to 1. They follow from the motion until now, so they
    /// do not depend on the velocity. `None` where the motion until now is not known: then all
    /// elements slide, and their friction is Coulomb friction.
    pub presliding: Option<[S; ELEMENTS]>,
}

impl Conditions {
    /// Returns the conditions of a motion in which all elements of presliding friction slide.
    #[must_use]
    pub const fn sliding(velocity: f64, deflection: f64) -> Self {
        Self {
            velocity,
            deflection,
            presliding: None,
        }
    }
}

/// Values in which the laws are not linear. They are fixed while the parameters are estimated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// beta of `tanh(beta v)`, s/rad (s/m), positive.
    pub sharpness: f64,
    /// Velocity at which the Stribeck friction is 1/e of its largest value, rad/s (m/s), positive.
    pub stribeck_velocity: f64,
    /// Width of the widest element of presliding friction, rad (m), positive; 0.2 s times the root
    /// mean square of the joint's velocity is a good choice.
    pub presliding_width: f64,
    /// Width of the widest element of a spring's hysteresis, rad (m), positive; twice the root mean square
    /// of the deflection is a good choice.
    pub hysteresis_width: f64,
    /// Half of the play in series with a spring, rad (m); zero without play.
    pub play: f64,
    /// Deflection in the middle of the play, rad (m).
    pub play_centre: f64,
}

impl Shape {
    /// Returns the value that scales laws.
    #[must_use]
    pub const fn get(&self, scale: Scale) -> f64 {
        match scale {
            Scale::Sharpness => self.sharpness,
            Scale::Stribeck => self.stribeck_velocity,
            Scale::Presliding => self.presliding_width,
        }
    }

    /// Replaces the value that scales laws.
    pub const fn set(&mut self, scale: Scale, value: f64) {
        *match scale {
            Scale::Sharpness => &mut self.sharpness,
            Scale::Stribeck => &mut self.stribeck_velocity,
            Scale::Presliding => &mut self.presliding_width,
        } = value;
    }
}

/// Unit of the parameter of a law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unit {
    Torque,
    TorquePerVelocity,
    TorquePerSquaredVelocity,
    TorquePerDeflection,
}

/// Whether the parameter of a law can be negative.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Power {
    /// It cannot: with a positive parameter the law takes energy out of the robot, with a negative
    /// one it adds energy.
    Taken,
    /// It can, because the law is not friction by itself but occurs together with friction.
    Either,
}

/// The value of [`Shape`] that scales a law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// No scale but the sharpness of the transition at zero velocity.
    Sharpness,
    /// The Stribeck velocity.
    Stribeck,
    /// The width of presliding friction.
    Presliding,
}

/// Declares the laws, one row each. Each family has a word, by which a description chooses its
/// laws.
macro_rules! laws {
    ($($(#[$about:meta])* $family:ident $word:literal: {
        $(#[doc = $doc:literal] $law:ident $name:literal, $unit:ident, $power:ident, $scale:ident;)*
    })*) => {
        /// A friction law with one parameter.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Law {
            $($(#[doc = $doc] $law,)*)*
        }

        /// Laws that a description chooses together, by one word.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Family {
            $($(#[$about])* $family,)*
        }

        impl Family {
            /// All families, in the order of their parameters.
            pub const ALL: &[Self] = &[$(Self::$family),*];

            /// Returns the word by which a description chooses the family.
            #[must_use]
            pub const fn word(self) -> &'static str {
                match self {
                    $(Self::$family => $word,)*
                }
            }

            /// Returns the laws of the family.
            #[must_use]
            pub const fn laws(self) -> &'static [Law] {
                match self {
                    $(Self::$family => &[$(Law::$law),*],)*
                }
            }
        }

        impl Law {
            /// Returns a description of the law: a noun phrase with a full stop.
            #[must_use]
            pub const fn about(self) -> &'static str {
                match self {
                    $($(Self::$law => $doc,)*)*
                }
            }

            /// Returns the names of the parameter on the link side and on the motor side.
            pub(crate) const fn names(self) -> [&'static str; 2] {
                match self {
                    $($(Self::$law => [concat!("link_", $name), concat!("motor_", $name)],)*)*
                }
            }

            /// Returns the names of the parameter's changes with all covariates, on both sides.
            pub(crate) const fn names_of_changes(self) -> [[&'static str; Covariate::COUNT]; 2] {
                match self {
                    $($(Self::$law => [
                        names_of_changes!("link_", $name),
                        names_of_changes!("motor_", $name),
                    ],)*)*
                }
            }

            const fn measured_in(self) -> Unit {
                match self {
                    $($(Self::$law => Unit::$unit,)*)*
                }
            }

            /// Returns the value of [`Shape`] that scales its velocity.
            #[must_use]
            pub const fn scale(self) -> Scale {
                match self {
                    $($(Self::$law => Scale::$scale,)*)*
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
    /// Friction proportional to the velocity.
    Viscous "viscous": {
        /// Viscous friction.
        Viscous "viscous", TorquePerVelocity, Taken, Sharpness;
    }
    /// Friction of constant magnitude against the motion.
    Coulomb "coulomb": {
        /// Coulomb friction.
        Coulomb "coulomb", Torque, Taken, Sharpness;
    }
    /// A constant torque, for example from the zero error of a current sensor.
    Offset "offset": {
        /// Constant torque.
        Offset "offset", Torque, Either, Sharpness;
    }
    /// Viscous friction with one parameter for each direction.
    ViscousAsymmetric "viscous-asymmetric": {
        /// Viscous friction of positive velocities.
        ViscousPositive "viscous_positive", TorquePerVelocity, Taken, Sharpness;
        /// Viscous friction of negative velocities.
        ViscousNegative "viscous_negative", TorquePerVelocity, Taken, Sharpness;
    }
    /// Coulomb friction with one parameter for each direction.
    CoulombAsymmetric "coulomb-asymmetric": {
        /// Coulomb friction of positive velocities.
        CoulombPositive "coulomb_positive", Torque, Taken, Sharpness;
        /// Coulomb friction of negative velocities.
        CoulombNegative "coulomb_negative", Torque, Taken, Sharpness;
    }
    /// Additional friction at low velocity.
    Stribeck "stribeck": {
        /// Stribeck friction.
        Stribeck "stribeck", Torque, Either, Stribeck;
    }
    /// Friction proportional to the square of the velocity. It is negative where the friction grows
    /// less than linearly with the velocity.
    Quadratic "quadratic": {
        /// Quadratic friction.
        Quadratic "quadratic", TorquePerSquaredVelocity, Either, Sharpness;
    }
    /// Friction of a gear that transmits a load: proportional to the magnitude of the deflection of
    /// a flexible joint.
    Load "load": {
        /// Load-dependent friction: its coefficient times the stiffness.
        Load "load", TorquePerDeflection, Taken, Sharpness;
    }
    /// Friction that grows with the travel after a reversal until it slides: elastic elements of six
    /// widths.
    Presliding "presliding": {
        /// Presliding friction of element 1.
        Presliding1 "presliding_1", Torque, Taken, Presliding;
        /// Presliding friction of element 2.
        Presliding2 "presliding_2", Torque, Taken, Presliding;
        /// Presliding friction of element 3.
        Presliding3 "presliding_3", Torque, Taken, Presliding;
        /// Presliding friction of element 4.
        Presliding4 "presliding_4", Torque, Taken, Presliding;
        /// Presliding friction of element 5.
        Presliding5 "presliding_5", Torque, Taken, Presliding;
        /// Presliding friction of element 6.
        Presliding6 "presliding_6", Torque, Taken, Presliding;
    }
}

/// Formula of a law at given conditions.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Form<S> {
    /// The column itself, of a law that is smooth at zero velocity.
    Smooth(S),
    /// Factor of `tanh(beta v)` in the column, of a law that jumps at zero velocity.
    Jump(S),
}

impl Law {
    /// Returns all laws, in the order of their parameters.
    pub fn all() -> impl Iterator<Item = Self> {
        Family::ALL.iter().flat_map(|family| family.laws()).copied()
    }

    /// Returns the formula of the law. This is its only definition.
    ///
    /// # Source
    ///
    /// Eq. (1), `F_v`, and eq. (2), `tanh(beta v)`. The paper's `Y_b4` prints
    /// positions where velocities belong. The friction of a gear under load is `c |K e| tanh(beta v)`
    /// with the deflection `e`; its parameter here is `c K`, so that the column does not contain an
    /// estimated stiffness.
    fn form<S: Scalar>(self, at: &Conditions<S>, shape: &Shape) -> Form<S> {
        match self {
            Self::Viscous => Form::Smooth(at.velocity),
            Self::ViscousPositive => Form::Smooth(at.velocity * at.velocity.is_forward()),
            Self::ViscousNegative => Form::Smooth(at.velocity * (-at.velocity).is_forward()),
            Self::Offset => Form::Smooth(S::constant(1.0)),
            Self::Coulomb => Form::Jump(S::constant(1.0)),
            Self::CoulombPositive => Form::Jump(at.velocity.is_forward()),
            Self::CoulombNegative => Form::Jump((-at.velocity).is_forward()),
            Self::Stribeck => Form::Jump(stribeck_fraction(at, shape)),
            Self::Quadratic => Form::Smooth(at.velocity * at.velocity.abs()),
            Self::Load => Form::Jump(at.deflection.abs()),
            Self::Presliding1 => element(at, 0),
            Self::Presliding2 => element(at, 1),
            Self::Presliding3 => element(at, 2),
            Self::Presliding4 => element(at, 3),
            Self::Presliding5 => element(at, 4),
            Self::Presliding6 => element(at, 5),
        }
    }

    /// Returns the column of the law. The friction torque is the column times the parameter.
    ///
    /// A law for one direction begins at zero velocity. Its derivative there is the one-sided
    /// derivative on the side where the law acts.
    #[must_use]
    pub fn column<S: Scalar>(self, at: &Conditions<S>, shape: &Shape) -> S {
        match self.form(at, shape) {
            Form::Smooth(column) => column,
            Form::Jump(height) => (at.velocity * shape.sharpness).tanh() * height,
        }
    }

    /// Returns the factor of `tanh(beta v)` in the column of a law that jumps at zero velocity;
    /// `None` for a smooth law.
    #[must_use]
    pub fn jump(self, at: &Conditions, shape: &Shape) -> Option<f64> {
        match self.form(at, shape) {
            Form::Smooth(_) => None,
            Form::Jump(height) => Some(height),
        }
    }

    /// Returns the derivative of the column by the logarithm of the sharpness or of the Stribeck velocity; zero
    /// for a law that does not contain it. The width of presliding friction is not estimated.
    #[must_use]
    pub fn by_log(self, of: Scale, at: &Conditions, shape: &Shape) -> f64 {
        match (of, self.scale()) {
            (Scale::Sharpness, _) => self.jump(at, shape).map_or(0.0, |height| {
                let argument = at.velocity * shape.sharpness;
                let transition = Scalar::tanh(argument);
                height * argument * (1.0 - transition * transition)
            }),
            (Scale::Stribeck, Scale::Stribeck) => {
                let part = at.velocity / shape.stribeck_velocity;
                2.0 * part * part * self.column(at, shape)
            }
            (Scale::Stribeck | Scale::Presliding, _) => 0.0,
        }
    }

    /// Returns the unit of the parameter at a revolute or prismatic joint.
    #[must_use]
    pub const fn unit(self, kind: JointKind) -> &'static str {
        match (self.measured_in(), kind) {
            (Unit::Torque, JointKind::Revolute) => "N·m",
            (Unit::Torque, JointKind::Prismatic) => "N",
            (Unit::TorquePerVelocity, JointKind::Revolute) => "N·m·s/rad",
            (Unit::TorquePerVelocity, JointKind::Prismatic) => "N·s/m",
            (Unit::TorquePerSquaredVelocity, JointKind::Revolute) => "N·m·s²/rad²",
            (Unit::TorquePerSquaredVelocity, JointKind::Prismatic) => "N·s²/m²",
            (Unit::TorquePerDeflection, JointKind::Revolute) => "N·m/rad",
            (Unit::TorquePerDeflection, JointKind::Prismatic) => "N/m",
        }
    }

    /// Returns the unit of the parameter's change with a covariate at a revolute or prismatic joint.
    #[must_use]
    pub const fn unit_of_change(self, covariate: Covariate, kind: JointKind) -> &'static str {
        let units = match (self.measured_in(), kind) {
            (Unit::Torque, JointKind::Revolute) => units_of_changes!("N·m"),
            (Unit::Torque, JointKind::Prismatic) => units_of_changes!("N"),
            (Unit::TorquePerVelocity, JointKind::Revolute) => units_of_changes!("N·m·s/rad"),
            (Unit::TorquePerVelocity, JointKind::Prismatic) => units_of_changes!("N·s/m"),
            (Unit::TorquePerSquaredVelocity, JointKind::Revolute) => {
                units_of_changes!("N·m·s²/rad²")
            }
            (Unit::TorquePerSquaredVelocity, JointKind::Prismatic) => units_of_changes!("N·s²/m²"),
            (Unit::TorquePerDeflection, JointKind::Revolute) => units_of_changes!("N·m/rad"),
            (Unit::TorquePerDeflection, JointKind::Prismatic) => units_of_changes!("N/m"),
        };
        units[covariate as usize]
    }

    /// Returns whether the law is friction by itself: it takes energy out of the robot if its
    /// parameter is positive.
    #[must_use]
    pub const fn takes_energy(self) -> bool {
        matches!(self.power(), Power::Taken)
    }
}

/// Returns the formula of an element of presliding friction.
fn element<S: Scalar>(at: &Conditions<S>, index: usize) -> Form<S> {
    match at.presliding {
        Some(elements) => Form::Smooth(elements[index]),
        None => Form::Jump(S::constant(1.0)),
    }
}

/// Returns the Stribeck friction at a velocity, as a fraction of its largest value.
///
/// # Source
///
/// Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 1994:
/// `exp(-(v / v_s)²)`.
fn stribeck_fraction<S: Scalar>(at: &Conditions<S>, shape: &Shape) -> S {
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
        presliding_width: 0.5,
        hysteresis_width: 0.05,
        play: 0.01,
        play_centre: 0.002,
    };

    const ELEMENTS_AT: [f64; ELEMENTS] = [1.0, -1.0, 0.7, -0.4, 0.1, 0.0];

    /// Velocities on both sides of zero, near which every law is smooth.
    const VELOCITIES: [f64; 5] = [-0.7, -0.02, 0.003, 0.05, 0.4];

    fn column(law: Law, velocity: f64, deflection: f64) -> f64 {
        let at = Conditions {
            velocity,
            deflection,
            presliding: Some(ELEMENTS_AT),
        };
        law.column(&at, &SHAPE)
    }

    #[test]
    fn friction_dissipates_power_at_any_velocity() {
        for velocity in [-3.0, -1e-3, 0.0, 1e-3, 3.0] {
            // Presliding friction returns energy between reversal and sliding.
            let odd = |law: &Law| *law != Law::Offset && law.scale() != Scale::Presliding;
            for law in Law::all().filter(odd) {
                assert!(velocity * column(law, velocity, -0.4) >= 0.0, "{law:?}");
            }
            assert!(column(Law::Coulomb, velocity, 0.0).abs() <= 1.0);
        }
    }

    #[test]
    fn derivatives_are_limits_of_differences() {
        let h = 1e-6;
        // h² f‴ / 6: a tanh has the third derivative 2 s³ or less, with the sharpness s, its products with other laws
        // less than 3 s³.
        let limit = 0.5 * h * h * SHAPE.sharpness * SHAPE.sharpness * SHAPE.sharpness;
        for (velocity, deflection) in VELOCITIES.into_iter().zip([0.03, -0.4, 0.07, -0.005, 0.2]) {
            for law in Law::all() {
                let at = Conditions {
                    velocity: Dual::<2>::variable(velocity, 0),
                    deflection: Dual::variable(deflection, 1),
                    presliding: Some(ELEMENTS_AT.map(Dual::constant)),
                };
                let dual = law.column(&at, &SHAPE);
                let value = column(law, velocity, deflection);
                assert_eq!(dual.value.to_bits(), value.to_bits(), "{law:?}");
                let slope = |ahead: f64, behind: f64| (ahead - behind) / (2.0 * h);
                let by_velocity = slope(
                    column(law, velocity + h, deflection),
                    column(law, velocity - h, deflection),
                );
                let by_deflection = slope(
                    column(law, velocity, deflection + h),
                    column(law, velocity, deflection - h),
                );
                for (found, difference) in dual.partials.iter().zip([by_velocity, by_deflection]) {
                    assert!((found - difference).abs() < limit, "{law:?} at {velocity}");
                }
            }
        }
    }

    #[test]
    fn derivatives_by_the_shape_are_limits_of_differences() {
        let h = 1e-5_f64;
        for velocity in VELOCITIES {
            let at = Conditions {
                velocity,
                deflection: 0.05,
                presliding: Some(ELEMENTS_AT),
            };
            for law in Law::all() {
                for of in [Scale::Sharpness, Scale::Stribeck] {
                    let column = |change: f64| {
                        let mut shape = SHAPE;
                        shape.set(of, shape.get(of) * libm::exp(change));
                        law.column(&at, &shape)
                    };
                    let difference = (column(h) - column(-h)) / (2.0 * h);
                    let found = law.by_log(of, &at, &SHAPE);
                    assert!((found - difference).abs() < 1e-9, "{law:?} at {velocity}");
                }
            }
        }
    }

    #[test]
    fn the_table_names_the_value_that_scales_each_law() {
        let at = Conditions {
            velocity: 0.07,
            deflection: 0.05,
            presliding: Some(ELEMENTS_AT),
        };
        let wider = Shape {
            stribeck_velocity: 0.2,
            ..SHAPE
        };
        for law in Law::all() {
            let changes = (law.column(&at, &wider) - law.column(&at, &SHAPE)).abs() > 1e-6;
            assert_eq!(changes, law.scale() == Scale::Stribeck, "{law:?}");
        }
    }

    #[test]
    fn presliding_friction_without_a_known_motion_is_coulomb_friction() {
        for velocity in VELOCITIES {
            let at = Conditions::sliding(velocity, 0.0);
            for law in Family::Presliding.laws() {
                let coulomb = Law::Coulomb.column(&at, &SHAPE);
                assert!((law.column(&at, &SHAPE) - coulomb).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn laws_of_one_direction_have_their_one_sided_slope_at_zero() {
        let slope = |law: Law, velocity: f64| {
            let at = Conditions {
                velocity: Dual::<1>::variable(velocity, 0),
                deflection: Dual::constant(0.0),
                presliding: Some(ELEMENTS_AT.map(Dual::constant)),
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
    fn a_column_that_jumps_is_its_factor_times_tanh() {
        for velocity in VELOCITIES {
            let at = Conditions {
                velocity,
                deflection: 0.05,
                presliding: Some(ELEMENTS_AT),
            };
            for law in Law::all() {
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
    fn laws_of_both_directions_add_up_and_stribeck_friction_vanishes_at_speed() {
        for velocity in [-0.7, -0.02, 0.0, 0.005, 0.4] {
            let column = |law: Law| column(law, velocity, 0.0);
            let sum = |a: Law, b: Law| column(a) + column(b);
            let viscous = sum(Law::ViscousPositive, Law::ViscousNegative);
            assert!((viscous - column(Law::Viscous)).abs() < 1e-15);
            let coulomb = sum(Law::CoulombPositive, Law::CoulombNegative);
            assert!((coulomb - column(Law::Coulomb)).abs() < 1e-15);
        }
        let fraction = |v: f64| column(Law::Stribeck, v, 0.0) / column(Law::Coulomb, v, 0.0);
        assert!((fraction(0.1) - libm::exp(-1.0)).abs() < 1e-15);
        assert!(fraction(1.0) < 1e-40);
    }

    #[test]
    fn friction_under_load_grows_with_the_deflection_and_quadratic_friction_with_the_speed() {
        for velocity in VELOCITIES {
            let coulomb = column(Law::Coulomb, velocity, 0.0);
            for deflection in [-0.3, 0.0, 0.02] {
                let load = column(Law::Load, velocity, deflection);
                assert!((load - libm::fabs(deflection) * coulomb).abs() < 1e-15);
            }
            let quadratic = column(Law::Quadratic, velocity, 0.0);
            assert!((quadratic - velocity * libm::fabs(velocity)).abs() < 1e-15);
        }
    }
}
