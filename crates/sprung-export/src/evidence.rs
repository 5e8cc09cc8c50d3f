//! Values of an actuator beside its parameters.

/// A value with its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// Value.
    pub value: f64,
    /// Standard error; `None` if it is not known.
    pub standard_error: Option<f64>,
}

/// Delay and noise of a joint's torque.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointEvidence {
    /// Delay of the record of the torque, s; `None` if no delay was estimated or given.
    pub delay: Option<Known>,
    /// Standard deviation of the torque that the model does not explain, N·m (N).
    pub torque_noise: Option<f64>,
}
