//! Cross-validation (hold-out): errors of the torque of a fold predicted by estimates
//! without the fold.
//!
//! The last part alone does not suffice, because a single motion may not show an effect. So each
//! fold is left out in turn.

use super::refined::Refined;
use crate::estimate::estimators::least_squares::PossibleFit;
use crate::fit::{HoldOut, Missed, over_reference};
use crate::model::{Model, Theta};
use crate::regression::System;

/// Parts of the logs that the folds and the points of the trace consist of: a multiple of the number of folds.
pub(super) const PARTS: usize = 64;

/// Residuals of two estimates in the filtered torque of held-out folds: root mean squares over the
/// torque rows, relative to the joints' torques.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HeldOut {
    pub(super) refined: f64,
    pub(super) linear: f64,
}

impl HeldOut {
    /// Returns the residual of the refinement over that of least squares, up to the accuracy of the
    /// filtered regression.
    pub(super) fn ratio(self) -> f64 {
        over_reference(self.refined, self.linear)
    }
}

/// The folds of a log in the filtered regression.
pub(super) struct Folds<'a> {
    parts: HoldOut<'a>,
    /// Fold of each part; `None` behind the last fold.
    fold_of: Vec<Option<usize>>,
    /// Residual of least squares.
    linear: f64,
}

impl<'a> Folds<'a> {
    /// Splits the regression into the folds of a refinement and evaluates least squares.
    ///
    /// - `possible`: least squares over the robots that can exist; `None` without constraints.
    ///
    /// Returns `None` if least squares has no solution without one of the folds.
    pub(super) fn new(
        model: &'a Model,
        system: &System,
        refined: &Refined,
        possible: Option<&PossibleFit<'_>>,
    ) -> Option<Self> {
        // The samples of a refinement are spread evenly over the logs.
        let parts = HoldOut::new(model, system, PARTS);
        let fold_of = (0..parts.len())
            .map(|part| {
                let middle = (part as f64 + 0.5) / parts.len() as f64;
                refined
                    .parts
                    .without
                    .iter()
                    .position(|(end, _)| middle < *end)
            })
            .collect();
        let mut folds = Self {
            parts,
            fold_of,
            linear: 0.0,
        };
        let linear: Option<Vec<Theta>> = (0..refined.parts.without.len())
            .map(|fold| folds.fit_without(fold, possible))
            .collect();
        let linear = linear?;
        folds.linear = folds.residual(|fold| linear.get(fold))?;
        Some(folds)
    }

    /// Returns both residuals. That of a refinement that has no finite residual is infinite.
    pub(super) fn compare(&self, refined: &Refined) -> HeldOut {
        let residual =
            self.residual(|fold| refined.parts.without.get(fold).map(|(_, theta)| theta));
        HeldOut {
            refined: residual.unwrap_or(f64::INFINITY),
            linear: self.linear,
        }
    }

    /// Returns the estimate of least squares from all folds but one.
    fn fit_without(&self, fold: usize, possible: Option<&PossibleFit<'_>>) -> Option<Theta> {
        let is_used = |part: usize| self.fold_of[part].is_some_and(|other| other != fold);
        match possible {
            None => self.parts.fit(is_used),
            Some(possible) => possible.fit(&self.parts, is_used),
        }
    }

    /// Returns the residual of one estimate per fold; `None` if a fold has no estimate or the
    /// residual is not finite.
    fn residual<'t>(&self, theta: impl Fn(usize) -> Option<&'t Theta>) -> Option<f64> {
        let used =
            (self.fold_of.iter().enumerate()).filter_map(|(part, fold)| Some((part, (*fold)?)));
        let mut sum = Missed::default();
        for (part, fold) in used {
            sum = sum.with(&self.parts.missed(part, theta(fold)?));
        }
        sum.of_torque_rows()
    }
}
