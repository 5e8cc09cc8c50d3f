//! The likelihood of levels, with gradient and information.

use rayon::prelude::*;

use super::average_information::average_information;
use super::backward::backward;
use super::forward::forward;
use super::level_gradient::LevelGradient;
use super::linear_run::LinearRun;
use crate::estimate::estimators::prediction_error::filter::FilterRun;
use crate::estimate::estimators::prediction_error::levels::{Levels, UnknownLevels};
use crate::estimate::estimators::prediction_error::measurements::Measurements;
use crate::estimate::estimators::prediction_error::vector::add;

/// The likelihood of levels, with the filter linearised about a run.
#[derive(Clone)]
pub(in super::super) struct LevelLikelihood<'a> {
    pub(in super::super) measurements: &'a Measurements,
    pub(in super::super) run: &'a FilterRun,
    searched: &'a Searched,
}

/// Parts of the segments about which levels are searched.
#[derive(Clone, Debug)]
pub(in super::super) struct Searched {
    /// Indices of the segments.
    segments: Vec<usize>,
    /// Fraction of the samples of each segment, from the first one.
    share: f64,
}

impl Searched {
    /// - `samples`: maximum number of samples, spread evenly over the segments.
    pub(in super::super) fn new(measurements: &Measurements, samples: usize) -> Self {
        let stride = measurements.samples().div_ceil(samples.max(1)).max(1);
        Self {
            segments: (0..measurements.segments.len()).step_by(stride).collect(),
            share: 1.0,
        }
    }

    /// Returns the same segments with a fraction of their samples.
    pub(in super::super) fn beginnings(&self, share: f64) -> Self {
        Self {
            segments: self.segments.clone(),
            share,
        }
    }

    pub(in super::super) fn contains(&self, segment: usize) -> bool {
        self.segments.contains(&segment)
    }
}

/// Likelihood at some levels, with derivatives by the logarithms of the levels.
#[derive(Clone, Debug, Default)]
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

impl Score {
    fn append(&mut self, next: &Self) {
        self.loss += next.loss;
        let pairs = [
            (&mut self.gradient, &next.gradient),
            (&mut self.expected, &next.expected),
            (&mut self.information, &next.information),
        ];
        for (sum, addend) in pairs {
            sum.resize(addend.len(), 0.0);
            add(sum, 1.0, addend);
        }
    }
}

impl<'a> LevelLikelihood<'a> {
    /// - `run`: with the linearizations of the searched segments.
    pub(in super::super) fn new(
        measurements: &'a Measurements,
        run: &'a FilterRun,
        searched: &'a Searched,
    ) -> Self {
        Self {
            measurements,
            run,
            searched,
        }
    }

    /// Returns the likelihood at some levels; `None` if the run does not belong to the
    /// measurements.
    pub(in super::super) fn score(
        &self,
        unknown: &UnknownLevels,
        levels: &Levels,
    ) -> Option<Score> {
        let each: Option<Vec<Score>> = (self.searched.segments.par_iter())
            .with_max_len(1)
            .map(|&segment| self.score_of(segment, unknown, levels))
            .collect();
        let mut score = Score::default();
        for part in &each? {
            score.append(part);
        }
        Some(score)
    }

    /// Returns the likelihood of the measurements of a segment.
    fn score_of(&self, segment: usize, unknown: &UnknownLevels, levels: &Levels) -> Option<Score> {
        let linear = linear_run(self.measurements, self.run, segment, levels);
        let linear = linear.beginning(self.searched.share);
        let forward = forward(&linear)?;
        let mut all = LevelGradient::new(levels);
        let backward = backward(&linear, &forward, &mut all);
        let gradient: Vec<f64> = (unknown.all.iter())
            .map(|level| all.gradient(*level))
            .collect();
        let expected = (unknown.all.iter().zip(&gradient))
            .map(|(level, derivative)| derivative + all.found(*level))
            .collect();
        Some(Score {
            loss: forward.loss,
            gradient,
            expected,
            information: average_information(&linear, &unknown.all, &forward, &backward),
        })
    }
}

fn linear_run<'a>(
    measurements: &'a Measurements,
    run: &'a FilterRun,
    segment: usize,
    levels: &'a Levels,
) -> LinearRun<'a> {
    let measured = &measurements.segments[segment];
    LinearRun::new(
        &measurements.sensors,
        measured,
        &run.segments[segment],
        levels,
    )
}
