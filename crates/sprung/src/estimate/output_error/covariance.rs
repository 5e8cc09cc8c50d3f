//! How sure output error is.

use faer::{Mat, Side};

use super::levenberg::Found;

/// Samples of a block over which errors may be correlated, at most; and blocks
/// that a log holds, at least.
const BLOCK: usize = 250;
const BLOCKS: usize = 8;

/// Eigenvalue of the scaled normal matrix, as a part of the largest, that
/// counts as none.
const FLAT: f64 = 1e-11;

/// Part of a flat direction that makes an unknown one that is not seen.
const BLIND: f64 = 1e-3;

/// Returns the standard error of each unknown, \[m\]; nothing for one that the
/// residuals do not show.
///
/// The larger of two: that of the linearisation for white noise of the stated
/// level, `(JᵀJ + prior)⁻¹`, and that of a sandwich whose middle sums the
/// gradient over overlapping blocks of 250 samples.
///
/// # Source
///
/// Newey and West 1987: the sum over overlapping blocks is the long-run
/// covariance with Bartlett's weights.
pub(super) fn standard_errors(found: &Found, samples: usize) -> Vec<Option<f64>> {
    let m = found.x.len();
    let Some((inverse, seen)) = inverse(&found.normal) else {
        return vec![None; m];
    };
    let block = BLOCK.min(samples / BLOCKS).max(1);
    let sums: Vec<Vec<f64>> = (found.jacobian.iter())
        .map(|column| block_sums(column, &found.residuals, samples, block))
        .collect();
    let middle = Mat::from_fn(m, m, |i, j| {
        let products = sums[i].iter().zip(&sums[j]).map(|(a, b)| a * b);
        products.sum::<f64>() / block as f64
    });
    let sandwich = &inverse * &middle * &inverse;
    (0..m)
        .map(|i| {
            let variance = inverse[(i, i)].max(sandwich[(i, i)]);
            Some(variance.sqrt()).filter(|error| seen[i] && error.is_finite())
        })
        .collect()
}

/// Sums of the gradient of one unknown over overlapping blocks of samples.
fn block_sums(column: &[f64], residuals: &[f64], samples: usize, block: usize) -> Vec<f64> {
    let mut gradient = vec![0.0; samples];
    for (j, r) in column.chunks(samples).zip(residuals.chunks(samples)) {
        for (sum, (j, r)) in gradient.iter_mut().zip(j.iter().zip(r)) {
            *sum += j * r;
        }
    }
    let mut running = 0.0;
    let mut sums = Vec::with_capacity(samples);
    for k in 0..samples {
        running += gradient[k];
        if k >= block {
            running -= gradient[k - block];
        }
        if k + 1 >= block {
            sums.push(running);
        }
    }
    sums
}

/// Returns the inverse without the directions that nothing shows, and which
/// unknowns stand outside of these.
fn inverse(normal: &Mat<f64>) -> Option<(Mat<f64>, Vec<bool>)> {
    let m = normal.nrows();
    let norm: Vec<f64> = (0..m).map(|i| normal[(i, i)].sqrt()).collect();
    let unit = |i: usize| if norm[i] > 0.0 { norm[i] } else { 1.0 };
    let scaled = Mat::from_fn(m, m, |i, j| normal[(i, j)] / (unit(i) * unit(j)));
    let eigen = scaled.self_adjoint_eigen(Side::Lower).ok()?;
    let (vectors, values) = (eigen.U(), eigen.S().column_vector());
    let largest = (0..m).map(|k| values[k]).fold(0.0, f64::max);
    let mut inverse = Mat::<f64>::zeros(m, m);
    let mut seen = vec![true; m];
    for k in 0..m {
        let flat = values[k] <= FLAT * largest;
        for i in 0..m {
            if flat {
                seen[i] &= vectors[(i, k)].abs() < BLIND;
                continue;
            }
            for j in 0..m {
                inverse[(i, j)] +=
                    vectors[(i, k)] * vectors[(j, k)] / (values[k] * unit(i) * unit(j));
            }
        }
    }
    Some((inverse, seen))
}
