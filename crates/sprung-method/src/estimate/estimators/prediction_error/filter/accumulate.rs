//! Sums over the innovations: cost, likelihood, normal equations.

use super::measure::Innovation;
use crate::estimate::estimators::prediction_error::matrix::add_squares;
use crate::estimate::estimators::prediction_error::vector::add;

/// Limit of a whitened innovation in the cost, so that a single bad sample does not dominate.
pub(super) const MAX_WHITENED_INNOVATION: f64 = 1e4;

/// Normal equations of the unknowns.
#[derive(Clone, Debug)]
pub(in super::super) struct NormalEquations {
    /// Number of unknowns.
    pub(in super::super) count: usize,
    /// Information, \[count × count\]; only the lower triangle is filled.
    pub(in super::super) information: Vec<f64>,
    /// Gradient of half the cost, \[count\].
    pub(in super::super) gradient: Vec<f64>,
}

impl NormalEquations {
    /// Returns the normal equations of no measurement.
    pub(in super::super) fn zero(count: usize) -> Self {
        Self {
            count,
            information: vec![0.0; count * count],
            gradient: vec![0.0; count],
        }
    }

    /// Returns the difference from earlier sums.
    pub(in super::super) fn without(&self, before: &Self) -> Self {
        let minus = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect();
        Self {
            count: self.count,
            information: minus(&self.information, &before.information),
            gradient: minus(&self.gradient, &before.gradient),
        }
    }

    /// Adds other normal equations.
    fn append(&mut self, other: &Self) {
        add(&mut self.information, 1.0, &other.information);
        add(&mut self.gradient, 1.0, &other.gradient);
    }

    /// Returns the normal equations of the first unknowns.
    pub(in super::super) fn first(&self, count: usize) -> Self {
        let rows = self.information.chunks(self.count.max(1)).take(count);
        Self {
            count,
            information: rows.flat_map(|row| &row[..count]).copied().collect(),
            gradient: self.gradient[..count].to_vec(),
        }
    }
}

/// Sums over the innovations of a run.
#[derive(Clone, Debug)]
pub(in super::super) struct Sums {
    /// Sum of the squared whitened innovations, V.
    pub(in super::super) cost: f64,
    /// Minus the logarithm of the likelihood, without its constant, L.
    pub(in super::super) loss: f64,
    /// Number of measurements.
    pub(in super::super) measurements: u64,
    pub(in super::super) normal: NormalEquations,
    /// The normal equations after growing parts of the samples: end of the part, s, and sums up to
    /// there.
    pub(in super::super) growing: Vec<(f64, NormalEquations)>,
    /// The gradient after growing parts of the samples.
    pub(in super::super) gradients: Vec<Vec<f64>>,
    /// The normal equations of each log alone.
    pub(in super::super) logs: Vec<NormalEquations>,
    before_log: NormalEquations,
    /// Whitened derivatives that the information does not contain yet, \[innovations × unknowns\].
    pending: Vec<f64>,
}

/// Number of innovations whose derivatives are added to the information at once.
const PENDING: usize = 32;

impl Sums {
    pub(super) fn new(unknowns: usize) -> Self {
        Self {
            cost: 0.0,
            loss: 0.0,
            measurements: 0,
            normal: NormalEquations::zero(unknowns),
            growing: Vec::new(),
            gradients: Vec::new(),
            logs: Vec::new(),
            before_log: NormalEquations::zero(unknowns),
            pending: Vec::with_capacity(PENDING * unknowns),
        }
    }

    /// Adds an innovation.
    ///
    /// ```text
    /// V ← V + e²/S                       L ← L + e²/(2S) + ln(S)/2
    /// I ← I + (∂e/∂z)ᵀ (∂e/∂z) / S       g ← g + (∂e/∂z)ᵀ e / S
    /// ```
    pub(super) fn accumulate(&mut self, innovation: &Innovation<'_>) {
        let whitened = whitened(innovation.value / innovation.deviation);
        self.cost += whitened * whitened;
        self.loss += 0.5 * whitened * whitened + innovation.deviation.ln();
        self.measurements += 1;
        let weight = 1.0 / innovation.deviation;
        add(
            &mut self.normal.gradient,
            weight * weight * innovation.value,
            innovation.gradient,
        );
        (self.pending).extend(innovation.gradient.iter().map(|entry| weight * entry));
        if self.pending.len() == PENDING * self.normal.count {
            self.complete();
        }
    }

    /// Adds the pending derivatives to the information.
    pub(super) fn complete(&mut self) {
        let normal = &mut self.normal;
        add_squares(&self.pending, normal.count, &mut normal.information);
        self.pending.clear();
    }

    /// Stores a copy of the sums up to now.
    ///
    /// - `time`: end of the samples, s.
    pub(super) fn keep(&mut self, time: f64) {
        self.complete();
        self.growing.push((time, self.normal.clone()));
    }

    /// Stores a copy of the gradient up to now.
    pub(super) fn keep_gradient(&mut self) {
        self.gradients.push(self.normal.gradient.clone());
    }

    /// Adds the complete sums of the next segment.
    pub(super) fn append(&mut self, next: Self) {
        for (time, mut normal) in next.growing {
            normal.append(&self.normal);
            self.growing.push((time, normal));
        }
        for mut gradient in next.gradients {
            add(&mut gradient, 1.0, &self.normal.gradient);
            self.gradients.push(gradient);
        }
        self.cost += next.cost;
        self.loss += next.loss;
        self.measurements += next.measurements;
        self.normal.append(&next.normal);
    }

    /// Stores the sums of the log that ends here.
    pub(super) fn end_log(&mut self) {
        self.logs.push(self.normal.without(&self.before_log));
        self.before_log = self.normal.clone();
    }
}

/// Limits a whitened innovation.
pub(super) fn whitened(innovation: f64) -> f64 {
    innovation.clamp(-MAX_WHITENED_INNOVATION, MAX_WHITENED_INNOVATION)
}
