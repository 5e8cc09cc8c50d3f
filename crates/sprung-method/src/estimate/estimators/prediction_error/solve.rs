//! Solution of small symmetric systems.

use crate::estimate::statistics::RIDGE;
use faer::linalg::solvers::{DenseSolveCore, Solve};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par, Side};

/// Returns the information scaled to unit diagonal, and the scale factors. An unknown without
/// information keeps its scale.
fn scaled(information: &[f64], count: usize, damping: f64) -> (Mat<f64>, Vec<f64>) {
    let scales: Vec<f64> = (0..count)
        .map(|i| {
            let diagonal = information[i * count + i];
            if diagonal > 0.0 {
                1.0 / diagonal.sqrt()
            } else {
                1.0
            }
        })
        .collect();
    let matrix = Mat::from_fn(count, count, |i, j| {
        let (row, column) = (i.max(j), i.min(j));
        let entry = information[row * count + column] * scales[i] * scales[j];
        if i == j {
            entry * (1.0 + damping) + RIDGE
        } else {
            entry
        }
    });
    (matrix, scales)
}

/// Returns the minimum of a quadratic model, where the damping increases the diagonal by a fraction
/// of itself. Returns `None` if the model is not convex.
///
/// - `information`: \[count × count\]; only the lower triangle is read.
/// - `gradient`: \[count\].
pub(super) fn damped_step(information: &[f64], gradient: &[f64], damping: f64) -> Option<Vec<f64>> {
    let count = gradient.len();
    if count == 0 {
        return Some(Vec::new());
    }
    let (matrix, scales) = scaled(information, count, damping);
    let rhs = Mat::from_fn(count, 1, |i, _| -gradient[i] * scales[i]);
    let x = matrix.llt(Side::Lower).ok()?.solve(&rhs);
    let step: Vec<f64> = (0..count).map(|i| x[(i, 0)] * scales[i]).collect();
    step.iter().all(|x| x.is_finite()).then_some(step)
}

/// Returns the inverse of an information matrix, \[count × count\]; `None` if it is singular.
pub(super) fn covariance(information: &[f64], count: usize) -> Option<Vec<f64>> {
    let (matrix, scales) = scaled(information, count, 0.0);
    let inverse = matrix.llt(Side::Lower).ok()?.inverse();
    let mut covariance = vec![0.0; count * count];
    for i in 0..count {
        for j in 0..count {
            covariance[i * count + j] = inverse[(i, j)] * scales[i] * scales[j];
        }
    }
    covariance
        .iter()
        .all(|x| x.is_finite())
        .then_some(covariance)
}

/// Returns the largest eigenvalue of `part` relative to `whole`, the largest `xᵀ P x / xᵀ W x`; `None`
/// if `whole` is not positive definite.
///
/// - `part`, `whole`: \[count × count\]; only the lower triangles are read.
pub(super) fn largest_relative_eigenvalue(
    part: &[f64],
    whole: &[f64],
    count: usize,
) -> Option<f64> {
    if count == 0 {
        return Some(0.0);
    }
    let (matrix, scales) = scaled(whole, count, 0.0);
    let factor = matrix.llt(Side::Lower).ok()?;
    let whiten = |matrix: &mut Mat<f64>| {
        solve_lower_triangular_in_place(factor.L(), matrix.as_mut(), Par::Seq);
    };
    let mut scaled_part = Mat::from_fn(count, count, |i, j| {
        part[i.max(j) * count + i.min(j)] * scales[i] * scales[j]
    });
    whiten(&mut scaled_part);
    let mut both = scaled_part.transpose().to_owned();
    whiten(&mut both);
    let eigenvalues = both.self_adjoint_eigenvalues(Side::Lower).ok()?;
    eigenvalues.last().copied()
}

/// Returns the length of a step in standard errors: the square root of the quadratic form of the
/// information.
pub(super) fn length(information: &[f64], step: &[f64]) -> f64 {
    let count = step.len();
    let mut sum = 0.0;
    for i in 0..count {
        let off: f64 = (0..i).map(|j| information[i * count + j] * step[j]).sum();
        sum += step[i] * (2.0 * off + information[i * count + i] * step[i]);
    }
    sum.max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn step_reaches_the_minimum_of_a_quadratic() {
        // The gradient of half x^T A x - b^T x at zero is -b. The upper triangle is not read.
        let a = [4.0, f64::NAN, 2.0, 10.0];
        let step = damped_step(&a, &[-8.0, -14.0], 0.0).unwrap();
        assert!((step[0] - 13.0 / 9.0).abs() < 1e-9 && (step[1] - 10.0 / 9.0).abs() < 1e-9);
        let quadratic =
            4.0 * step[0] * step[0] + 4.0 * step[0] * step[1] + 10.0 * step[1] * step[1];
        assert!((length(&a, &step) - quadratic.sqrt()).abs() < 1e-9);
        let inverse = covariance(&a, 2).unwrap();
        for (found, expected) in inverse.iter().zip([10.0, -2.0, -2.0, 4.0]) {
            assert!((found - expected / 36.0).abs() < 1e-9);
        }
        assert!(damped_step(&[1.0, 0.0, 2.0, 1.0], &[1.0, 1.0], 0.0).is_none());
    }
}
