//! Folds the rows of any number of samples into a bounded number of factors.

use std::sync::{Arc, OnceLock};

use rayon::prelude::*;
use sprung_core::filter::FilterError;

use super::batch::{BATCH_SAMPLES, Batch};
use super::filtered::Pairs;
use super::probes::Probe;
use super::row_factors::SegmentLimits;
use super::row_reduction::RowReduction;
use super::system::{KEPT_SAMPLES, Kept, System, joined_in_pairs};
use super::weights::{Standing, TransitionWeights};
use crate::description::DiscretizationName;
use crate::model::{Elements, Model};
use crate::preprocess::{Decimator, SignalBlock};

/// Number of segments of samples in memory, at most. They are divided into 32 parts or fewer.
const SEGMENTS_OF_KNOWN_LENGTH: u64 = 128;

/// Forms, filters and folds the regression of samples as they arrive.
///
/// Each row of the regressor contains few parameters, so each row is reduced alone in its own
/// columns; the solver assembles the factors of all rows. Threads share the samples while they form
/// the regressor, and the rows while they filter and fold, so the result does not depend on the
/// number of threads. The next batch is formed while the current one is folded.
#[derive(Clone, Debug)]
pub struct Reduction {
    batch: Batch,
    next: Batch,
    rows: Vec<RowReduction>,
    // End of each segment, s; merged together with the rows' factors.
    ends: Vec<f64>,
    in_current: u64,
    limits: SegmentLimits,
    segment_samples: u64,
    last_time: f64,
    kept: Decimator<f64>,
    samples: u64,
    standing: Standing,
    elements: Elements,
}

impl Reduction {
    /// Returns an empty reduction of all rows.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        let rows: Vec<usize> = (0..model.rows()).collect();
        Self::of_rows(model, &rows)
    }

    /// Returns an empty reduction of the given rows.
    #[must_use]
    pub fn of_rows(model: &Model, rows: &[usize]) -> Self {
        Self::with_probes(model, rows, &[])
    }

    /// Returns an empty reduction of the given rows with further columns, which follow the model's
    /// columns in their rows.
    #[must_use]
    pub(crate) fn with_probes(model: &Model, rows: &[usize], probes: &[Probe]) -> Self {
        let shared: Arc<[Probe]> = probes.into();
        Self {
            batch: Batch::new(model, rows, &shared),
            next: Batch::new(model, rows, &shared),
            rows: (rows.iter())
                .map(|&row| RowReduction::new(model, row, probes))
                .collect(),
            ends: Vec::new(),
            in_current: 0,
            limits: SegmentLimits::of(model),
            segment_samples: SegmentLimits::of(model).initial_samples,
            last_time: 0.0,
            kept: Decimator::new(KEPT_SAMPLES),
            samples: 0,
            standing: Standing::default(),
            elements: model.elements(),
        }
    }

    /// Sets the weights of the samples.
    ///
    /// Weights multiply the filtered rows and their right-hand sides; the samples that are kept for
    /// plots stay unweighted.
    #[must_use]
    pub fn weighted(mut self, weights: Option<&TransitionWeights>) -> Self {
        let weights = weights.cloned().map(Arc::new);
        for row in &mut self.rows {
            row.weights.clone_from(&weights);
        }
        self.next.weights.clone_from(&weights);
        self.batch.weights = weights;
        self
    }

    /// Sets the number of logs, of which this reduction reads one.
    #[must_use]
    pub(super) fn among(mut self, logs: usize) -> Self {
        self.limits = self.limits.among(logs);
        self.segment_samples = self.limits.initial_samples;
        for row in &mut self.rows {
            row.factors.limit(self.limits, self.segment_samples);
        }
        self
    }

    /// Sets the number of samples that will come. Then the first segments are as long as the last,
    /// which saves most of the small factors.
    #[must_use]
    pub(crate) fn with_samples(mut self, samples: u64) -> Self {
        self.segment_samples = (self.segment_samples).max(samples / SEGMENTS_OF_KNOWN_LENGTH);
        for row in &mut self.rows {
            row.factors.limit(self.limits, self.segment_samples);
        }
        self
    }

    /// Keeps no samples for plots.
    #[must_use]
    pub(crate) fn without_samples(mut self) -> Self {
        for row in &mut self.rows {
            row.kept.is_on = false;
        }
        self
    }

    /// Begins another log or continues after a gap: the filters start at rest.
    pub fn restart(&mut self) {
        self.rows.iter_mut().for_each(RowReduction::restart);
        self.standing = Standing::default();
        self.elements.restart();
    }

    /// Sets the change of the parameters by a known payload in the samples that come: its torques are
    /// taken from the right-hand sides.
    ///
    /// - `change`: \[p\]; `None` without a payload.
    pub(crate) fn carry(&mut self, change: Option<&[f64]>) {
        let model = self.batch.model();
        for row in &mut self.rows {
            row.carried = change.map_or_else(Vec::new, |change| {
                model
                    .row_columns(row.row)
                    .iter()
                    .map(|&c| change[c])
                    .collect()
            });
        }
    }

    /// Takes the next samples.
    ///
    /// - `cutoff`: λ, rad/s; `period`: T, s.
    ///
    /// # Errors
    ///
    /// [`FilterError`] if λ or T is not positive.
    pub fn push(
        &mut self,
        signals: &SignalBlock,
        cutoff: f64,
        period: f64,
        discretization: DiscretizationName,
    ) -> Result<(), FilterError> {
        let pairs = Pairs::new(cutoff, period, discretization)?;
        let bounds = match &self.batch.weights {
            Some(weights) => {
                weights.bounds_at_rest(self.batch.model(), signals, period, &mut self.standing)
            }
            None => Vec::new(),
        };
        let elements = signals.elements(&mut self.elements);
        let beside = (bounds.as_slice(), elements.as_slice());
        self.batch.form(signals, 0, beside);
        for first in (0..signals.len()).step_by(BATCH_SAMPLES) {
            let (batch, next, rows) = (&self.batch, &mut self.next, &mut self.rows);
            rayon::join(
                || next.form(signals, first + BATCH_SAMPLES, beside),
                // Row widths differ much, so single rows balance the load of the threads best.
                || {
                    (rows.par_iter_mut().with_max_len(1)).for_each(|row| row.take(&pairs, batch));
                },
            );
            std::mem::swap(&mut self.batch, &mut self.next);
            let until = signals.len().min(first + BATCH_SAMPLES);
            for &time in &signals.time[first..until] {
                self.tick(time);
            }
        }
        Ok(())
    }

    fn tick(&mut self, time: f64) {
        self.samples += 1;
        self.in_current += 1;
        self.last_time = time;
        self.kept.push(|| time);
        if self.in_current == self.segment_samples {
            self.close();
        }
    }

    fn close(&mut self) {
        self.in_current = 0;
        self.ends.push(self.last_time);
        if self.ends.len() == self.limits.max_factors {
            self.ends = joined_in_pairs(&self.ends, |_, end| *end);
            self.segment_samples *= 2;
        }
    }

    /// Ends the reduction and returns the reduced system.
    #[must_use]
    pub fn finish(mut self) -> System {
        for row in &mut self.rows {
            row.factors.untile();
        }
        if self.in_current > 0 {
            self.close();
            for row in &mut self.rows {
                row.factors.close();
            }
        }
        let weights = self.rows.iter().map(|row| row.weight).collect();
        let at_rest = self.rows.iter().map(|row| row.at_rest).collect();
        let mut rows = Vec::with_capacity(self.rows.len());
        let (mut kept, mut variance, mut bound) = (Vec::new(), Vec::new(), Vec::new());
        for row in self.rows {
            rows.push(row.factors.done);
            kept.push(row.kept.rows.into_items());
            variance.push(row.kept.variance.into_items());
            bound.push(row.kept.bound.into_items());
        }
        System {
            rows,
            weights,
            logs: vec![self.ends.len()],
            ends: self.ends,
            segment_samples: self.segment_samples,
            max_segments: self.limits.max_factors,
            kept: Kept {
                stride: self.kept.stride(),
                time: self.kept.into_items(),
                rows: kept,
                variance,
                bound,
            },
            at_rest,
            samples: self.samples,
            all: OnceLock::new(),
        }
    }
}
