//! Sizes that several tests share.

/// Relevant relative change: with such an error of the model, feedforward leaves a tenth of the torque to feedback.
pub(in crate::estimate) const LARGE_SHARE: f64 = 0.1;

/// Relative change that is reported although it is not yet relevant: half of the relevant one.
pub(in crate::estimate) const SMALL_SHARE: f64 = 0.05;

/// Relative standard error of an unknown parameter: its 95 % confidence interval reaches from zero to twice the value.
pub(in crate::estimate) const UNKNOWN_RELATIVE_ERROR: f64 = 0.5;

/// Argument of `tanh(beta v)` at which Coulomb friction has reached its value: `tanh(2) = 0.964`. At smaller ones
/// friction still reverses, and masks laws that depend on the velocity.
pub(in crate::estimate) const SATURATED_ARGUMENT: f64 = 2.0;

/// Irrelevant relative change: a tenth of the relevant one.
pub(in crate::estimate) const NEGLIGIBLE_SHARE: f64 = 0.01;
