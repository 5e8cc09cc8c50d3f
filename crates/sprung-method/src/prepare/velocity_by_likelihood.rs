//! Stribeck velocities by likelihood.

/// A Stribeck velocity that the likelihood of a log gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct VelocityByLikelihood {
    /// Index of the joint.
    pub joint: usize,
    /// Velocity, rad/s (m/s).
    pub velocity: f64,
    /// Standard error, rad/s (m/s).
    pub standard_error: f64,
}
