//! Kinds of parameter, their order in the vector theta, names and units.
//!
//! The order is that of the paper, for any number of joints `n`:
//! link inertial parameters, then rotor inertias, link viscous frictions,
//! motor viscous frictions, stiffnesses, link Coulomb frictions and motor
//! Coulomb frictions, `n` of each.

/// What a parameter of a joint means.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum JointParameter {
    /// Rotor inertia seen at the output side, kg·m².
    RotorInertia,
    /// Viscous friction of the link bearing, N·m·s/rad.
    LinkViscous,
    /// Viscous friction of motor and gear at the output side, N·m·s/rad.
    MotorViscous,
    /// Stiffness of the joint spring, N·m/rad.
    Stiffness,
    /// Coulomb friction of the link bearing, N·m.
    LinkCoulomb,
    /// Coulomb friction of motor and gear at the output side, N·m.
    MotorCoulomb,
}

impl JointParameter {
    /// All kinds, in the order of the vector theta.
    pub const ALL: [Self; 6] = [
        Self::RotorInertia,
        Self::LinkViscous,
        Self::MotorViscous,
        Self::Stiffness,
        Self::LinkCoulomb,
        Self::MotorCoulomb,
    ];

    /// Returns the name after the joint's, as in `joint1.stiffness`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::RotorInertia => "rotor_inertia",
            Self::LinkViscous => "link_viscous",
            Self::MotorViscous => "motor_viscous",
            Self::Stiffness => "stiffness",
            Self::LinkCoulomb => "link_coulomb",
            Self::MotorCoulomb => "motor_coulomb",
        }
    }

    /// Returns the unit.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::RotorInertia => "kg·m²",
            Self::LinkViscous | Self::MotorViscous => "N·m·s/rad",
            Self::Stiffness => "N·m/rad",
            Self::LinkCoulomb | Self::MotorCoulomb => "N·m",
        }
    }

    /// Returns whether the parameter takes energy out of the robot.
    #[must_use]
    pub const fn is_friction(self) -> bool {
        !matches!(self, Self::RotorInertia | Self::Stiffness)
    }

    const fn position(self) -> usize {
        match self {
            Self::RotorInertia => 0,
            Self::LinkViscous => 1,
            Self::MotorViscous => 2,
            Self::Stiffness => 3,
            Self::LinkCoulomb => 4,
            Self::MotorCoulomb => 5,
        }
    }
}

/// Where each parameter stands in the vector theta.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    joints: usize,
    inertial: usize,
}

impl Layout {
    /// Returns the layout of an arm with `joints` joints and `inertial` link
    /// inertial parameters.
    #[must_use]
    pub const fn new(joints: usize, inertial: usize) -> Self {
        Self { joints, inertial }
    }

    /// Returns the number of joints `n`.
    #[must_use]
    pub const fn joints(&self) -> usize {
        self.joints
    }

    /// Returns the number of link inertial parameters, which stand first.
    #[must_use]
    pub const fn inertial(&self) -> usize {
        self.inertial
    }

    /// Returns the number of parameters `p`.
    #[must_use]
    pub const fn parameters(&self) -> usize {
        self.inertial + JointParameter::ALL.len() * self.joints
    }

    /// Returns the index in theta of a parameter of a joint, `joint` from 0.
    #[must_use]
    pub const fn index(&self, kind: JointParameter, joint: usize) -> usize {
        self.inertial + kind.position() * self.joints + joint
    }

    /// Returns what stands at an index of theta: a joint's parameter, or
    /// nothing for a link inertial parameter.
    #[must_use]
    pub fn joint_parameter(&self, index: usize) -> Option<(JointParameter, usize)> {
        let offset = index.checked_sub(self.inertial)?;
        let kind = *JointParameter::ALL.get(offset / self.joints)?;
        Some((kind, offset % self.joints))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_is_that_of_the_paper() {
        let layout = Layout::new(2, 3);
        assert_eq!(layout.parameters(), 15);
        // theta4 is the rotor inertia of joint 1, theta11 the stiffness of joint 2.
        assert_eq!(layout.index(JointParameter::RotorInertia, 0), 3);
        assert_eq!(layout.index(JointParameter::Stiffness, 1), 10);
        assert_eq!(layout.index(JointParameter::MotorCoulomb, 1), 14);
    }

    #[test]
    fn index_and_joint_parameter_are_inverse() {
        let layout = Layout::new(7, 43);
        for kind in JointParameter::ALL {
            for joint in 0..7 {
                let index = layout.index(kind, joint);
                assert_eq!(layout.joint_parameter(index), Some((kind, joint)));
            }
        }
        assert_eq!(layout.joint_parameter(42), None);
        assert_eq!(layout.joint_parameter(85), None);
    }
}
