//! Kinds of parameter, their order in the vector theta, names and units.
//!
//! The order is that of the paper, for any number of joints `n`: link inertial
//! parameters, then rotor inertias, link viscous frictions, motor viscous
//! frictions, stiffnesses, link Coulomb frictions and motor Coulomb frictions;
//! what goes beyond the paper stands behind. A joint that lacks a parameter is
//! passed over.

use crate::chain::JointKind;
use crate::friction::Law;

/// A side of the joint's spring.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// The link and its bearing.
    Link,
    /// Motor and gear, seen at the output side.
    Motor,
}

/// What a parameter of a joint means.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum JointParameter {
    /// Rotor inertia seen at the output side, kg·m² (kg).
    RotorInertia,
    /// Stiffness of the joint spring, N·m/rad (N/m).
    Stiffness,
    /// Cubic part of the spring's torque, N·m/rad³ (N/m³).
    CubicStiffness,
    /// Damping in parallel with the spring, N·m·s/rad (N·s/m).
    Damping,
    /// Torque of the spring on the motor where the two encoders agree, N·m (N):
    /// the stiffness times minus the constant by which the link's reads higher.
    Preload,
    /// Friction on a side of the spring.
    Friction(Side, Law),
}

use JointParameter::Friction;
use Side::{Link, Motor};

impl JointParameter {
    /// All kinds, in the order of the vector theta.
    pub const ALL: [Self; 21] = [
        Self::RotorInertia,
        Friction(Link, Law::Viscous),
        Friction(Motor, Law::Viscous),
        Self::Stiffness,
        Friction(Link, Law::Coulomb),
        Friction(Motor, Law::Coulomb),
        Friction(Link, Law::Offset),
        Friction(Motor, Law::Offset),
        Friction(Link, Law::ViscousPositive),
        Friction(Link, Law::ViscousNegative),
        Friction(Motor, Law::ViscousPositive),
        Friction(Motor, Law::ViscousNegative),
        Friction(Link, Law::CoulombPositive),
        Friction(Link, Law::CoulombNegative),
        Friction(Motor, Law::CoulombPositive),
        Friction(Motor, Law::CoulombNegative),
        Friction(Link, Law::Stribeck),
        Friction(Motor, Law::Stribeck),
        Self::Damping,
        Self::CubicStiffness,
        Self::Preload,
    ];

    /// Returns the name after the joint's, as in `joint1.stiffness`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::RotorInertia => "rotor_inertia",
            Self::Stiffness => "stiffness",
            Self::CubicStiffness => "cubic_stiffness",
            Self::Damping => "spring_damping",
            Self::Preload => "spring_preload",
            Friction(Link, law) => match law {
                Law::Viscous => "link_viscous",
                Law::Coulomb => "link_coulomb",
                Law::Offset => "link_offset",
                Law::ViscousPositive => "link_viscous_positive",
                Law::ViscousNegative => "link_viscous_negative",
                Law::CoulombPositive => "link_coulomb_positive",
                Law::CoulombNegative => "link_coulomb_negative",
                Law::Stribeck => "link_stribeck",
            },
            Friction(Motor, law) => match law {
                Law::Viscous => "motor_viscous",
                Law::Coulomb => "motor_coulomb",
                Law::Offset => "motor_offset",
                Law::ViscousPositive => "motor_viscous_positive",
                Law::ViscousNegative => "motor_viscous_negative",
                Law::CoulombPositive => "motor_coulomb_positive",
                Law::CoulombNegative => "motor_coulomb_negative",
                Law::Stribeck => "motor_stribeck",
            },
        }
    }

    /// Returns the unit, at a joint that turns or slides.
    #[must_use]
    pub const fn unit(self, kind: JointKind) -> &'static str {
        let turns = matches!(kind, JointKind::Revolute);
        match self {
            Self::RotorInertia if turns => "kg·m²",
            Self::RotorInertia => "kg",
            Self::Stiffness if turns => "N·m/rad",
            Self::Stiffness => "N/m",
            Self::CubicStiffness if turns => "N·m/rad³",
            Self::CubicStiffness => "N/m³",
            Self::Damping
            | Friction(_, Law::Viscous | Law::ViscousPositive | Law::ViscousNegative) => {
                if turns {
                    "N·m·s/rad"
                } else {
                    "N·s/m"
                }
            }
            Self::Preload | Friction(..) => {
                if turns {
                    "N·m"
                } else {
                    "N"
                }
            }
        }
    }

    /// Returns whether the parameter takes energy out of the robot.
    #[must_use]
    pub const fn is_friction(self) -> bool {
        match self {
            Self::Damping => true,
            Friction(_, law) => !matches!(law, Law::Offset | Law::Stribeck),
            _ => false,
        }
    }

    /// Returns whether a robot is not one without it: an inertia or a
    /// stiffness.
    #[must_use]
    pub const fn is_vital(self) -> bool {
        matches!(self, Self::RotorInertia | Self::Stiffness)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_is_that_of_the_paper() {
        let paper = [
            "rotor_inertia",
            "link_viscous",
            "motor_viscous",
            "stiffness",
            "link_coulomb",
            "motor_coulomb",
        ];
        for (kind, name) in JointParameter::ALL.iter().zip(paper) {
            assert_eq!(kind.name(), name);
        }
    }

    #[test]
    fn names_are_unique() {
        for (i, kind) in JointParameter::ALL.iter().enumerate() {
            let others = &JointParameter::ALL[..i];
            assert!(others.iter().all(|other| other.name() != kind.name()));
        }
    }
}
