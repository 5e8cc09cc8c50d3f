//! The covariance P of the filter's state over a measurement and over a period, and the derivatives
//! by P in the backward pass. The state contains the coordinates, their velocities and one
//! disturbance per row, \[3 rows\].
//!
//! F is stored without the rows of the disturbances, \[2 rows × 3 rows\]: over a period a
//! disturbance is only multiplied by `a`.

use super::levels::{Decay, Levels};
use super::measurements::{Segment, observe};
use super::vector::{add, dot, scale};

/// Returns the covariance at the start of a segment, \[3 rows × 3 rows\].
pub(super) fn start_covariance(rows: usize, segment: &Segment, levels: &Levels) -> Vec<f64> {
    let states = 3 * rows;
    let mut covariance = vec![0.0; states * states];
    let deviations = segment.start_deviation.iter().chain(&levels.disturbance);
    for (i, deviation) in deviations.enumerate() {
        covariance[i * states + i] = deviation * deviation;
    }
    covariance
}

/// Updates a covariance by a measurement: `P ← P − K S Kᵀ`. Writes `P Hᵀ`, the covariance of the
/// state with the measurement, and returns `S = H P Hᵀ + R`.
///
/// - `observation`: entries of H; `variance`: R.
pub(super) fn measurement_update(
    covariance: &mut [f64],
    observation: impl Iterator<Item = (usize, f64)> + Clone,
    variance: f64,
    cross_covariance: &mut [f64],
) -> f64 {
    let states = cross_covariance.len();
    cross_covariance.fill(0.0);
    for (state, weight) in observation.clone() {
        let own = &covariance[state * states..(state + 1) * states];
        add(cross_covariance, weight, own);
    }
    let variance = variance + observe(cross_covariance, observation);
    for (row, own) in covariance.chunks_mut(states).zip(&*cross_covariance) {
        if *own != 0.0 {
            add(row, -own / variance, cross_covariance);
        }
    }
    variance
}

/// Propagates a covariance over a period: `F P Fᵀ`.
///
/// - `transition`: F without the rows of the disturbances, \[2 rows × 3 rows\]; `decay`: a.
/// - `product`: work memory, \[2 rows × 3 rows\].
pub(super) fn propagate(
    covariance: &mut [f64],
    transition: &[f64],
    product: &mut [f64],
    decay: f64,
) {
    let states = states_of(transition);
    let moving = transition.len() / states;
    product.fill(0.0);
    for (out, row) in product.chunks_mut(states).zip(transition.chunks(states)) {
        for (factor, row) in row.iter().zip(covariance.chunks(states)) {
            if *factor != 0.0 {
                add(out, *factor, row);
            }
        }
    }
    for (i, own) in product.chunks(states).enumerate() {
        for (j, row) in transition.chunks(states).take(i + 1).enumerate() {
            let entry: f64 = own.iter().zip(row).map(|(a, b)| a * b).sum();
            covariance[i * states + j] = entry;
            covariance[j * states + i] = entry;
        }
        for j in moving..states {
            let entry = decay * own[j];
            covariance[i * states + j] = entry;
            covariance[j * states + i] = entry;
        }
    }
    for row in covariance[moving * states..].chunks_mut(states) {
        scale(&mut row[moving..], decay * decay);
    }
}

/// Returns the number of states, \[3 rows\], of a transition, \[2 rows × 3 rows\].
fn states_of(transition: &[f64]) -> usize {
    3 * (transition.len() / 6).isqrt()
}

/// Adds Q: the covariance that torque noise and new disturbances add in a period.
///
/// - `reversals`: how near each row's friction is to a reversal in this period, \[rows\].
pub(super) fn add_process_noise(
    covariance: &mut [f64],
    transition: &[f64],
    levels: &Levels,
    reversals: &[f64],
    decay: Decay,
) {
    let states = states_of(transition);
    for (row, reversal) in reversals.iter().enumerate() {
        let variance = levels.torque_variance(row, *reversal);
        if variance > 0.0 {
            add_torque_noise(covariance, transition, row, variance);
        }
    }
    let moving = transition.len() / states;
    for row in 0..levels.disturbance.len() {
        covariance[(moving + row) * (states + 1)] += levels.added_variance(row, decay);
    }
}

/// Adds the effect of one row's torque variance over a period.
fn add_torque_noise(covariance: &mut [f64], transition: &[f64], row: usize, variance: f64) {
    let states = states_of(transition);
    let column = 2 * states / 3 + row;
    for (i, a) in transition.chunks(states).enumerate() {
        let scaled = variance * a[column];
        if scaled != 0.0 {
            for (j, b) in transition.chunks(states).enumerate() {
                covariance[i * states + j] += scaled * b[column];
            }
        }
    }
}

/// Propagates a deviation of the state over a period: `F x`.
///
/// - `memory`: work memory, \[states\].
pub(super) fn propagate_state(x: &mut [f64], transition: &[f64], decay: f64, memory: &mut [f64]) {
    let states = x.len();
    let moving = 2 * states / 3;
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
    let moving = 2 * states / 3;
    memory.fill(0.0);
    for (factor, row) in weight.iter().zip(transition.chunks(states)) {
        add(memory, *factor, row);
    }
    for (i, own) in memory.iter_mut().enumerate().skip(moving) {
        *own += decay * weight[i];
    }
    weight.copy_from_slice(memory);
}

/// Writes `Fᵀ D`, where D is a symmetric derivative by the covariance.
pub(super) fn adjoint_product(
    by_covariance: &[f64],
    transition: &[f64],
    decay: f64,
    product: &mut [f64],
) {
    let states = by_covariance.len().isqrt();
    let moving = 2 * states / 3;
    product.fill(0.0);
    let rows = by_covariance.chunks(states);
    for (row, own) in transition.chunks(states).zip(rows) {
        for (factor, out) in row.iter().zip(product.chunks_mut(states)) {
            if *factor != 0.0 {
                add(out, *factor, own);
            }
        }
    }
    let drifts = moving * states;
    add(&mut product[drifts..], decay, &by_covariance[drifts..]);
}

/// Writes `(Fᵀ D) F`, which is symmetric.
pub(super) fn adjoint_covariance(
    product: &[f64],
    transition: &[f64],
    decay: f64,
    by_covariance: &mut [f64],
) {
    let states = by_covariance.len().isqrt();
    let moving = 2 * states / 3;
    for i in 0..states {
        let own = &product[i * states..(i + 1) * states];
        let out = &mut by_covariance[i * states..=i * states + i];
        out.fill(0.0);
        for (factor, row) in own.iter().zip(transition.chunks(states)) {
            if *factor != 0.0 {
                add(out, *factor, row);
            }
        }
        for (j, out) in out.iter_mut().enumerate().skip(moving) {
            *out += decay * own[j];
        }
        for j in 0..i {
            by_covariance[j * states + i] = by_covariance[i * states + j];
        }
    }
}
