//! The right-hand side of a row of the equations of motion.

/// What stands on the right-hand side of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RightHandSide {
    /// Nothing acts on the link of a flexible joint but what the row holds: zero.
    Zero,
    /// The motor torque of a joint, from 0.
    MotorTorque(usize),
}

impl RightHandSide {
    /// Returns the value, N·m (N).
    ///
    /// - `motor_torques`: measured, or filtered like the row, \[n\], N·m (N).
    #[must_use]
    pub fn of(self, motor_torques: &[f64]) -> f64 {
        match self {
            Self::Zero => 0.0,
            Self::MotorTorque(joint) => motor_torques[joint],
        }
    }
}
