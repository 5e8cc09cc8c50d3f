//! Least squares as an estimator.

use super::linear::{Linear, linear_numbers};
use crate::estimate::estimators::estimator_result::{Found, Numbers};
use crate::fit::trace;
use crate::model::Model;
use crate::regression::System;

/// Returns the result of least squares.
///
/// - `elapsed`: computing time, s.
pub(in crate::estimate) fn least_squares(
    model: &Model,
    system: &System,
    linear: &Linear<'_>,
    elapsed: f64,
) -> Found {
    Found {
        numbers: Numbers {
            points: trace(model, system).collect(),
            elapsed,
            ..linear_numbers(&linear.fitted, linear.possible.as_ref())
        },
        findings: Vec::new(),
        unknowns: Vec::new(),
    }
}
