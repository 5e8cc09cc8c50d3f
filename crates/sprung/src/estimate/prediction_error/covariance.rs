//! The covariance of the filter's state (coordinates, their velocities, and one
//! disturbance per row, \[3 rows\]) over a measurement and a period, and derivatives by
//! it on their way back.

use super::dynamics::{add, scale};
use super::filter::{Levels, measured};
use super::measurements::Stretch;

/// Returns the covariance at the start of a stretch, \[3 rows × 3 rows\].
pub(super) fn start_covariance(rows: usize, stretch: &Stretch, levels: &Levels) -> Vec<f64> {
    let states = 3 * rows;
    let mut covariance = vec![0.0; states * states];
    let deviations = stretch.start_deviation.iter().chain(&levels.drift);
    for (i, deviation) in deviations.enumerate() {
        covariance[i * states + i] = deviation * deviation;
    }
    covariance
}

/// Takes a measurement into a covariance; writes the covariance of the state with
/// it and returns its variance.
pub(super) fn update(
    covariance: &mut [f64],
    of: impl Iterator<Item = (usize, f64)> + Clone,
    variance: f64,
    column: &mut [f64],
) -> f64 {
    let states = column.len();
    column.fill(0.0);
    for (state, weight) in of.clone() {
        add(
            column,
            weight,
            &covariance[state * states..(state + 1) * states],
        );
    }
    let variance = variance + measured(column, of);
    for (row, own) in covariance.chunks_mut(states).zip(&*column) {
        if *own != 0.0 {
            add(row, -own / variance, column);
        }
    }
    variance
}

/// Carries a covariance over a period: `F P F^T`, where the disturbances decay.
///
/// - `transition`: \[2 rows × 3 rows\].
/// - `product`: memory for as much.
pub(super) fn propagate(
    covariance: &mut [f64],
    transition: &[f64],
    product: &mut [f64],
    left: f64,
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
            let entry = left * own[j];
            covariance[i * states + j] = entry;
            covariance[j * states + i] = entry;
        }
    }
    for row in covariance[moving * states..].chunks_mut(states) {
        scale(&mut row[moving..], left * left);
    }
}

/// Returns the number of states, \[3 rows\], of a transition, \[2 rows × 3 rows\].
fn states_of(transition: &[f64]) -> usize {
    3 * (transition.len() / 6).isqrt()
}

/// Adds what the disturbances of a period add to a covariance.
pub(super) fn disturb(covariance: &mut [f64], transition: &[f64], levels: &Levels, left: f64) {
    let states = states_of(transition);
    for (source, white) in levels.white.iter().enumerate() {
        if *white > 0.0 {
            add_white(covariance, transition, source, white * white);
        }
    }
    let moving = transition.len() / states;
    for (i, drift) in levels.drift.iter().enumerate() {
        covariance[(moving + i) * (states + 1)] += drift * drift * (1.0 - left * left);
    }
}

/// Adds the variance of one row's held torque to a covariance.
fn add_white(covariance: &mut [f64], transition: &[f64], source: usize, variance: f64) {
    let states = states_of(transition);
    let column = 2 * states / 3 + source;
    for (i, a) in transition.chunks(states).enumerate() {
        let scaled = variance * a[column];
        if scaled != 0.0 {
            for (j, b) in transition.chunks(states).enumerate() {
                covariance[i * states + j] += scaled * b[column];
            }
        }
    }
}

/// Returns the sum of products.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Carries a deviation of the state over a period.
///
/// - `memory`: \[states\].
pub(super) fn carry(x: &mut [f64], transition: &[f64], left: f64, memory: &mut [f64]) {
    let states = x.len();
    let moving = 2 * states / 3;
    for (sum, row) in memory.iter_mut().zip(transition.chunks(states)) {
        *sum = dot(row, x);
    }
    x[..moving].copy_from_slice(&memory[..moving]);
    scale(&mut x[moving..], left);
}

/// Carries a derivative by the state back over a period: `F^T r`.
pub(super) fn pull_state(weight: &mut [f64], transition: &[f64], left: f64, memory: &mut [f64]) {
    let states = weight.len();
    let moving = 2 * states / 3;
    memory.fill(0.0);
    for (factor, row) in weight.iter().zip(transition.chunks(states)) {
        add(memory, *factor, row);
    }
    for (i, own) in memory.iter_mut().enumerate().skip(moving) {
        *own += left * weight[i];
    }
    weight.copy_from_slice(memory);
}

/// Writes `F^T S`, of a symmetric derivative by the covariance.
pub(super) fn pull_product(
    by_covariance: &[f64],
    transition: &[f64],
    left: f64,
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
    add(&mut product[drifts..], left, &by_covariance[drifts..]);
}

/// Writes `(F^T S) F`, symmetric.
pub(super) fn pull(product: &[f64], transition: &[f64], left: f64, by_covariance: &mut [f64]) {
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
            *out += left * own[j];
        }
        for j in 0..i {
            by_covariance[j * states + i] = by_covariance[i * states + j];
        }
    }
}
