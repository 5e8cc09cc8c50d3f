//! Blocked cross-validation (hold-out): errors of the torque of a block predicted by estimates
//! without the block.
//!
//! The last part alone does not suffice, because a single motion may not show an effect. So each
//! block is left out in turn.

use super::refined::Refined;
use crate::estimate::estimators::least_squares::PossibleFit;
use crate::fit::{HoldOut, Missed, over_reference};
use crate::model::{Model, Theta};
use crate::regression::System;

/// Parts of the logs that the blocks and the points of the trace consist of: a multiple of the number of blocks.
pub(super) const PARTS: usize = 64;

/// Residuals of two estimates in the filtered torque of held-out blocks: root mean squares over the
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

/// The blocks of a log in the filtered regression.
pub(super) struct Blocks<'a> {
    parts: HoldOut<'a>,
    /// Block of each part; `None` behind the last block.
    block_of: Vec<Option<usize>>,
    /// Residual of least squares.
    linear: f64,
}

impl<'a> Blocks<'a> {
    /// Splits the regression into the blocks of a refinement and evaluates least squares.
    ///
    /// - `possible`: least squares over the robots that can exist; `None` without constraints.
    ///
    /// Returns `None` if least squares has no solution without one of the blocks.
    pub(super) fn new(
        model: &'a Model,
        system: &System,
        refined: &Refined,
        possible: Option<&PossibleFit<'_>>,
    ) -> Option<Self> {
        // The samples of a refinement are spread evenly over the logs.
        let parts = HoldOut::new(model, system, PARTS);
        let block_of = (0..parts.len())
            .map(|part| {
                let middle = (part as f64 + 0.5) / parts.len() as f64;
                refined
                    .parts
                    .without
                    .iter()
                    .position(|(end, _)| middle < *end)
            })
            .collect();
        let mut blocks = Self {
            parts,
            block_of,
            linear: 0.0,
        };
        let linear: Option<Vec<Theta>> = (0..refined.parts.without.len())
            .map(|block| blocks.fit_without(block, possible))
            .collect();
        let linear = linear?;
        blocks.linear = blocks.residual(|block| linear.get(block))?;
        Some(blocks)
    }

    /// Returns both residuals. That of a refinement that has no finite residual is infinite.
    pub(super) fn compare(&self, refined: &Refined) -> HeldOut {
        let residual =
            self.residual(|block| refined.parts.without.get(block).map(|(_, theta)| theta));
        HeldOut {
            refined: residual.unwrap_or(f64::INFINITY),
            linear: self.linear,
        }
    }

    /// Returns the estimate of least squares from all blocks but one.
    fn fit_without(&self, block: usize, possible: Option<&PossibleFit<'_>>) -> Option<Theta> {
        let is_used = |part: usize| self.block_of[part].is_some_and(|other| other != block);
        match possible {
            None => self.parts.fit(is_used),
            Some(possible) => possible.fit(&self.parts, is_used),
        }
    }

    /// Returns the residual of one estimate per block; `None` if a block has no estimate or the
    /// residual is not finite.
    fn residual<'t>(&self, theta: impl Fn(usize) -> Option<&'t Theta>) -> Option<f64> {
        let used =
            (self.block_of.iter().enumerate()).filter_map(|(part, block)| Some((part, (*block)?)));
        let mut sum = Missed::default();
        for (part, block) in used {
            sum = sum.with(&self.parts.missed(part, theta(block)?));
        }
        sum.of_torque_rows()
    }
}
