//! Kinds of parameter, their order in the vector theta, names and units.
//!
//! The order is that of the paper, for any number of joints `n`: link inertial
//! parameters, then rotor inertias, link viscous frictions, motor viscous
//! frictions, stiffnesses, link Coulomb frictions and motor Coulomb frictions;
//! what goes beyond the paper stands behind. A joint that lacks a parameter is
//! passed over.

use crate::chain::JointKind;
use crate::friction::{Family, Law};

/// A side of the joint's spring.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// The link and its bearing.
    Link,
    /// Motor and gear, seen at the output side.
    Motor,
}

impl Side {
    /// Returns the word for it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Link => "link",
            Self::Motor => "motor",
        }
    }
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
    /// All kinds, in the order of the vector theta: the paper's, the other
    /// friction laws family by family, what springs have beyond stiffness.
    pub const ALL: [Self; KINDS] = in_order();

    /// Returns the name after the joint's, as in `joint1.stiffness`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::RotorInertia => "rotor_inertia",
            Self::Stiffness => "stiffness",
            Self::CubicStiffness => "cubic_stiffness",
            Self::Damping => "spring_damping",
            Self::Preload => "spring_preload",
            Friction(side, law) => law.names()[side as usize],
        }
    }

    /// Returns what the parameter is, as a noun with a full stop.
    #[must_use]
    pub const fn about(self) -> &'static str {
        match self {
            Self::RotorInertia => "Rotor inertia at the output side.",
            Self::Stiffness => "Stiffness.",
            Self::CubicStiffness => "Cubic part of the spring's torque.",
            Self::Damping => "Damping in parallel with the spring.",
            Self::Preload => "Torque of the spring on the motor where the encoders agree.",
            Friction(_, law) => law.about(),
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
            Self::Damping if turns => "N·m·s/rad",
            Self::Damping => "N·s/m",
            Self::Preload if turns => "N·m",
            Self::Preload => "N",
            Friction(_, law) => law.unit(kind),
        }
    }

    /// Returns whether the parameter takes energy out of the robot.
    #[must_use]
    pub const fn is_friction(self) -> bool {
        match self {
            Self::Damping => true,
            Friction(_, law) => law.takes_energy(),
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

/// The paper's kinds, which come first.
const PAPER: [JointParameter; 6] = [
    JointParameter::RotorInertia,
    Friction(Link, Law::Viscous),
    Friction(Motor, Law::Viscous),
    JointParameter::Stiffness,
    Friction(Link, Law::Coulomb),
    Friction(Motor, Law::Coulomb),
];

/// What springs have beyond stiffness, which comes last.
const OF_SPRINGS: [JointParameter; 3] = [
    JointParameter::Damping,
    JointParameter::CubicStiffness,
    JointParameter::Preload,
];

const KINDS: usize = {
    let (mut laws, mut family) = (0, 0);
    while family < Family::ALL.len() {
        laws += Family::ALL[family].laws().len();
        family += 1;
    }
    // Rotor inertia and stiffness stand beside the laws on either side.
    2 + 2 * laws + OF_SPRINGS.len()
};

const fn in_order() -> [JointParameter; KINDS] {
    let mut all = [JointParameter::RotorInertia; KINDS];
    let mut count = 0;
    while count < PAPER.len() {
        all[count] = PAPER[count];
        count += 1;
    }
    let mut family = 0;
    while family < Family::ALL.len() {
        let laws = Family::ALL[family].laws();
        let mut i = 0;
        while i < 2 * laws.len() {
            let side = if i < laws.len() { Link } else { Motor };
            let law = laws[i % laws.len()];
            // The paper's stand in its order.
            if !matches!(law, Law::Viscous | Law::Coulomb) {
                all[count] = Friction(side, law);
                count += 1;
            }
            i += 1;
        }
        family += 1;
    }
    let mut i = 0;
    while i < OF_SPRINGS.len() {
        all[count + i] = OF_SPRINGS[i];
        i += 1;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_is_that_of_the_paper_and_then_as_files_have_it() {
        let order = [
            "rotor_inertia",
            "link_viscous",
            "motor_viscous",
            "stiffness",
            "link_coulomb",
            "motor_coulomb",
            "link_offset",
            "motor_offset",
            "link_viscous_positive",
            "link_viscous_negative",
            "motor_viscous_positive",
            "motor_viscous_negative",
            "link_coulomb_positive",
            "link_coulomb_negative",
            "motor_coulomb_positive",
            "motor_coulomb_negative",
            "link_stribeck",
            "motor_stribeck",
            "spring_damping",
            "cubic_stiffness",
            "spring_preload",
        ];
        // A law that is added stands before the springs'.
        let known = JointParameter::ALL.map(JointParameter::name);
        let of_springs = order.len() - OF_SPRINGS.len();
        assert_eq!(known[..of_springs], order[..of_springs]);
        assert!(known.ends_with(&order[of_springs..]));
    }

    #[test]
    fn names_are_unique() {
        for (i, kind) in JointParameter::ALL.iter().enumerate() {
            let others = &JointParameter::ALL[..i];
            assert!(others.iter().all(|other| other.name() != kind.name()));
        }
    }
}
