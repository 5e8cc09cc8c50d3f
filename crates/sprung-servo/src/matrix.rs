//! Symmetric equations of the unknown parameters.

use sprung_core::linear::{factor, invert, solve};

/// Returns `x` of `(a + damping · diag a) x = b`, or `None` if the matrix is not positive definite.
///
/// - `a`: \[n × n\], row by row; `b`: \[n\].
pub(super) fn damped(a: &[f64], b: &[f64], damping: f64) -> Option<Vec<f64>> {
    let n = b.len();
    let scale = scales(a, n);
    let mut scaled = equilibrated(a, &scale);
    for i in 0..n {
        scaled[i * n + i] += damping;
    }
    let mut x: Vec<f64> = b.iter().zip(&scale).map(|(b, scale)| b * scale).collect();
    if !factor(&mut scaled, n) {
        return None;
    }
    solve(&scaled, &mut x);
    for (x, scale) in x.iter_mut().zip(&scale) {
        *x *= scale;
    }
    x.iter().all(|x| x.is_finite()).then_some(x)
}

/// Returns the inverse, or `None` if the matrix is not positive definite.
pub(super) fn inverse(a: &[f64], n: usize) -> Option<Vec<f64>> {
    let scale = scales(a, n);
    let mut scaled = equilibrated(a, &scale);
    if !factor(&mut scaled, n) {
        return None;
    }
    let mut inverse = vec![0.0; n * n];
    invert(&scaled, n, &mut inverse);
    for i in 0..n {
        for j in 0..n {
            inverse[i * n + j] *= scale[i] * scale[j];
        }
    }
    inverse.iter().all(|x| x.is_finite()).then_some(inverse)
}

/// Returns the reciprocal roots of the diagonal.
fn scales(a: &[f64], n: usize) -> Vec<f64> {
    (0..n)
        .map(|i| 1.0 / a[i * n + i].max(f64::MIN_POSITIVE).sqrt())
        .collect()
}

fn equilibrated(a: &[f64], scale: &[f64]) -> Vec<f64> {
    let n = scale.len();
    let mut scaled = a.to_vec();
    for i in 0..n {
        for j in 0..n {
            scaled[i * n + j] *= scale[i] * scale[j];
        }
        // Keeps nearly dependent parameters solvable.
        scaled[i * n + i] += 1e-12;
    }
    scaled
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equations_of_different_sizes_are_solved() {
        let a = [4e6, 1e3, 1e3, 3.0];
        let x = damped(&a, &[4e6 + 2e3, 1e3 + 6.0], 0.0).unwrap();
        assert!(
            (x[0] - 1.0).abs() < 1e-9 && (x[1] - 2.0).abs() < 1e-9,
            "{x:?}"
        );
        let inverse = inverse(&a, 2).unwrap();
        let determinant = 4e6 * 3.0 - 1e6;
        assert!((inverse[3] * determinant / 4e6 - 1.0).abs() < 1e-9);
        assert!(damped(&[1.0, 2.0, 2.0, 1.0], &[1.0, 1.0], 0.0).is_none());
    }
}
