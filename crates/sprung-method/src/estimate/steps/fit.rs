//! The fourth step: least squares.

use super::pass::ReadLogs;
use super::prepare::Ready;
use crate::estimate::errors::IdentifyError;
use crate::estimate::estimators::least_squares::Linear;
use crate::estimate::estimators::prediction_error::Timing;

/// Solves the regression of all logs by least squares, by other methods and from parts of the logs.
///
/// # Errors
///
/// As of [`Linear::new`].
pub(in crate::estimate) fn fit<'a>(
    ready: &'a Ready,
    read: &ReadLogs,
    timing: Timing<'_>,
) -> Result<Linear<'a>, IdentifyError> {
    let is_timed = matches!(timing, Timing::Found(_));
    Linear::new(&ready.prepared, (&read.system, &read.spans), is_timed)
}
