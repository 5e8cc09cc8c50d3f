//! What an identification knows of an actuator besides its parameters.

/// A value with its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Known {
    pub(crate) value: f64,
    pub(crate) standard_error: Option<f64>,
}

/// Delay and noise of a joint's torque.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct JointEvidence {
    /// Delay of the record of the torque, s; `None` if no delay was estimated or given.
    pub(crate) delay: Option<Known>,
    /// Standard deviation of the torque that the model does not explain, N·m (N).
    pub(crate) torque_noise: Option<f64>,
}
