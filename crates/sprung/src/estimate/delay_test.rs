//! The test whether a delay differs from zero.

/// A delay is significant if it exceeds this number of standard errors and a fraction of a sampling
/// period.
pub(super) const DELAY_SIGNIFICANCE_SIGMAS: f64 = 5.0;

/// Least significant delay, as a fraction of the sampling period.
pub(super) const MIN_DELAY_SAMPLES: f64 = 0.05;

/// Returns whether a delay, s, differs from zero.
pub(super) fn is_significant(delay: f64, standard_error: f64, period: f64) -> bool {
    delay.abs() > DELAY_SIGNIFICANCE_SIGMAS * standard_error
        && delay.abs() > MIN_DELAY_SAMPLES * period
}
