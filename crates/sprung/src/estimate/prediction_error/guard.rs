//! Residual of an estimate in the filtered torque, compared with that of least squares.

use crate::fit::HoldOut;
use crate::model::Model;
use crate::regression::System;

/// Accuracy of the filtered regression, relative to the torque. The filter of the positions smears
/// reversals of stiff friction. Least squares absorbs a part of this error, and true parameters do
/// not.
const REGRESSION_ACCURACY: f64 = 0.005;

/// Returns a residual in the filtered torque over that of least squares, up to the accuracy of the
/// filtered regression.
pub(super) fn over_least_squares(own: f64, linear: f64) -> f64 {
    own / linear.hypot(REGRESSION_ACCURACY)
}

/// The residual of an estimate in the filtered torque of the logs that it comes from.
pub(super) struct Guard<'a> {
    whole: HoldOut<'a>,
    /// Residual of least squares.
    linear: f64,
}

impl<'a> Guard<'a> {
    /// - `linear`: estimate of least squares, \[p\].
    pub(super) fn new(model: &'a Model, system: &System, linear: &[f64]) -> Option<Self> {
        let whole = HoldOut::new(model, system, 1);
        let linear = (whole.len() > 0)
            .then(|| whole.missed(0, linear))?
            .of_torque_rows()?;
        Some(Self { whole, linear })
    }

    /// Returns the residual of an estimate over that of least squares.
    pub(super) fn ratio(&self, theta: &[f64]) -> f64 {
        let own = self.whole.missed(0, theta).of_torque_rows();
        own.map_or(f64::INFINITY, |own| over_least_squares(own, self.linear))
    }
}
