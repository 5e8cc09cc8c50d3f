//! The right-hand side of a row of the equations of motion.

/// The right-hand side of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RightHandSide {
    /// Zero: in a link row of a flexible joint the row contains all torques.
    Zero,
    /// The motor torque of a joint; joints count from 0.
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
