//! Kinds of parameter, their order in the vector theta, names and units.
//!
//! The order is that of the paper, for any number of joints `n`: link inertial parameters, then
//! rotor inertias, link viscous frictions, motor viscous frictions, stiffnesses, link Coulomb
//! frictions and motor Coulomb frictions. Parameters that the paper does not have follow. A joint
//! without a parameter is skipped.

use crate::chain::JointKind;
use crate::covariate::Covariate;
use crate::friction::{Family, Law, Scale};
use crate::presliding::ELEMENTS;

/// A side of the joint's spring.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// Link side: the link and its bearing.
    Link,
    /// Motor side: motor and gear, reduced to the output of the gear.
    Motor,
}

impl Side {
    /// Returns the prefix of parameter names: `link` or `motor`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Link => "link",
            Self::Motor => "motor",
        }
    }
}

/// The kind of a joint's parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum JointParameter {
    /// Rotor inertia, reduced to the output of the gear, kg·m² (kg).
    RotorInertia,
    /// Stiffness of the joint spring, N·m/rad (N/m).
    Stiffness,
    /// Cubic part of the spring's torque, N·m/rad³ (N/m³).
    CubicStiffness,
    /// Damping in parallel with the spring, N·m·s/rad (N·s/m).
    Damping,
    /// Torque of an element of the spring's hysteresis that slides, by the index of the element, N·m (N).
    Hysteresis(u8),
    /// Torque of the spring on the motor at equal readings of both encoders, N·m (N): minus the
    /// stiffness times the offset of the link's encoder.
    Preload,
    /// Friction on one side of the spring, by one law.
    Friction(Side, Law),
    /// Change of a friction parameter with a covariate: its law times the covariate minus the
    /// reference.
    Change(Side, Law, Covariate),
    /// Torque that the back-EMF of a voltage drive takes from the motor, over the motor's velocity
    /// after the gear, N·m·s/rad (N·s/m). Constants of the drive give its value.
    BackEmf,
    /// Reading of the joint torque sensor without torque of the spring, N·m (N). It belongs to the
    /// sensor, so it has no effect on the motion.
    TorqueOffset,
}

use JointParameter::{Change, Friction};
use Side::{Link, Motor};

impl JointParameter {
    /// All kinds, in the order of the vector theta: first those of the paper, then the other
    /// friction laws by family, then the other parameters of the spring, the back-EMF, the offset
    /// of the torque sensor and the changes of friction with covariates.
    pub const ALL: [Self; KINDS] = in_order();

    /// Returns the part of the name that follows the joint's: `stiffness` in `joint1.stiffness`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::RotorInertia => "rotor_inertia",
            Self::Stiffness => "stiffness",
            Self::CubicStiffness => "cubic_stiffness",
            Self::Damping => "spring_damping",
            Self::Hysteresis(at) => HYSTERESIS[at as usize],
            Self::Preload => "spring_preload",
            Self::BackEmf => "back_emf",
            Self::TorqueOffset => "joint_torque_offset",
            Friction(side, law) => law.names()[side as usize],
            Change(side, law, with) => law.names_of_changes()[side as usize][with as usize],
        }
    }

    /// Returns a description of the parameter: a noun phrase with a full stop.
    #[must_use]
    pub const fn about(self) -> &'static str {
        match self {
            Self::RotorInertia => "Rotor inertia at the output side.",
            Self::Stiffness => "Stiffness.",
            Self::CubicStiffness => "Cubic part of the spring's torque.",
            Self::Damping => "Damping in parallel with the spring.",
            Self::Hysteresis(_) => "Torque of an element of the spring's hysteresis that slides.",
            Self::Preload => {
                "Torque of the spring on the motor at equal readings of both encoders."
            }
            Self::BackEmf => "Back-EMF: torque of the drive per velocity.",
            Self::TorqueOffset => {
                "Reading of the joint torque sensor without torque of the spring."
            }
            Friction(_, law) => law.about(),
            Change(_, _, with) => with.about(),
        }
    }

    /// Returns the unit of the parameter at a revolute or prismatic joint.
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
            Self::Damping | Self::BackEmf if turns => "N·m·s/rad",
            Self::Damping | Self::BackEmf => "N·s/m",
            Self::Preload | Self::TorqueOffset | Self::Hysteresis(_) if turns => "N·m",
            Self::Preload | Self::TorqueOffset | Self::Hysteresis(_) => "N",
            Friction(_, law) => law.unit(kind),
            Change(_, law, with) => law.unit_of_change(with, kind),
        }
    }

    /// Returns whether the parameter is one of several coefficients of a curve, which means little by itself.
    #[must_use]
    pub const fn is_of_curve(self) -> bool {
        match self {
            Self::Hysteresis(_) => true,
            Friction(_, law) | Change(_, law, _) => matches!(law.scale(), Scale::Presliding),
            Self::RotorInertia
            | Self::Stiffness
            | Self::CubicStiffness
            | Self::Damping
            | Self::Preload
            | Self::BackEmf
            | Self::TorqueOffset => false,
        }
    }

    /// Returns whether the parameter, if positive, only dissipates energy.
    #[must_use]
    pub const fn is_friction(self) -> bool {
        match self {
            Self::Damping | Self::Hysteresis(_) | Self::BackEmf => true,
            Friction(_, law) => law.takes_energy(),
            Self::RotorInertia
            | Self::Stiffness
            | Self::CubicStiffness
            | Self::Preload
            | Self::TorqueOffset
            | Change(..) => false,
        }
    }

    /// Returns whether the parameter gives a part of the spring's torque.
    #[must_use]
    pub const fn is_of_spring(self) -> bool {
        match self {
            Self::Stiffness
            | Self::CubicStiffness
            | Self::Damping
            | Self::Hysteresis(_)
            | Self::Preload => true,
            Self::RotorInertia | Self::BackEmf | Self::TorqueOffset | Friction(..) | Change(..) => {
                false
            }
        }
    }

    /// Returns whether no robot can exist without a positive value: rotor inertia and stiffness.
    #[must_use]
    pub const fn is_vital(self) -> bool {
        match self {
            Self::RotorInertia | Self::Stiffness => true,
            Self::CubicStiffness
            | Self::Damping
            | Self::Hysteresis(_)
            | Self::Preload
            | Self::BackEmf
            | Self::TorqueOffset
            | Friction(..)
            | Change(..) => false,
        }
    }
}

/// Names of the parameters of hysteresis.
const HYSTERESIS: [&str; ELEMENTS] = [
    "spring_hysteresis_1",
    "spring_hysteresis_2",
    "spring_hysteresis_3",
    "spring_hysteresis_4",
    "spring_hysteresis_5",
    "spring_hysteresis_6",
];

/// Kinds of the paper, which come first.
const PAPER: [JointParameter; 6] = [
    JointParameter::RotorInertia,
    Friction(Link, Law::Viscous),
    Friction(Motor, Law::Viscous),
    JointParameter::Stiffness,
    Friction(Link, Law::Coulomb),
    Friction(Motor, Law::Coulomb),
];

/// Parameters of the spring except the stiffness, of the drive and of the torque sensor, which come
/// last.
const LAST: [JointParameter; 5 + ELEMENTS] = [
    JointParameter::Damping,
    JointParameter::CubicStiffness,
    JointParameter::Hysteresis(0),
    JointParameter::Hysteresis(1),
    JointParameter::Hysteresis(2),
    JointParameter::Hysteresis(3),
    JointParameter::Hysteresis(4),
    JointParameter::Hysteresis(5),
    JointParameter::Preload,
    JointParameter::BackEmf,
    JointParameter::TorqueOffset,
];

const KINDS: usize = {
    let (mut laws, mut family) = (0, 0);
    while family < Family::ALL.len() {
        laws += Family::ALL[family].laws().len();
        family += 1;
    }
    // Rotor inertia and stiffness, and each law and its changes with covariates on both sides.
    2 + 2 * laws * (1 + Covariate::COUNT) + LAST.len()
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
            // The laws of the paper are in `PAPER` already.
            if !matches!(law, Law::Viscous | Law::Coulomb) {
                all[count] = Friction(side, law);
                count += 1;
            }
            i += 1;
        }
        family += 1;
    }
    let mut i = 0;
    while i < LAST.len() {
        all[count + i] = LAST[i];
        i += 1;
    }
    // The changes with covariates follow, each in the order of the laws.
    count += LAST.len();
    let laws = count;
    let mut with = 0;
    while with < Covariate::COUNT {
        let mut i = 0;
        while i < laws {
            if let Friction(side, law) = all[i] {
                all[count] = Change(side, law, Covariate::ALL[with]);
                count += 1;
            }
            i += 1;
        }
        with += 1;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_is_that_of_the_paper_then_of_the_families_then_of_the_spring() {
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
            "link_quadratic",
            "motor_quadratic",
            "link_load",
            "motor_load",
            "link_presliding_1",
            "link_presliding_2",
            "link_presliding_3",
            "link_presliding_4",
            "link_presliding_5",
            "link_presliding_6",
            "motor_presliding_1",
            "motor_presliding_2",
            "motor_presliding_3",
            "motor_presliding_4",
            "motor_presliding_5",
            "motor_presliding_6",
            "spring_damping",
            "cubic_stiffness",
            "spring_hysteresis_1",
            "spring_hysteresis_2",
            "spring_hysteresis_3",
            "spring_hysteresis_4",
            "spring_hysteresis_5",
            "spring_hysteresis_6",
            "spring_preload",
            "back_emf",
            "joint_torque_offset",
        ];
        // New laws come before the parameters of the spring.
        let known = JointParameter::ALL.map(JointParameter::name);
        let (others, changes) = known.split_at(order.len());
        assert_eq!(others, order);
        assert_eq!(changes[0], "link_viscous_per_k");
        // All but rotor inertia, stiffness and the last ones are friction.
        let frictions = order.len() - 2 - LAST.len();
        assert_eq!(changes.len(), Covariate::COUNT * frictions);
        assert_eq!(changes[frictions], "link_viscous_per_s");
    }

    #[test]
    fn names_are_unique() {
        for (i, kind) in JointParameter::ALL.iter().enumerate() {
            let others = &JointParameter::ALL[..i];
            assert!(others.iter().all(|other| other.name() != kind.name()));
        }
    }
}
