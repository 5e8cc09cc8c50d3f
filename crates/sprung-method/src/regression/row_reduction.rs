//! Reduces one row of the regressor from samples to factors.

use std::ops::Range;
use std::sync::Arc;

use sprung_core::filter::{FilterBank, FilterState, bank_len};

use super::batch::Batch;
use super::filtered::Pairs;
use super::high_pass::RowHighPass;
use super::probes::Probe;
use super::row_factors::RowFactors;
use super::system::KEPT_SAMPLES;
use super::weights::TransitionWeights;
use crate::description::RightHandSide;
use crate::model::Model;
use crate::preprocess::Decimator;

/// Reduces one row of the regressor from samples to factors.
#[derive(Clone, Debug)]
pub(super) struct RowReduction {
    pub(super) row: usize,
    entries: Range<usize>,
    // Number of entries and probes.
    width: usize,
    rhs: RightHandSide,
    // Places and values of stiffnesses whose torque is on the right-hand side.
    known: Vec<(usize, f64)>,
    // Change of the row's parameters by a known payload, one per entry; empty without a payload.
    pub(super) carried: Vec<f64>,
    filters: RowFilters,
    probes: RowProbes,
    pub(super) weights: Option<Arc<TransitionWeights>>,
    // Samples at rest.
    pub(super) at_rest: u64,
    // Sum of the squared weights.
    pub(super) weight: f64,
    pub(super) kept: KeptOfRow,
    pub(super) factors: RowFactors,
}

/// The filters of a row.
#[derive(Clone, Debug)]
struct RowFilters {
    bank: FilterBank<Vec<f64>>,
    torque: FilterState,
    spring: FilterState,
    weight: FilterState,
    bound: FilterState,
    // Of a joint whose instrument does not show constant deflections.
    high_pass: Option<RowHighPass>,
}

impl RowFilters {
    fn restart(&mut self) {
        self.bank.restart();
        if let Some(high_pass) = &mut self.high_pass {
            high_pass.restart();
        }
        self.torque = FilterState::default();
        self.spring = FilterState::default();
        self.weight = FilterState::default();
        self.bound = FilterState::default();
    }
}

/// The probes of a row.
#[derive(Clone, Debug)]
struct RowProbes {
    // Indices of the row's probes.
    indices: Vec<usize>,
    bank: FilterBank<Vec<f64>>,
    // The probes at one sample; their parts under d/dt are zero.
    values: Vec<f64>,
    no_momentum: Vec<f64>,
    // The rate of change of the right-hand side, if it is a probe, and the last right-hand side.
    torque_rate: Option<usize>,
    last_rhs: f64,
}

impl RowProbes {
    fn new(row: usize, probes: &[Probe]) -> Self {
        let indices: Vec<usize> = (0..probes.len())
            .filter(|&i| probes[i].row() == row)
            .collect();
        Self {
            bank: FilterBank::new(vec![0.0; bank_len(indices.len())]),
            values: vec![0.0; indices.len()],
            no_momentum: vec![0.0; indices.len()],
            torque_rate: (indices.iter())
                .position(|&i| matches!(probes[i], Probe::TorqueRate { .. })),
            last_rhs: 0.0,
            indices,
        }
    }

    fn restart(&mut self) {
        self.bank.restart();
        self.last_rhs = 0.0;
    }

    /// Writes the filtered probes of a sample with its right-hand side.
    fn fill(&mut self, pairs: &Pairs, batch: &Batch, (k, rhs): (usize, f64), out: &mut [f64]) {
        if self.indices.is_empty() {
            return;
        }
        let first = k * batch.probes.len();
        for (value, probe) in self.values.iter_mut().zip(&self.indices) {
            *value = batch.probed[first + probe];
        }
        let filtered = (self.bank).process(&pairs.entries, &self.no_momentum, &self.values);
        out.copy_from_slice(filtered);
        if let Some(at) = self.torque_rate {
            out[at] = (rhs - self.last_rhs) / pairs.period;
            self.last_rhs = rhs;
        }
    }
}

/// Samples of a row that are kept for plots.
#[derive(Clone, Debug)]
pub(super) struct KeptOfRow {
    pub(super) is_on: bool,
    pub(super) rows: Decimator<Vec<f64>>,
    pub(super) variance: Decimator<f64>,
    pub(super) bound: Decimator<f64>,
}

impl RowReduction {
    pub(super) fn new(model: &Model, row: usize, probes: &[Probe]) -> Self {
        let entries = model.row_entries(row);
        let probes = RowProbes::new(row, probes);
        let width = entries.len() + probes.indices.len();
        Self {
            rhs: model.right_hand_side(row),
            known: model.known_deflections(row),
            carried: Vec::new(),
            filters: RowFilters {
                bank: FilterBank::new(vec![0.0; bank_len(entries.len())]),
                torque: FilterState::default(),
                spring: FilterState::default(),
                weight: FilterState::default(),
                bound: FilterState::default(),
                high_pass: (model.high_pass(row))
                    .map(|high_pass| RowHighPass::new(high_pass, width + 1)),
            },
            probes,
            weights: None,
            at_rest: 0,
            weight: 0.0,
            kept: KeptOfRow {
                is_on: true,
                rows: Decimator::new(KEPT_SAMPLES),
                variance: Decimator::new(KEPT_SAMPLES),
                bound: Decimator::new(KEPT_SAMPLES),
            },
            factors: RowFactors::new(model, width + 1),
            width,
            row,
            entries,
        }
    }

    pub(super) fn restart(&mut self) {
        self.filters.restart();
        self.probes.restart();
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
        let memory = &mut self.filters.weight;
        let variance = pairs.entries.process(memory, 0.0, variance);
        if self.kept.is_on {
            self.kept.variance.push(|| variance);
            let bound = pairs.entries.process(&mut self.filters.bound, 0.0, bound);
            self.kept.bound.push(|| bound);
        }
        weights.weight(self.row, variance)
    }

    /// Filters the right-hand side of the next sample. A motor torque is held, the torque of a sensor
    /// is continuous.
    fn right_hand_side(&mut self, pairs: &Pairs, batch: &Batch, k: usize) -> f64 {
        let [motor, spring] = self.rhs.torques();
        let mut rhs = 0.0;
        if let Some(joint) = motor {
            let memory = &mut self.filters.torque;
            rhs += pairs.torque.process(memory, 0.0, batch.tau[joint][k]);
        }
        if let Some(joint) = spring {
            let memory = &mut self.filters.spring;
            let torque = batch.spring[joint].get(k).copied().unwrap_or(f64::NAN);
            let spring = pairs.entries.process(memory, 0.0, torque);
            rhs += if motor.is_some() { -spring } else { spring };
        }
        rhs
    }

    /// Filters the samples of a batch and folds them into the factors.
    pub(super) fn take(&mut self, pairs: &Pairs, batch: &Batch) {
        let (width, row_width) = (self.width, self.entries.len());
        let all = batch.entries;
        let samples = batch.momentum.chunks(all).zip(batch.rest.chunks(all));
        for (k, (momentum, rest)) in samples.enumerate() {
            let weight = self.weigh(pairs, batch, k);
            let mut rhs = self.right_hand_side(pairs, batch, k);
            let range = self.entries.clone();
            let filtered =
                (self.filters.bank).process(&pairs.entries, &momentum[range.clone()], &rest[range]);
            rhs += (self.known.iter())
                .map(|&(place, value)| filtered[place] * value)
                .sum::<f64>();
            let row = self.factors.next_row();
            row[..row_width].copy_from_slice(filtered);
            self.probes
                .fill(pairs, batch, (k, rhs), &mut row[row_width..width]);
            let carried = row.iter().zip(&self.carried);
            row[width] = rhs - carried.map(|(entry, by)| entry * by).sum::<f64>();
            let counts = (self.filters.high_pass.as_mut())
                .is_none_or(|high_pass| high_pass.process(row, pairs.period));
            if counts {
                self.weight += weight * weight;
            }
            if self.kept.is_on {
                self.kept.rows.push(|| row.to_vec());
            }
            if self.weights.is_some() {
                for entry in &mut *row {
                    *entry *= weight;
                }
            }
            self.factors.advance();
        }
        self.factors.untile();
    }
}
