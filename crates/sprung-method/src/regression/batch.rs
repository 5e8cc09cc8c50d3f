//! The regressor of a batch of samples.

use std::sync::Arc;

use rayon::prelude::*;
use sprung_core::covariate::Covariate;
use sprung_core::drives::State;

use super::filtered::Evaluator;
use super::probes::Probe;
use super::weights::TransitionWeights;
use crate::model::Model;
use crate::preprocess::SignalBlock;

/// Samples in a batch, chosen so that its regressor fits a processor's cache.
pub(super) const BATCH_SAMPLES: usize = 64;

/// Samples that a thread forms as one portion of a batch.
const THREAD_SAMPLES: usize = 8;

/// The regressor of a batch of samples.
#[derive(Clone, Debug)]
pub(super) struct Batch {
    evaluators: Vec<Evaluator>,
    pub(super) entries: usize,
    // [samples × entries], sample after sample.
    pub(super) momentum: Vec<f64>,
    pub(super) rest: Vec<f64>,
    // Motor torques, [n × samples].
    pub(super) tau: Vec<Vec<f64>>,
    // Torques of springs, [n × samples]; empty for a joint without torque sensor.
    pub(super) spring: Vec<Vec<f64>>,
    pub(super) weights: Option<Arc<TransitionWeights>>,
    pub(super) rows: usize,
    // Variance that Coulomb transitions add to each row, [samples × rows]; empty without weights.
    pub(super) variance: Vec<f64>,
    // Largest friction at rest, [samples × rows]; empty if no sample is at rest.
    pub(super) bounds: Vec<f64>,
    pub(super) probes: Arc<[Probe]>,
    // The probes before they are filtered, [samples × probes].
    pub(super) probed: Vec<f64>,
}

impl Batch {
    pub(super) fn new(model: &Model, rows: &[usize], probes: &Arc<[Probe]>) -> Self {
        let entries = model.entries();
        Self {
            evaluators: vec![Evaluator::of_rows(model, rows); BATCH_SAMPLES / THREAD_SAMPLES],
            entries,
            momentum: Vec::new(),
            rest: Vec::new(),
            tau: vec![Vec::new(); model.joint_count()],
            spring: vec![Vec::new(); model.joint_count()],
            weights: None,
            rows: model.rows(),
            variance: Vec::new(),
            bounds: Vec::new(),
            probes: Arc::clone(probes),
            probed: Vec::new(),
        }
    }

    /// Forms the regressor of up to [`BATCH_SAMPLES`] samples from `first` on; the batch is empty
    /// if `first` is beyond the last sample.
    ///
    /// - `(bounds, elements)`: largest friction at rest, \[samples × rows\], and elements of all
    ///   samples, each may be empty.
    pub(super) fn form(
        &mut self,
        signals: &SignalBlock,
        first: usize,
        (bounds, elements): (&[f64], &[f64]),
    ) {
        let count = BATCH_SAMPLES.min(signals.len().saturating_sub(first));
        self.momentum.resize(count * self.entries, 0.0);
        self.rest.resize(count * self.entries, 0.0);
        // Without weights this is zero, and no variances are stored.
        let per_sample = self.weights.as_ref().map_or(0, |_| self.rows);
        self.variance.resize(BATCH_SAMPLES * per_sample.max(1), 0.0);
        if count == 0 {
            return;
        }
        self.form_probes((signals, elements), first, count);
        self.bounds.clear();
        if !bounds.is_empty() {
            let of_batch = &bounds[first * self.rows..(first + count) * self.rows];
            self.bounds.extend_from_slice(of_batch);
        }
        for (column, tau) in self.tau.iter_mut().zip(&signals.tau) {
            column.clear();
            column.extend_from_slice(&tau[first..first + count]);
        }
        for (column, spring) in self.spring.iter_mut().zip(&signals.spring) {
            column.clear();
            column.extend_from_slice(spring.get(first..first + count).unwrap_or_default());
        }
        let part = THREAD_SAMPLES * self.entries;
        let momentum = self.momentum.par_chunks_mut(part);
        let rest = self.rest.par_chunks_mut(part);
        let variance = (self.variance).par_chunks_mut(THREAD_SAMPLES * per_sample.max(1));
        let weights = self.weights.as_deref();
        (momentum
            .zip(rest)
            .zip(variance)
            .zip(&mut self.evaluators)
            .enumerate())
        .for_each(|(portion, (((momentum, rest), variance), evaluator))| {
            let n = signals.q.len();
            let mut state = vec![0.0; VALUES_PER_JOINT * n];
            let from = first + portion * THREAD_SAMPLES;
            let until = (first + count).min(from + THREAD_SAMPLES);
            let rows = (momentum.chunks_mut(self.entries)).zip(rest.chunks_mut(self.entries));
            let variances = variance.chunks_mut(per_sample.max(1));
            for ((k, (momentum, rest)), variance) in (from..until).zip(rows).zip(variances) {
                let state = state_at((signals, elements), k, &mut state);
                let acceleration = accelerations_at(signals, k);
                evaluator.entries(&state, &acceleration, momentum, rest);
                if let Some(weights) = weights {
                    weights.variances(&evaluator.model, &state, variance);
                }
            }
        });
    }

    pub(super) fn model(&self) -> &Model {
        &self.evaluators[0].model
    }

    /// Forms the probes of `count` samples.
    fn form_probes(
        &mut self,
        (signals, elements): (&SignalBlock, &[f64]),
        first: usize,
        count: usize,
    ) {
        let Some(evaluator) = self.evaluators.first().filter(|_| !self.probes.is_empty()) else {
            return;
        };
        self.probed.clear();
        let mut memory = vec![0.0; VALUES_PER_JOINT * signals.q.len()];
        for k in first..first + count {
            let state = state_at((signals, elements), k, &mut memory);
            let columns = self.probes.iter();
            let columns = columns.map(|probe| probe.column(&evaluator.model, &state, signals, k));
            self.probed.extend(columns);
        }
    }
}

/// Positions, velocities and covariates of a joint.
const VALUES_PER_JOINT: usize = 4 + Covariate::COUNT;

/// Returns the accelerations of the links in one sample, \[n\]; empty if the signals have none.
fn accelerations_at(signals: &SignalBlock, k: usize) -> Vec<f64> {
    let all = signals.ddq.iter().map(|column| column.get(k).copied());
    all.collect::<Option<Vec<f64>>>().unwrap_or_default()
}

/// Copies one sample into `memory`, \[[`VALUES_PER_JOINT`] n\], and returns it.
fn state_at<'m>(
    (signals, elements): (&SignalBlock, &'m [f64]),
    k: usize,
    memory: &'m mut [f64],
) -> State<'m> {
    let n = signals.q.len();
    let per_sample = elements.len() / signals.len().max(1);
    for joint in 0..n {
        memory[joint] = signals.q[joint][k];
        memory[n + joint] = signals.dq[joint][k];
        memory[2 * n + joint] = signals.phi[joint][k];
        memory[3 * n + joint] = signals.dphi[joint][k];
    }
    for (value, column) in memory[4 * n..].iter_mut().zip(&signals.excess) {
        *value = column.get(k).copied().unwrap_or(0.0);
    }
    let (link, motor) = memory.split_at(2 * n);
    State {
        q: &link[..n],
        dq: &link[n..],
        phi: &motor[..n],
        dphi: &motor[n..2 * n],
        excess: &motor[2 * n..],
        elements: &elements[k * per_sample..(k + 1) * per_sample],
    }
}
