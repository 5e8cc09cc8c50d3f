//! Least squares as an estimator.

use crate::estimate::estimators::found::{Found, Numbers};
use crate::fit::{Fitted, trace};
use crate::model::Model;
use crate::regression::System;

/// Returns the result of least squares.
///
/// - `elapsed`: computing time, s.
pub(in crate::estimate) fn least_squares(
    model: &Model,
    system: &System,
    fitted: &Fitted,
    elapsed: f64,
) -> Found {
    Found {
        numbers: Numbers {
            points: trace(model, system).collect(),
            elapsed,
            ..Numbers::of(fitted)
        },
        findings: Vec::new(),
    }
}
