//! The normal distribution.

/// Half width of a 95 % interval of a normal error, in standard errors.
pub const NORMAL_95: f64 = 1.959_964;
