//! The right-hand side of a row of the equations of motion.

/// The right-hand side of a row; joints count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RightHandSide {
    /// Zero: in a link row of a flexible joint the row contains all torques.
    Zero,
    /// The motor torque of a joint.
    MotorTorque(usize),
    /// The measured torque of a joint's spring.
    SpringTorque(usize),
    /// The motor torque of a joint minus the measured torque of its spring.
    MotorMinusSpring(usize),
}

impl RightHandSide {
    /// Returns the joints whose motor torque and spring torque it contains.
    #[inline]
    #[must_use]
    pub const fn torques(self) -> [Option<usize>; 2] {
        match self {
            Self::Zero => [None, None],
            Self::MotorTorque(joint) => [Some(joint), None],
            Self::SpringTorque(joint) => [None, Some(joint)],
            Self::MotorMinusSpring(joint) => [Some(joint), Some(joint)],
        }
    }

    /// Returns the value, N·m (N).
    ///
    /// - `motor`, `spring`: torques of motors and springs, measured, or filtered like the row,
    ///   \[n\], N·m (N).
    #[inline]
    #[must_use]
    pub fn of(self, motor: &[f64], spring: &[f64]) -> f64 {
        match self {
            Self::Zero => 0.0,
            Self::MotorTorque(joint) => motor[joint],
            Self::SpringTorque(joint) => spring[joint],
            Self::MotorMinusSpring(joint) => motor[joint] - spring[joint],
        }
    }
}
