//! The test whether a delay differs from zero.

use super::significance::CERTAIN_SIGMAS;

/// Least significant delay, as a fraction of the sampling period.
pub(in crate::estimate) const MIN_DELAY_SAMPLES: f64 = 0.05;

/// Returns whether a delay, s, differs from zero.
pub(in crate::estimate) fn is_significant(delay: f64, standard_error: f64, period: f64) -> bool {
    delay.abs() > CERTAIN_SIGMAS * standard_error && delay.abs() > MIN_DELAY_SAMPLES * period
}
