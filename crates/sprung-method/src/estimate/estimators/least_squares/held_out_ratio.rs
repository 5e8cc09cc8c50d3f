//! Errors on parts of the logs that a fit has not seen.

use crate::estimate::statistics::HELD_OUT_PARTS;
use crate::fit::{HoldOut, Missed};
use crate::model::Model;
use crate::regression::System;

/// Ratio of the error on parts that a fit has not seen to the error on all parts with the fit of all
/// parts, row by row: at least 1; infinite if the other parts do not determine the parameters.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::estimate) struct HeldOutRatio(Vec<f64>);

impl HeldOutRatio {
    /// Fits all parts but one by least squares, and predicts the part that is left out.
    ///
    /// - `linear`: least squares of all parts, \[p\].
    pub(in crate::estimate) fn new(model: &Model, system: &System, linear: &[f64]) -> Self {
        let hold_out = HoldOut::new(model, system, HELD_OUT_PARTS);
        let seen = (0..hold_out.len()).fold(Missed::default(), |sum, part| {
            sum.with(&hold_out.missed(part, linear))
        });
        let unseen = hold_out.missed_by_fits();
        let ratio = |row: usize| {
            let unseen = unseen.as_ref()?.residual.get(row)?;
            let seen = seen.residual.get(row).filter(|seen| **seen > 0.0)?;
            Some((unseen / seen).sqrt().max(1.0)).filter(|ratio| ratio.is_finite())
        };
        Self(
            (0..model.rows())
                .map(|row| ratio(row).unwrap_or(f64::INFINITY))
                .collect(),
        )
    }

    /// Returns the ratio of a row.
    pub(in crate::estimate) fn of_row(&self, row: usize) -> f64 {
        self.0[row]
    }
}
