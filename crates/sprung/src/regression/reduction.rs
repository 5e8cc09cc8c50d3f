//! Rows of any number of samples, folded into a bounded number of factors.

use std::sync::Arc;

use faer::Mat;
use rayon::prelude::*;
use sprung_core::filter::{FilterBank, FilterError, FilterState, bank_len};

use super::batch::{BATCH_SAMPLES, Batch};
use super::filtered::Pairs;
use super::nuisance_momentum::NuisanceMomentum;
use super::triangle::Triangle;
use super::weights::TransitionWeights;
use crate::description::{DiscretizationName, InitialMomentum};
use crate::model::{Model, RightHandSide};
use crate::preprocess::{Decimator, SignalBlock};

/// Factors kept at most, and samples in each at first; consecutive ones are
/// merged beyond. Many parameters make large factors, of which fewer are kept.
#[derive(Clone, Copy, Debug)]
struct Stretches {
    most: usize,
    first: u64,
}

impl Stretches {
    fn of(model: &Model) -> Self {
        if model.parameters().len() <= 40 {
            Self {
                most: 512,
                first: 16,
            }
        } else {
            Self {
                most: 128,
                first: 64,
            }
        }
    }
}

/// Rows gathered before they are factored, at most.
const GATHERED_ROWS: usize = 2048;

/// Rows that are turned into columns at a time.
const TILE_ROWS: usize = 16;

/// Samples of the filtered regression that are kept for plots, at most.
const KEPT_SAMPLES: usize = 2048;

/// One row of the regressor on its way from samples to factors.
#[derive(Clone, Debug)]
struct RowReduction {
    row: usize,
    entries: std::ops::Range<usize>,
    rhs: RightHandSide,
    bank: FilterBank<Vec<f64>>,
    torque_memory: FilterState,
    weights: Option<Arc<TransitionWeights>>,
    weight_memory: FilterState,
    // Sum of the squared weights.
    weight: f64,
    // The first rows after a start, if its momentum is to be estimated.
    start: Option<NuisanceMomentum>,
    tile: Vec<f64>,
    in_tile: usize,
    gathered: Mat<f64>,
    rows: usize,
    in_current: u64,
    stretches: Stretches,
    stretch: u64,
    current: Option<Triangle>,
    done: Vec<Triangle>,
    kept: Decimator<Vec<f64>>,
    kept_variance: Decimator<f64>,
}

impl RowReduction {
    fn new(model: &Model, row: usize) -> Self {
        let entries = model.row_entries(row);
        let width = entries.len();
        Self {
            rhs: model.right_hand_side(row),
            bank: FilterBank::new(vec![0.0; bank_len(width)]),
            torque_memory: FilterState::default(),
            weights: None,
            weight_memory: FilterState::default(),
            weight: 0.0,
            start: None,
            in_tile: 0,
            tile: vec![0.0; TILE_ROWS * (width + 1)],
            gathered: Mat::zeros(GATHERED_ROWS, width + 1),
            rows: 0,
            in_current: 0,
            stretches: Stretches::of(model),
            stretch: Stretches::of(model).first,
            current: None,
            done: Vec::new(),
            kept: Decimator::new(KEPT_SAMPLES),
            kept_variance: Decimator::new(KEPT_SAMPLES),
            row,
            entries,
        }
    }

    fn restart(&mut self) {
        self.release();
        self.start = self.start.take().map(|_| NuisanceMomentum::default());
        self.bank.restart();
        self.torque_memory = FilterState::default();
        self.weight_memory = FilterState::default();
    }

    /// Returns the weight of the next sample.
    fn weigh(&mut self, pairs: &Pairs, batch: &Batch, k: usize) -> f64 {
        let Some(weights) = &self.weights else {
            return 1.0;
        };
        let variance = batch.variance[k * batch.rows + self.row];
        let memory = &mut self.weight_memory;
        let variance = pairs.entries.process(memory, 0.0, variance);
        self.kept_variance.push(|| variance);
        weights.weight(self.row, variance)
    }

    /// Filters and folds samples.
    fn take(&mut self, pairs: &Pairs, batch: &Batch) {
        let width = self.entries.len();
        let all = batch.entries;
        let samples = batch.momentum.chunks(all).zip(batch.rest.chunks(all));
        for (k, (momentum, rest)) in samples.enumerate() {
            let weight = self.weigh(pairs, batch, k);
            self.weight += weight * weight;
            let own = self.entries.clone();
            let filtered = (self.bank).process(&pairs.entries, &momentum[own.clone()], &rest[own]);
            let rhs = match self.rhs {
                RightHandSide::Zero => 0.0,
                RightHandSide::MotorTorque(joint) => {
                    let memory = &mut self.torque_memory;
                    pairs.torque.process(memory, 0.0, batch.tau[joint][k])
                }
            };
            let row = &mut self.tile[self.in_tile * (width + 1)..][..=width];
            row[..width].copy_from_slice(filtered);
            row[width] = rhs;
            self.kept.push(|| row.to_vec());
            if self.weights.is_some() {
                for entry in &mut *row {
                    *entry *= weight;
                }
            }
            let pole = pairs.entries.pole();
            let held = (self.start.as_mut()).is_some_and(|start| start.hold(row, pole, weight));
            if !held {
                self.release();
                self.advance();
            }
        }
        self.untile();
    }

    /// Counts the row that was put into the tile.
    fn advance(&mut self) {
        self.in_tile += 1;
        self.in_current += 1;
        let full = self.rows + self.in_tile == GATHERED_ROWS;
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

    /// Lets the rows go that were held back behind a start.
    fn release(&mut self) {
        let width = self.entries.len() + 1;
        let held = self
            .start
            .as_mut()
            .map(NuisanceMomentum::release)
            .unwrap_or_default();
        if held.is_empty() {
            return;
        }
        // The row that comes next stands in the tile already.
        let next = self.tile[self.in_tile * width..][..width].to_vec();
        for row in held {
            self.tile[self.in_tile * width..][..width].copy_from_slice(&row);
            self.advance();
        }
        self.tile[self.in_tile * width..][..width].copy_from_slice(&next);
    }

    /// Moves the tile's rows into the columns of the gathered rows.
    fn untile(&mut self) {
        let count = std::mem::take(&mut self.in_tile);
        let width = self.entries.len() + 1;
        for column in 0..width {
            let gathered = self.gathered.col_as_slice_mut(column);
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
        let new = Triangle::of_rows(self.gathered.as_mut().subrows_mut(0, rows));
        self.current = match self.current.take() {
            None => Some(new),
            Some(before) => Triangle::merge([&before, &new]),
        };
    }

    fn close(&mut self) {
        self.factor();
        self.in_current = 0;
        self.done.extend(self.current.take());
        if self.done.len() == self.stretches.most {
            self.done = halved(&self.done, |a, b| {
                Triangle::merge([a, b]).unwrap_or_else(|| b.clone())
            });
            self.stretch *= 2;
        }
    }
}

/// Joins neighbours.
fn halved<T: Clone>(all: &[T], join: impl Fn(&T, &T) -> T) -> Vec<T> {
    all.chunks(2)
        .map(|pair| match pair {
            [a, b] => join(a, b),
            _ => pair[0].clone(),
        })
        .collect()
}

/// Forms, filters and folds the regression of samples as they come.
///
/// Each row of the regressor touches few parameters, so each is reduced by
/// itself in its own columns; the factors are put side by side when the system
/// is solved. Samples are shared among threads while the regressor is formed,
/// rows while it is filtered and folded, so that the result does not depend on
/// the number of threads. One batch is formed while the one before is folded.
#[derive(Clone, Debug)]
pub struct Reduction {
    batch: Batch,
    next: Batch,
    rows: Vec<RowReduction>,
    // Ends of the stretches, s, kept as the rows keep their factors.
    ends: Vec<f64>,
    in_current: u64,
    stretches: Stretches,
    stretch: u64,
    last_time: f64,
    kept: Decimator<f64>,
    samples: u64,
}

impl Reduction {
    /// Returns a reduction that has seen nothing.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        let rows: Vec<usize> = (0..model.rows()).collect();
        Self::of_rows(model, &rows)
    }

    /// Returns a reduction of some rows only.
    #[must_use]
    pub fn of_rows(model: &Model, rows: &[usize]) -> Self {
        Self {
            batch: Batch::new(model, rows),
            next: Batch::new(model, rows),
            rows: (rows.iter())
                .map(|&row| RowReduction::new(model, row))
                .collect(),
            ends: Vec::new(),
            in_current: 0,
            stretches: Stretches::of(model),
            stretch: Stretches::of(model).first,
            last_time: 0.0,
            kept: Decimator::new(KEPT_SAMPLES),
            samples: 0,
        }
    }

    /// Returns the reduction of weighted samples.
    ///
    /// Weights are applied to filtered rows and their right-hand sides; samples
    /// that are kept for plots have none.
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

    /// Returns the reduction of filters that start in a given way.
    #[must_use]
    pub fn with_start(mut self, momentum: InitialMomentum) -> Self {
        let start = match momentum {
            InitialMomentum::Measured => None,
            InitialMomentum::Estimate => Some(NuisanceMomentum::default()),
        };
        for row in &mut self.rows {
            row.start.clone_from(&start);
        }
        self
    }

    /// Begins another log, or goes on after a gap: the filters start at rest.
    pub fn restart(&mut self) {
        self.rows.iter_mut().for_each(RowReduction::restart);
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
        self.batch.form(signals, 0);
        for first in (0..signals.len()).step_by(BATCH_SAMPLES) {
            let (batch, next, rows) = (&self.batch, &mut self.next, &mut self.rows);
            rayon::join(
                || next.form(signals, first + BATCH_SAMPLES),
                // Rows differ much in width: one at a time shares them best.
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
        if self.ends.len() == self.stretches.most {
            self.ends = halved(&self.ends, |_, end| *end);
            self.stretch *= 2;
        }
    }

    /// Returns what remains of the samples.
    #[must_use]
    pub fn finish(mut self) -> System {
        for row in &mut self.rows {
            row.release();
            row.untile();
        }
        if self.in_current > 0 {
            self.close();
            self.rows.iter_mut().for_each(RowReduction::close);
        }
        let weights = self.rows.iter().map(|row| row.weight).collect();
        let variance = (self.rows.iter_mut())
            .map(|row| std::mem::replace(&mut row.kept_variance, Decimator::new(KEPT_SAMPLES)))
            .map(Decimator::into_items)
            .collect();
        let (rows, kept) = (self.rows.into_iter())
            .map(|row| (row.done, row.kept.into_items()))
            .unzip();
        System {
            rows,
            weights,
            ends: self.ends,
            kept: Kept {
                time: self.kept.into_items(),
                rows: kept,
                variance,
            },
            samples: self.samples,
        }
    }
}

/// Some samples of the filtered regression, evenly spaced.
#[derive(Clone, Debug)]
pub struct Kept {
    /// Time, s.
    pub time: Vec<f64>,
    /// Entries of each row and its right-hand side, one vector per sample.
    pub rows: Vec<Vec<Vec<f64>>>,
    /// What transitions add to the variance of each row, (N·m)²; empty without
    /// weights.
    pub variance: Vec<Vec<f64>>,
}

impl Kept {
    /// Returns what the noise of the velocities leaves in a row through Coulomb
    /// transitions, as a part of its right-hand side, root mean squares; nothing
    /// without weights or without that side.
    #[must_use]
    pub fn transition_share(&self, row: usize) -> Option<f64> {
        let variance = self.variance.get(row).filter(|v| !v.is_empty())?;
        let torque: f64 = (self.rows[row].iter())
            .filter_map(|sample| sample.last())
            .map(|rhs| rhs * rhs)
            .sum();
        // A filter may swing a little below zero.
        let noise: f64 = variance.iter().map(|variance| variance.max(0.0)).sum();
        (torque > 0.0).then(|| (noise / torque).sqrt())
    }
}

/// The stacked filtered regression of all logs, reduced.
#[derive(Clone, Debug)]
pub struct System {
    // Factors of each row, stretch by stretch.
    rows: Vec<Vec<Triangle>>,
    // Sum of the squared weights of each row.
    weights: Vec<f64>,
    ends: Vec<f64>,
    kept: Kept,
    samples: u64,
}

impl System {
    /// Returns the number of samples.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Returns the sum of the squared weights of a row: the number of samples
    /// that count.
    #[must_use]
    pub fn weight(&self, row: usize) -> f64 {
        self.weights[row]
    }

    /// Returns samples for plots.
    #[must_use]
    pub fn kept(&self) -> &Kept {
        &self.kept
    }

    /// Returns one factor per row that was reduced for all samples; nothing if
    /// there are none.
    #[must_use]
    pub fn whole(&self) -> Option<Vec<Triangle>> {
        self.groups(1).pop()
    }

    /// Returns the factors of at most `count` consecutive parts of about equal
    /// length.
    #[must_use]
    pub fn groups(&self, count: usize) -> Vec<Vec<Triangle>> {
        let stretches = self.ends.len();
        let size = stretches.div_ceil(count.max(1)).max(1);
        (0..stretches)
            .step_by(size)
            .map(|first| {
                let part = first..stretches.min(first + size);
                (self.rows.iter())
                    .filter_map(|row| Triangle::merge(&row[part.clone()]))
                    .collect()
            })
            .collect()
    }

    /// Returns the factors of the samples up to ever later times, in s, at most
    /// `count` of them.
    pub fn growing(&self, count: usize) -> impl Iterator<Item = (f64, Vec<Triangle>)> {
        let size = self.ends.len().div_ceil(count.max(1)).max(1);
        let mut so_far: Option<Vec<Triangle>> = None;
        (0..self.ends.len()).step_by(size).map(move |first| {
            let part = first..self.ends.len().min(first + size);
            let end = self.ends[part.end - 1];
            let joined: Vec<Triangle> = (self.rows.iter().enumerate())
                .filter_map(|(i, row)| {
                    let before = so_far.as_ref().map(|all| &all[i]);
                    Triangle::merge(before.into_iter().chain(&row[part.clone()]))
                })
                .collect();
            so_far = Some(joined.clone());
            (end, joined)
        })
    }
}
