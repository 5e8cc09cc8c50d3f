//! Least squares as an estimator.

use crate::estimate::found::{Found, Numbers};
use crate::finding::{Finding, Severity};
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
        findings: vec![standard_error_of_stretches()],
    }
}

fn standard_error_of_stretches() -> Finding {
    Finding::new(
        Severity::Info,
        "standard-error-of-stretches",
        "the standard errors measure how much stretches of this log disagree. They do not contain \
         a bias that all stretches share, for example by quantised positions in the Coulomb \
         transition or by a disturbance. So ci95 is a lower bound of the interval"
            .to_owned(),
        "compare cut-offs and repeated experiments",
    )
}
