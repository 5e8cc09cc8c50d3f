//! The fourth step: least squares.

use super::pass::ReadLogs;
use super::prepare::Ready;
use crate::estimate::errors::IdentifyError;
use crate::estimate::estimators::least_squares::Linear;

/// Solves the regression of all logs by least squares, by other routes and from parts of the logs.
///
/// # Errors
///
/// As of [`Linear::new`].
pub(in crate::estimate) fn fit<'a>(
    ready: &'a Ready,
    read: &ReadLogs,
) -> Result<Linear<'a>, IdentifyError> {
    Linear::new(&ready.prepared, (&read.system, &read.spans))
}
