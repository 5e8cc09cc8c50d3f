//! Common limits: significance of an effect, and convergence of a search.

/// Standard errors above which an effect is more than chance. A normal error exceeds it once in 370 times.
pub(in crate::estimate) const SIGNIFICANT_SIGMAS: f64 = 3.0;

/// Standard errors above which an effect is certain. Normal errors of the roughly hundred tested effects of a log do
/// not exceed it in practice; standard errors may be too small by a half.
pub(in crate::estimate) const CERTAIN_SIGMAS: f64 = 5.0;

/// Least significant delay, as a fraction of the sampling period.
pub(in crate::estimate) const MIN_DELAY_SAMPLES: f64 = 0.05;

/// Probability of a false alarm of a test, before it is divided by the number of tests.
pub(in crate::estimate) const FALSE_ALARM_PROBABILITY: f64 = 0.01;

/// Parts of a log that are left out in turn. More parts change the held-out residual by less than its scatter.
pub(in crate::estimate) const HELD_OUT_PARTS: usize = 8;

/// Length of a step, in standard errors per square root of the number of unknowns, without effect on an estimate.
pub(in crate::estimate) const SHORT_STEP_SIGMAS: f64 = 0.02;

/// Cost that a step must save, in units of squared standard errors, otherwise the search has converged.
pub(in crate::estimate) const MIN_COST_SAVED: f64 = 1e-3;
