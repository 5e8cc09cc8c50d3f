//! Residual of an estimate in the filtered torque, compared with that of least squares.

use crate::fit::{HoldOut, over_reference};
use crate::model::Model;
use crate::regression::System;

/// The residual of an estimate in the filtered torque of its logs.
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
        let missed = self.whole.missed(0, theta).of_torque_rows();
        missed.map_or(f64::INFINITY, |missed| over_reference(missed, self.linear))
    }
}
