//! Standard errors of output error.

use faer::{Mat, Side};

use super::levenberg::Found;
use crate::estimate::statistics::HELD_OUT_PARTS;

/// Maximum number of samples of a block over which errors may be correlated, and minimum number of
/// blocks in a log.
const MAX_BLOCK_SAMPLES: usize = 250;

/// Eigenvalue of the scaled normal matrix, relative to the largest one, below which its direction
/// is flat.
const FLAT_EIGENVALUE_SHARE: f64 = 1e-11;

/// An unknown is not determined if its component in a flat direction is at least this value.
const MAX_FLAT_COMPONENT: f64 = 1e-3;

/// Returns the standard error of each unknown, \[m\]; `None` for an unknown that the residuals do
/// not determine.
///
/// It is the larger of two estimates: that of the linearisation with white noise of the stated
/// level, `(JᵀJ + prior)⁻¹`, and that of a sandwich, whose middle sums the gradient over
/// overlapping blocks of 250 samples.
///
/// # Source
///
/// Newey and West 1987: the sum over overlapping blocks is the long-run covariance with Bartlett's
/// weights.
pub(super) fn standard_errors(found: &Found, samples: usize) -> Vec<Option<f64>> {
    let m = found.x.len();
    let Some((inverse, determined)) = inverse(&found.normal) else {
        return vec![None; m];
    };
    let block = MAX_BLOCK_SAMPLES.min(samples / HELD_OUT_PARTS).max(1);
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
            Some(variance.sqrt()).filter(|error| determined[i] && error.is_finite())
        })
        .collect()
}

/// Sums the gradient of one unknown over overlapping blocks of samples.
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

/// Returns the inverse of the normal matrix without its flat directions, and whether each unknown
/// lies outside of these directions.
fn inverse(normal: &Mat<f64>) -> Option<(Mat<f64>, Vec<bool>)> {
    let m = normal.nrows();
    let norm: Vec<f64> = (0..m).map(|i| normal[(i, i)].sqrt()).collect();
    let unit = |i: usize| if norm[i] > 0.0 { norm[i] } else { 1.0 };
    let scaled = Mat::from_fn(m, m, |i, j| normal[(i, j)] / (unit(i) * unit(j)));
    let eigen = scaled.self_adjoint_eigen(Side::Lower).ok()?;
    let (vectors, values) = (eigen.U(), eigen.S().column_vector());
    let largest = (0..m).map(|k| values[k]).fold(0.0, f64::max);
    let mut inverse = Mat::<f64>::zeros(m, m);
    let mut determined = vec![true; m];
    for k in 0..m {
        let flat = values[k] <= FLAT_EIGENVALUE_SHARE * largest;
        for i in 0..m {
            if flat {
                determined[i] &= vectors[(i, k)].abs() < MAX_FLAT_COMPONENT;
                continue;
            }
            for j in 0..m {
                inverse[(i, j)] +=
                    vectors[(i, k)] * vectors[(j, k)] / (values[k] * unit(i) * unit(j));
            }
        }
    }
    Some((inverse, determined))
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    use super::super::levenberg::{Problem, minimise};
    use super::*;

    const SAMPLES: usize = 8000;

    /// Standard errors of a constant and of a parameter without influence. The noise holds each
    /// value for `hold` samples.
    fn errors(hold: usize) -> Vec<Option<f64>> {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut value = 0.0;
        let data: Vec<f64> = (0..SAMPLES)
            .map(|k| {
                if k.is_multiple_of(hold) {
                    value = rng.sample::<f64, _>(StandardNormal);
                }
                value
            })
            .collect();
        let problem = Problem {
            residuals: Box::new(|x| Some(data.iter().map(|d| d - x[0]).collect())),
            start: vec![0.5, 1.0],
            first: vec![1e-3; 2],
            largest: vec![1e-1; 2],
            prior: vec![0.0; 2],
        };
        standard_errors(&minimise(&problem).unwrap(), SAMPLES)
    }

    #[test]
    fn errors_of_a_mean_are_known() {
        let white = (SAMPLES as f64).sqrt().recip();
        let found = errors(1);
        let ratio = found[0].unwrap() / white;
        // The sum over overlapping blocks of 250 samples has a relative variance of 4/3 · 250 / 8000, and its root half
        // that deviation. The larger of two estimates is never below that of white noise.
        let scatter = 0.5 * (4.0 / 3.0 * 250.0 / SAMPLES as f64).sqrt();
        assert!((1.0..1.0 + 4.0 * scatter).contains(&ratio), "{ratio}");
        assert_eq!(found[1], None);
        // Equivalent to one independent sample in fifty.
        let ratio = errors(50)[0].unwrap() / (white * 50_f64.sqrt());
        assert!((ratio - 1.0).abs() < 4.0 * scatter, "{ratio}");
    }
}
