//! Folds the rows of any number of samples into a bounded number of factors.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use rayon::prelude::*;
use sprung_core::filter::{FilterBank, FilterError, FilterState, bank_len};

use super::batch::{BATCH_SAMPLES, Batch};
use super::filtered::Pairs;
use super::high_pass::RowHighPass;
use super::householder::RowBlock;
use super::probes::Probe;
use super::system::{KEPT_SAMPLES, Kept, System, joined_in_pairs};
use super::triangle::Triangle;
use super::weights::{Standing, TransitionWeights};
use crate::description::{DiscretizationName, RightHandSide};
use crate::model::Model;
use crate::preprocess::{Decimator, SignalBlock};

/// Limits of the segments of a log: each row keeps one factor per segment. When the largest number
/// of factors is reached, neighbours are merged and the segments double in length. Models with many
/// parameters have large factors, so they keep fewer.
#[derive(Clone, Copy, Debug)]
struct Stretches {
    max_factors: usize,
    initial_samples: u64,
}

impl Stretches {
    fn of(model: &Model) -> Self {
        if model.parameters().len() <= 40 {
            Self {
                max_factors: 512,
                initial_samples: 16,
            }
        } else {
            Self {
                max_factors: 128,
                initial_samples: 64,
            }
        }
    }
}

/// Returns the number of segments up to which neighbours are not merged.
pub(super) fn max_stretches(model: &Model) -> usize {
    Stretches::of(model).max_factors
}

impl Stretches {
    /// Returns the limits of one of several logs, whose factors are joined later. Longer first segments save small
    /// factors that would be merged.
    fn among(self, logs: usize) -> Self {
        let levels = logs.clamp(1, self.max_factors).ilog2();
        Self {
            initial_samples: self.initial_samples << levels,
            ..self
        }
    }
}

/// Number of segments of samples in memory, at most. They are divided into 32 parts or fewer.
const STRETCHES_OF_KNOWN_LENGTH: u64 = 128;

/// Rows that are transposed into columns together.
const TILE_ROWS: usize = 16;

/// Reduces one row of the regressor from samples to factors.
#[derive(Clone, Debug)]
struct RowReduction {
    row: usize,
    entries: Range<usize>,
    // Indices of the row's probes.
    probes: Vec<usize>,
    // Number of entries and probes.
    width: usize,
    rhs: RightHandSide,
    // Places and values of stiffnesses whose torque is on the right-hand side.
    known: Vec<(usize, f64)>,
    bank: FilterBank<Vec<f64>>,
    probe_bank: FilterBank<Vec<f64>>,
    // The row's probes at one sample; their parts under d/dt are zero.
    probed: Vec<f64>,
    no_momentum: Vec<f64>,
    // The rate of change of the right-hand side, if it is a probe, and the last right-hand side.
    torque_rate: Option<usize>,
    last_rhs: f64,
    torque_memory: FilterState,
    spring_memory: FilterState,
    // Of a joint whose instrument does not show constant deflections.
    high_pass: Option<RowHighPass>,
    weights: Option<Arc<TransitionWeights>>,
    weight_memory: FilterState,
    bound_memory: FilterState,
    // Samples at rest.
    at_rest: u64,
    // Sum of the squared weights.
    weight: f64,
    tile: Vec<f64>,
    in_tile: usize,
    gathered: RowBlock,
    rows: usize,
    in_current: u64,
    stretches: Stretches,
    stretch: u64,
    current: Option<Triangle>,
    done: Vec<Triangle>,
    // Change of the row's parameters by a known payload, one per entry; empty without a payload.
    carried: Vec<f64>,
    // Whether samples are kept for plots.
    keeps: bool,
    kept: Decimator<Vec<f64>>,
    kept_variance: Decimator<f64>,
    kept_bound: Decimator<f64>,
}

impl RowReduction {
    fn new(model: &Model, row: usize, probes: &[Probe]) -> Self {
        let entries = model.row_entries(row);
        let indices: Vec<usize> = (0..probes.len())
            .filter(|&i| probes[i].row() == row)
            .collect();
        let width = entries.len() + indices.len();
        Self {
            rhs: model.right_hand_side(row),
            known: model.known_deflections(row),
            bank: FilterBank::new(vec![0.0; bank_len(entries.len())]),
            probe_bank: FilterBank::new(vec![0.0; bank_len(indices.len())]),
            probed: vec![0.0; indices.len()],
            no_momentum: vec![0.0; indices.len()],
            torque_rate: (indices.iter())
                .position(|&i| matches!(probes[i], Probe::TorqueRate { .. })),
            last_rhs: 0.0,
            probes: indices,
            width,
            torque_memory: FilterState::default(),
            spring_memory: FilterState::default(),
            high_pass: (model.high_pass(row))
                .map(|high_pass| RowHighPass::new(high_pass, width + 1)),
            weights: None,
            weight_memory: FilterState::default(),
            bound_memory: FilterState::default(),
            at_rest: 0,
            weight: 0.0,
            in_tile: 0,
            tile: vec![0.0; TILE_ROWS * (width + 1)],
            gathered: RowBlock::of_width(width + 1),
            rows: 0,
            in_current: 0,
            stretches: Stretches::of(model),
            stretch: Stretches::of(model).initial_samples,
            current: None,
            done: Vec::new(),
            carried: Vec::new(),
            keeps: true,
            kept: Decimator::new(KEPT_SAMPLES),
            kept_variance: Decimator::new(KEPT_SAMPLES),
            kept_bound: Decimator::new(KEPT_SAMPLES),
            row,
            entries,
        }
    }

    fn restart(&mut self) {
        self.bank.restart();
        if let Some(high_pass) = &mut self.high_pass {
            high_pass.restart();
        }
        self.probe_bank.restart();
        self.last_rhs = 0.0;
        self.torque_memory = FilterState::default();
        self.spring_memory = FilterState::default();
        self.weight_memory = FilterState::default();
        self.bound_memory = FilterState::default();
    }

    /// Returns the weight of the next sample.
    fn weigh(&mut self, pairs: &Pairs, batch: &Batch, k: usize) -> f64 {
        let Some(weights) = &self.weights else {
            return 1.0;
        };
        let mut variance = batch.variance[k * batch.rows + self.row];
        let bound = (batch.bounds.get(k * batch.rows + self.row)).copied();
        let bound = bound.unwrap_or_default();
        if bound > 0.0 {
            variance += TransitionWeights::variance_at_rest(bound);
            self.at_rest += 1;
        }
        let memory = &mut self.weight_memory;
        let variance = pairs.entries.process(memory, 0.0, variance);
        if self.keeps {
            self.kept_variance.push(|| variance);
            let bound = pairs.entries.process(&mut self.bound_memory, 0.0, bound);
            self.kept_bound.push(|| bound);
        }
        weights.weight(self.row, variance)
    }

    /// Filters the right-hand side of the next sample. A motor torque is held, the torque of a sensor
    /// is continuous.
    fn right_hand_side(&mut self, pairs: &Pairs, batch: &Batch, k: usize) -> f64 {
        let [motor, spring] = self.rhs.torques();
        let mut rhs = 0.0;
        if let Some(joint) = motor {
            let memory = &mut self.torque_memory;
            rhs += pairs.torque.process(memory, 0.0, batch.tau[joint][k]);
        }
        if let Some(joint) = spring {
            let memory = &mut self.spring_memory;
            let torque = batch.spring[joint].get(k).copied().unwrap_or(f64::NAN);
            let spring = pairs.entries.process(memory, 0.0, torque);
            rhs += if motor.is_some() { -spring } else { spring };
        }
        rhs
    }

    /// Filters the samples of a batch and folds them into the factors.
    fn take(&mut self, pairs: &Pairs, batch: &Batch) {
        let (width, row_width) = (self.width, self.entries.len());
        let all = batch.entries;
        let samples = batch.momentum.chunks(all).zip(batch.rest.chunks(all));
        for (k, (momentum, rest)) in samples.enumerate() {
            let weight = self.weigh(pairs, batch, k);
            let mut rhs = self.right_hand_side(pairs, batch, k);
            let range = self.entries.clone();
            let filtered =
                (self.bank).process(&pairs.entries, &momentum[range.clone()], &rest[range]);
            rhs += (self.known.iter())
                .map(|&(place, value)| filtered[place] * value)
                .sum::<f64>();
            let row = &mut self.tile[self.in_tile * (width + 1)..][..=width];
            row[..row_width].copy_from_slice(filtered);
            if !self.probes.is_empty() {
                let first = k * batch.probes.len();
                for (value, probe) in self.probed.iter_mut().zip(&self.probes) {
                    *value = batch.probed[first + probe];
                }
                let bank = &mut self.probe_bank;
                let filtered = bank.process(&pairs.entries, &self.no_momentum, &self.probed);
                row[row_width..width].copy_from_slice(filtered);
                if let Some(at) = self.torque_rate {
                    row[row_width + at] = (rhs - self.last_rhs) / pairs.period;
                    self.last_rhs = rhs;
                }
            }
            let carried = row.iter().zip(&self.carried);
            row[width] = rhs - carried.map(|(entry, by)| entry * by).sum::<f64>();
            let counts = (self.high_pass.as_mut())
                .is_none_or(|high_pass| high_pass.process(row, pairs.period));
            if counts {
                self.weight += weight * weight;
            }
            if self.keeps {
                self.kept.push(|| row.to_vec());
            }
            if self.weights.is_some() {
                for entry in &mut *row {
                    *entry *= weight;
                }
            }
            self.advance();
        }
        self.untile();
    }

    /// Counts the row that was written into the tile, and factors or closes a segment when it is
    /// full.
    fn advance(&mut self) {
        self.in_tile += 1;
        self.in_current += 1;
        let full = self.rows + self.in_tile == self.gathered.capacity();
        let ended = self.in_current == self.stretch;
        if self.in_tile == TILE_ROWS || full || ended {
            self.untile();
        }
        if ended {
            self.close();
        } else if full {
            self.factor();
        }
    }

    /// Transposes the tile's rows into the columns of the gathered rows.
    fn untile(&mut self) {
        let count = std::mem::take(&mut self.in_tile);
        let width = self.width + 1;
        for column in 0..width {
            let gathered = self.gathered.column_mut(column);
            let rows = self.tile.chunks(width).take(count);
            for (entry, row) in gathered[self.rows..].iter_mut().zip(rows) {
                *entry = row[column];
            }
        }
        self.rows += count;
    }

    fn factor(&mut self) {
        let rows = std::mem::take(&mut self.rows);
        if rows == 0 {
            return;
        }
        let width = self.width + 1;
        let current = self.current.get_or_insert_with(|| Triangle::zero(width));
        current.fold(&mut self.gathered, rows);
    }

    fn close(&mut self) {
        self.factor();
        self.in_current = 0;
        self.done.extend(self.current.take());
        if self.done.len() == self.stretches.max_factors {
            self.done = joined_in_pairs(&self.done, Triangle::sum);
            self.stretch *= 2;
        }
    }
}

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
    stretches: Stretches,
    stretch: u64,
    last_time: f64,
    kept: Decimator<f64>,
    samples: u64,
    standing: Standing,
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
            stretches: Stretches::of(model),
            stretch: Stretches::of(model).initial_samples,
            last_time: 0.0,
            kept: Decimator::new(KEPT_SAMPLES),
            samples: 0,
            standing: Standing::default(),
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
        self.stretches = self.stretches.among(logs);
        self.stretch = self.stretches.initial_samples;
        for row in &mut self.rows {
            row.stretches = self.stretches;
            row.stretch = self.stretch;
        }
        self
    }

    /// Sets the number of samples that will come. Then the first segments are as long as the last,
    /// which saves most of the small factors.
    #[must_use]
    pub(crate) fn with_samples(mut self, samples: u64) -> Self {
        self.stretch = (self.stretch).max(samples / STRETCHES_OF_KNOWN_LENGTH);
        for row in &mut self.rows {
            row.stretch = self.stretch;
        }
        self
    }

    /// Keeps no samples for plots.
    #[must_use]
    pub(crate) fn without_samples(mut self) -> Self {
        for row in &mut self.rows {
            row.keeps = false;
        }
        self
    }

    /// Begins another log or continues after a gap: the filters start at rest.
    pub fn restart(&mut self) {
        self.rows.iter_mut().for_each(RowReduction::restart);
        self.standing = Standing::default();
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
        self.batch.form(signals, 0, &bounds);
        for first in (0..signals.len()).step_by(BATCH_SAMPLES) {
            let (batch, next, rows) = (&self.batch, &mut self.next, &mut self.rows);
            rayon::join(
                || next.form(signals, first + BATCH_SAMPLES, &bounds),
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
        if self.in_current == self.stretch {
            self.close();
        }
    }

    fn close(&mut self) {
        self.in_current = 0;
        self.ends.push(self.last_time);
        if self.ends.len() == self.stretches.max_factors {
            self.ends = joined_in_pairs(&self.ends, |_, end| *end);
            self.stretch *= 2;
        }
    }

    /// Ends the reduction and returns the reduced system.
    #[must_use]
    pub fn finish(mut self) -> System {
        self.rows.iter_mut().for_each(RowReduction::untile);
        if self.in_current > 0 {
            self.close();
            self.rows.iter_mut().for_each(RowReduction::close);
        }
        let weights = self.rows.iter().map(|row| row.weight).collect();
        let variance = (self.rows.iter_mut())
            .map(|row| std::mem::replace(&mut row.kept_variance, Decimator::new(KEPT_SAMPLES)))
            .map(Decimator::into_items)
            .collect();
        let bound = (self.rows.iter_mut())
            .map(|row| std::mem::replace(&mut row.kept_bound, Decimator::new(KEPT_SAMPLES)))
            .map(Decimator::into_items)
            .collect();
        let at_rest = self.rows.iter().map(|row| row.at_rest).collect();
        let (rows, kept) = (self.rows.into_iter())
            .map(|row| (row.done, row.kept.into_items()))
            .unzip();
        System {
            rows,
            weights,
            logs: vec![self.ends.len()],
            ends: self.ends,
            stretch: self.stretch,
            max_stretches: self.stretches.max_factors,
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
