//! The likelihood of levels, with gradient and information.

use super::average_information::average_information;
use super::backward::backward;
use super::forward::forward;
use super::level_gradient::LevelGradient;
use super::linear_run::LinearRun;
use crate::estimate::prediction_error::filter::FilterRun;
use crate::estimate::prediction_error::levels::{Levels, UnknownLevels};
use crate::estimate::prediction_error::measurements::Measurements;

/// The likelihood of levels, with the filter linearised about a run.
#[derive(Clone, Copy)]
pub(in super::super) struct LevelLikelihood<'a> {
    pub(in super::super) measurements: &'a Measurements,
    pub(in super::super) run: &'a FilterRun,
    // Number of samples whose linearization is used.
    samples: usize,
}

/// Likelihood at some levels, with derivatives by the logarithms of the levels.
#[derive(Clone, Debug)]
pub(in super::super) struct Score {
    /// Minus the logarithm of the likelihood, without its constant.
    pub(in super::super) loss: f64,
    pub(in super::super) gradient: Vec<f64>,
    /// Expectation of the gradient's quadratic part by the innovations.
    pub(in super::super) expected: Vec<f64>,
    /// Average of expected and observed information, \[levels × levels\]; only the lower triangle
    /// is filled.
    pub(in super::super) information: Vec<f64>,
}

impl<'a> LevelLikelihood<'a> {
    /// - `samples`: number of samples whose linearization is used.
    pub(in super::super) fn new(
        measurements: &'a Measurements,
        run: &'a FilterRun,
        samples: usize,
    ) -> Self {
        Self {
            measurements,
            run,
            samples,
        }
    }

    /// Returns the likelihood at some levels; `None` if the run does not belong to the
    /// measurements.
    pub(in super::super) fn score(
        &self,
        unknown: &UnknownLevels,
        levels: &Levels,
    ) -> Option<Score> {
        let linear = LinearRun::new(self.measurements, self.run, self.samples, levels);
        let forward = forward(&linear)?;
        let mut all = LevelGradient::new(levels);
        let backward = backward(&linear, &forward, &mut all, &mut |_, _, _| {});
        let gradient: Vec<f64> = (unknown.all.iter())
            .map(|level| all.gradient(*level))
            .collect();
        let expected = (unknown.all.iter().zip(&gradient))
            .map(|(level, own)| own + all.found(*level))
            .collect();
        Some(Score {
            loss: forward.loss,
            gradient,
            expected,
            information: average_information(&linear, &unknown.all, &forward, &backward),
        })
    }

    /// Visits the samples, the last one first, with the information of later measurements about the
    /// state at the end of the period after the sample. The arguments are the sample's index and
    /// the matrix `2 D + r rᵀ`, \[states × states\].
    pub(in super::super) fn information_ahead(
        &self,
        levels: &Levels,
        mut visit: impl FnMut(usize, &[f64]),
    ) {
        let linear = LinearRun::new(self.measurements, self.run, self.samples, levels);
        let Some(forward) = forward(&linear) else {
            return;
        };
        let mut information = Vec::new();
        let mut behind = |sample: usize, covariance_adjoint: &[f64], state_adjoint: &[f64]| {
            // D is half the information minus r rᵀ/2, so r rᵀ is added to 2 D.
            information.clear();
            let rows = covariance_adjoint.chunks(state_adjoint.len());
            for (row, own) in rows.zip(state_adjoint) {
                let entries = row.iter().zip(state_adjoint);
                information.extend(entries.map(|(d, other)| 2.0 * d + own * other));
            }
            visit(sample, &information);
        };
        let mut all = LevelGradient::new(levels);
        backward(&linear, &forward, &mut all, &mut behind);
    }
}
