//! The covariance P of the filter's state over a measurement and over a period, and the derivatives
//! by P in the backward pass. The state contains the coordinates, their velocities and one
//! disturbance per row, \[3 rows\].
//!
//! F is stored without the rows of the disturbances, \[2 rows × 3 rows\]: over a period a
//! disturbance is only multiplied by `a`.

use sprung_core::linear::dot;

use super::levels::{Decay, Levels};
use super::matrix::{add_product, multiply, transpose};
use super::measurements::{Segment, observe};
use super::vector::{add, scale};
use crate::estimate::estimators::prediction_error::state_layout::{
    moving_states, state_count, transition_size,
};

/// Returns the covariance at the start of a segment, \[3 rows × 3 rows\].
pub(super) fn start_covariance(rows: usize, segment: &Segment, levels: &Levels) -> Vec<f64> {
    let states = state_count(rows);
    let mut covariance = vec![0.0; states * states];
    let deviations = segment.start_deviation.iter().chain(&levels.disturbance);
    for (i, deviation) in deviations.enumerate() {
        covariance[i * states + i] = deviation * deviation;
    }
    covariance
}

/// Updates of a covariance by the measurements of a sample, one after the other:
/// `P ← P − K S Kᵀ`. The covariance itself is updated once, by all measurements together.
#[derive(Clone, Debug, Default)]
pub(super) struct Correction {
    /// `P Hᵀ` of each measurement with the P before it, \[measurements × 3 rows\].
    cross: Vec<f64>,
    /// −K of each measurement, \[measurements × 3 rows\].
    gains: Vec<f64>,
}

impl Correction {
    /// Adds a measurement. Returns `P Hᵀ`, the covariance of the state with the measurement, and
    /// `S = H P Hᵀ + R`.
    ///
    /// - `covariance`: before the first measurement of the sample, \[states × states\].
    /// - `observation`: entries of H; `variance`: R.
    pub(super) fn measure(
        &mut self,
        covariance: &[f64],
        observation: impl Iterator<Item = (usize, f64)> + Clone,
        variance: f64,
    ) -> (&[f64], f64) {
        let states = covariance.len().isqrt();
        let before = self.cross.len();
        self.cross.resize(before + states, 0.0);
        let (earlier, cross) = self.cross.split_at_mut(before);
        for (state, weight) in observation.clone() {
            let row = &covariance[state * states..(state + 1) * states];
            add(cross, weight, row);
        }
        for (gain, earlier) in self.gains.chunks(states).zip(earlier.chunks(states)) {
            add(cross, observe(gain, observation.clone()), earlier);
        }
        let variance = variance + observe(cross, observation);
        self.gains.extend(cross.iter().map(|c| -c / variance));
        (cross, variance)
    }

    /// Updates the covariance by the measurements since the last call.
    pub(super) fn apply(&mut self, covariance: &mut [f64]) {
        let states = covariance.len().isqrt();
        add_product(&self.gains, &self.cross, states, covariance);
        self.cross.clear();
        self.gains.clear();
    }
}

/// Work memory of [`propagate`].
#[derive(Clone, Debug)]
pub(super) struct Propagation {
    /// F P, \[2 rows × 3 rows\], and Fᵀ, \[3 rows × 2 rows\].
    product: Vec<f64>,
    transposed: Vec<f64>,
    /// F P Fᵀ, \[2 rows × 2 rows\].
    moving: Vec<f64>,
}

impl Propagation {
    pub(super) fn new(rows: usize) -> Self {
        Self {
            product: vec![0.0; transition_size(rows)],
            transposed: vec![0.0; transition_size(rows)],
            moving: vec![0.0; 4 * rows * rows],
        }
    }
}

/// Propagates a covariance over a period: `F P Fᵀ + Q`. Q is the covariance that torque noise and new
/// disturbances add. Noise of a torque acts like a disturbance, but only in this period.
///
/// - `transition`: F without the rows of the disturbances, \[2 rows × 3 rows\]; `decay`: a.
/// - `reversals`: nearness of each row's friction to a reversal in this period, \[rows\].
pub(super) fn propagate(
    covariance: &mut [f64],
    transition: &[f64],
    levels: &Levels,
    reversals: &[f64],
    decay: Decay,
    memory: &mut Propagation,
) {
    let states = states_of(transition);
    let moving = transition.len() / states;
    let product = &mut memory.product;
    multiply(transition, covariance, states, product);
    for (i, row) in product.chunks(states).enumerate() {
        for (j, value) in row.iter().enumerate().skip(moving) {
            let entry = decay.factor * value;
            covariance[i * states + j] = entry;
            covariance[j * states + i] = entry;
        }
    }
    for (row, reversal) in reversals.iter().enumerate() {
        let variance = levels.torque_variance(row, *reversal);
        let at = moving + row;
        for (row, by_torque) in (product.chunks_mut(states)).zip(transition.chunks(states)) {
            row[at] += variance * by_torque[at];
        }
    }
    transpose(transition, states, &mut memory.transposed);
    multiply(product, &memory.transposed, moving, &mut memory.moving);
    for (i, row) in memory.moving.chunks(moving).enumerate() {
        for (j, entry) in row.iter().enumerate().take(i + 1) {
            covariance[i * states + j] = *entry;
            covariance[j * states + i] = *entry;
        }
    }
    for (row, values) in (covariance[moving * states..].chunks_mut(states)).enumerate() {
        scale(&mut values[moving..], decay.factor * decay.factor);
        values[moving + row] += levels.added_variance(row, decay);
    }
}

/// Returns the number of states, \[3 rows\], of a transition, \[2 rows × 3 rows\].
fn states_of(transition: &[f64]) -> usize {
    3 * (transition.len() / 6).isqrt()
}

/// Propagates a deviation of the state over a period: `F x`.
///
/// - `memory`: work memory, \[states\].
pub(super) fn propagate_state(x: &mut [f64], transition: &[f64], decay: f64, memory: &mut [f64]) {
    let states = x.len();
    let moving = moving_states(states);
    for (sum, row) in memory.iter_mut().zip(transition.chunks(states)) {
        *sum = dot(row, x);
    }
    x[..moving].copy_from_slice(&memory[..moving]);
    scale(&mut x[moving..], decay);
}

/// Propagates a derivative by the state back over a period: `Fᵀ r`.
pub(super) fn adjoint_state(
    weight: &mut [f64],
    transition: &[f64],
    decay: f64,
    memory: &mut [f64],
) {
    let states = weight.len();
    let moving = moving_states(states);
    memory.fill(0.0);
    for (factor, row) in weight.iter().zip(transition.chunks(states)) {
        add(memory, *factor, row);
    }
    for (i, entry) in memory.iter_mut().enumerate().skip(moving) {
        *entry += decay * weight[i];
    }
    weight.copy_from_slice(memory);
}

/// Work memory of [`adjoint_covariance`].
#[derive(Clone, Debug)]
pub(super) struct AdjointMemory {
    /// Fᵀ, \[3 rows × 2 rows\].
    transposed: Vec<f64>,
    /// Fᵀ D F, \[3 rows × 3 rows\].
    moved: Vec<f64>,
    /// Fᵀ D without the columns of the disturbances, \[3 rows × 2 rows\].
    moving: Vec<f64>,
}

impl AdjointMemory {
    pub(super) fn new(rows: usize) -> Self {
        Self {
            transposed: vec![0.0; transition_size(rows)],
            moved: vec![0.0; 9 * rows * rows],
            moving: vec![0.0; transition_size(rows)],
        }
    }
}

/// Writes `Fᵀ D`, where D is a symmetric derivative by the covariance.
pub(super) fn adjoint_product(
    by_covariance: &[f64],
    transition: &[f64],
    decay: f64,
    product: &mut [f64],
    memory: &mut AdjointMemory,
) {
    let states = by_covariance.len().isqrt();
    let moving = moving_states(states);
    transpose(transition, states, &mut memory.transposed);
    multiply(&memory.transposed, by_covariance, states, product);
    let drifts = moving * states;
    add(&mut product[drifts..], decay, &by_covariance[drifts..]);
}

/// Writes `(Fᵀ D) F`, which is symmetric.
pub(super) fn adjoint_covariance(
    product: &[f64],
    transition: &[f64],
    decay: f64,
    by_covariance: &mut [f64],
    memory: &mut AdjointMemory,
) {
    let states = by_covariance.len().isqrt();
    let moving = moving_states(states);
    for (row, product) in (memory.moving.chunks_mut(moving)).zip(product.chunks(states)) {
        row.copy_from_slice(&product[..moving]);
    }
    multiply(&memory.moving, transition, states, &mut memory.moved);
    for (row, product) in (memory.moved.chunks_mut(states)).zip(product.chunks(states)) {
        add(&mut row[moving..], decay, &product[moving..]);
    }
    for i in 0..states {
        for j in 0..=i {
            let entry = memory.moved[i * states + j];
            by_covariance[i * states + j] = entry;
            by_covariance[j * states + i] = entry;
        }
    }
}
