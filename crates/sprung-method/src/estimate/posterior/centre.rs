//! The robot in the middle of the posterior.

use faer::Mat;

use super::errors::PosteriorError;
use super::normal::Normal;
use super::rest::Rest;
use crate::estimate::possible::{Robots, must_be_positive};
use crate::estimate::result::EstimateResult;
use crate::model::{Block, Program};

/// Start distance of a drive's parameter from its bound, in its errors.
const INSIDE: f64 = 1e-3;

/// Returns the matrices that must be positive definite, without the prior.
pub(super) fn borders_of(robots: &Robots<'_>) -> Vec<Block> {
    let without_prior = |block: &Block| {
        let mut block = block.clone();
        block.entropy = 0.0;
        block
    };
    robots.prior.blocks.iter().map(without_prior).collect()
}

/// Returns the robot of the result where the result determines it, else of the prior.
pub(super) fn start(robots: &Robots<'_>, rest: &Rest, result: &EstimateResult) -> Vec<f64> {
    let mut start = robots.start.clone();
    for (entry, index) in start.iter_mut().zip(&robots.standard) {
        if let Some(found) = result.standard_parameters.get(*index) {
            *entry = found.value;
        }
    }
    let others = robots.others.iter().zip(&rest.others);
    for (entry, (&index, [value, error])) in start[robots.standard.len()..].iter_mut().zip(others) {
        let parameter = &robots.model.parameters()[index];
        *entry = *value;
        if must_be_positive(parameter) {
            let found = result.parameter(&parameter.name);
            let error = found
                .and_then(|parameter| parameter.standard_error)
                .unwrap_or(*error);
            *entry = value.max(INSIDE * error);
        }
    }
    start
}

/// Returns the robot in the middle of the posterior.
pub(super) fn centre(
    robots: &Robots<'_>,
    normal: &Normal,
    start: &[f64],
) -> Result<Vec<f64>, PosteriorError> {
    // Differences from the mean keep the digits of the function.
    let shifted = |block: &Block| {
        let mut shifted = block.clone();
        for (unknown, entries) in &block.terms {
            shifted.add_constant(entries, normal.mean[*unknown]);
        }
        shifted
    };
    let blocks = borders_of(robots).iter().map(shifted).collect();
    let program = program(&normal.precision, blocks);
    let from: Vec<f64> = start.iter().zip(&normal.mean).map(|(x, m)| x - m).collect();
    let gap = program.rows() as f64;
    let found = (program.minimise(&from, gap))
        .map_err(|reason| PosteriorError::NoRobot(robots.why(reason)))?;
    Ok(found.iter().zip(&normal.mean).map(|(x, m)| x + m).collect())
}

/// Returns minus the logarithm of a normal density about zero over a set.
///
/// - `blocks`: matrices that are positive definite in the set.
pub(super) fn program(precision: &Mat<f64>, blocks: Vec<Block>) -> Program {
    let n = precision.nrows();
    Program {
        quadratic: (0..n * n).map(|at| precision[(at / n, at % n)]).collect(),
        linear: vec![0.0; n],
        blocks,
    }
}
