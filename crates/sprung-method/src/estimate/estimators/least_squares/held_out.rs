//! Errors of fits on held-out parts of the logs.

use crate::estimate::statistics::HELD_OUT_PARTS;
use crate::fit::{HoldOut, Missed};
use crate::model::{Model, Theta};
use crate::regression::System;

/// Errors of fits on held-out parts of the logs.
pub(in crate::estimate) struct HeldOut {
    /// Errors of the fit of all parts on all parts.
    seen: Missed,
    /// Errors on each part of the fit of the other parts; `None` if they do not determine the parameters.
    unseen: Option<Vec<Missed>>,
    /// The same without constraints; `None` if no constraint changes a fit.
    unconstrained: Option<Vec<Missed>>,
}

/// Held-out error of a row with constraints over that without.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::estimate) struct Price {
    pub(in crate::estimate) ratio: f64,
    /// Its standard error, by the parts.
    pub(in crate::estimate) standard_error: f64,
}

/// Price of the constraints on held-out parts above which the model lacks an effect. Held-out residuals of two logs of
/// the same arm differ by less.
const DEAR: f64 = 0.02;

/// Standard errors above which a price is more than chance.
const SIGNIFICANCE_SIGMAS: f64 = 2.0;

impl Price {
    /// Returns whether the price of the constraints exceeds the difference between two logs, and is
    /// significant.
    pub(in crate::estimate) fn is_dear(&self) -> bool {
        self.ratio - 1.0 > DEAR.max(SIGNIFICANCE_SIGMAS * self.standard_error)
    }
}

impl HeldOut {
    /// Predicts parts of the logs by fits of the others.
    ///
    /// - `weights`: of rows in fits, \[rows\]; `theta`: the fit of all parts, \[p\].
    /// - `constrained`: returns the fits without each part under constraints, \[parts\]; `None` without constraints.
    pub(in crate::estimate) fn new(
        (model, system): (&Model, &System),
        weights: &[f64],
        theta: &[f64],
        constrained: Option<impl FnOnce(&HoldOut<'_>, &[Theta]) -> Option<Vec<Theta>>>,
    ) -> Self {
        let hold_out = HoldOut::new(model, system, HELD_OUT_PARTS).weighted(weights);
        let seen = sum((0..hold_out.len()).map(|part| hold_out.missed(part, theta)));
        let fits: Option<Vec<Theta>> = hold_out.fits_without_each().into_iter().collect();
        let missed = |fits: &[Theta]| -> Vec<Missed> {
            let each = fits.iter().enumerate();
            each.map(|(part, theta)| hold_out.missed(part, theta))
                .collect()
        };
        let plain = fits.as_deref().map(missed);
        let possible = constrained.map(|of| missed(&of(&hold_out, fits.as_deref()?)?).into());
        match possible {
            None => Self {
                seen,
                unseen: plain,
                unconstrained: None,
            },
            Some(unseen) => Self {
                seen,
                unseen,
                unconstrained: plain,
            },
        }
    }

    /// Returns the error on held-out parts over that of the fit of all parts, of one row: at least 1; infinite if the
    /// other parts do not determine the parameters.
    pub(in crate::estimate) fn ratio(&self, row: usize) -> f64 {
        let ratio = || {
            let unseen: f64 = (self.unseen.as_ref()?.iter())
                .map(|part| part.residual.get(row).copied())
                .sum::<Option<f64>>()?;
            let seen = self.seen.residual.get(row).filter(|seen| **seen > 0.0)?;
            Some((unseen / seen).sqrt().max(1.0)).filter(|ratio| ratio.is_finite())
        };
        ratio().unwrap_or(f64::INFINITY)
    }

    /// Returns the error of the torques on held-out parts, relative to the torques; infinite if the other parts do not
    /// determine the parameters.
    pub(super) fn error(&self) -> f64 {
        let all = self.unseen.as_ref().map(|parts| sum(parts.iter().cloned()));
        all.and_then(|all| all.of_torque_rows())
            .unwrap_or(f64::INFINITY)
    }

    /// Returns the price of the constraints in one row; `None` if no constraint changes a fit or the row has no error.
    pub(in crate::estimate) fn price(&self, row: usize) -> Option<Price> {
        let of = |parts: &[Missed]| -> Option<Vec<f64>> {
            parts
                .iter()
                .map(|part| part.residual.get(row).copied())
                .collect()
        };
        let with = of(self.unseen.as_ref()?)?;
        let without = of(self.unconstrained.as_ref()?)?;
        price(&with, &without)
    }
}

/// Returns the price by the squared errors on each part, with and without constraints.
fn price(with: &[f64], without: &[f64]) -> Option<Price> {
    let ratio = |left_out: Option<usize>| {
        let sum = |of: &[f64]| -> f64 {
            let kept = of
                .iter()
                .enumerate()
                .filter(|(part, _)| Some(*part) != left_out);
            kept.map(|(_, square)| square).sum()
        };
        (sum(with) / sum(without)).sqrt()
    };
    let count = with.len() as f64;
    let each: Vec<f64> = (0..with.len()).map(|part| ratio(Some(part))).collect();
    let mean = each.iter().sum::<f64>() / count;
    let squares: f64 = each.iter().map(|value| (value - mean).powi(2)).sum();
    let price = Price {
        ratio: ratio(None),
        standard_error: ((count - 1.0) / count * squares).sqrt(),
    };
    (price.ratio.is_finite() && price.standard_error.is_finite()).then_some(price)
}

fn sum(parts: impl Iterator<Item = Missed>) -> Missed {
    parts.fold(Missed::default(), |sum, missed| sum.with(&missed))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_price_is_a_ratio_of_root_mean_squares_with_the_scatter_of_the_parts() {
        let same = price(&[1.0, 2.0, 3.0], &[1.0, 2.0, 3.0]).unwrap();
        assert!((same.ratio - 1.0).abs() < 1e-12 && same.standard_error < 1e-12);
        // Four equal parts, of which one costs 21 % more: the root of the mean of 1, 1, 1 and 1.21.
        let one = price(&[1.0, 1.0, 1.0, 1.21], &[1.0; 4]).unwrap();
        assert!((one.ratio - 1.0525_f64.sqrt()).abs() < 1e-12);
        // Ratios without each part are 1.0344 three times and 1 once.
        let left: f64 = (3.21_f64 / 3.0).sqrt() - 1.0;
        let expected = 0.75 * left;
        assert!((one.standard_error - expected).abs() < 1e-9, "{one:?}");
        assert!(price(&[1.0], &[0.0]).is_none());
    }
}
