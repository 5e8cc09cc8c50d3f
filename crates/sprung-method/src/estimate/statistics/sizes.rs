//! Sizes that several tests share.

/// Relative change that matters: with such an error of the model, feedforward leaves a tenth of the torque to feedback.
pub(in crate::estimate) const LARGE_SHARE: f64 = 0.1;

/// Relative change that is reported although it is not yet relevant: half of the one that matters.
pub(in crate::estimate) const SMALL_SHARE: f64 = 0.05;

/// Relative standard error of a parameter that is not known: its 95 % interval reaches from nothing to twice the value.
pub(in crate::estimate) const UNKNOWN_RELATIVE_ERROR: f64 = 0.5;

/// Argument of `tanh(beta v)` at which Coulomb friction has reached its value: `tanh(2) = 0.964`. At smaller ones
/// friction still reverses, and masks laws that depend on the velocity.
pub(in crate::estimate) const SATURATED_ARGUMENT: f64 = 2.0;

/// Relative change that does not count: a tenth of the one that matters.
pub(in crate::estimate) const NEGLIGIBLE_SHARE: f64 = 0.01;
