//! The inverse of a small complex matrix.

use faer::c64;

/// Inverts a matrix, \[n × n\], row by row; `None` if it is singular or a number is not finite.
#[must_use]
pub(super) fn inverse(matrix: &[c64], n: usize) -> Option<Vec<c64>> {
    let (zero, one) = (c64::new(0.0, 0.0), c64::new(1.0, 0.0));
    let mut left = matrix.to_vec();
    let mut right = vec![zero; n * n];
    for i in 0..n {
        right[i * n + i] = one;
    }
    for k in 0..n {
        let size = |row: &usize| left[row * n + k].norm_sqr();
        let pivot = (k..n).max_by(|a, b| size(a).total_cmp(&size(b)))?;
        if !(size(&pivot) > 0.0 && size(&pivot).is_finite()) {
            return None;
        }
        for j in 0..n {
            left.swap(k * n + j, pivot * n + j);
            right.swap(k * n + j, pivot * n + j);
        }
        let scale = one / left[k * n + k];
        for j in 0..n {
            left[k * n + j] *= scale;
            right[k * n + j] *= scale;
        }
        for i in (0..n).filter(|&i| i != k) {
            let factor = left[i * n + k];
            for j in 0..n {
                let (entry, of_inverse) = (left[k * n + j], right[k * n + j]);
                left[i * n + j] -= factor * entry;
                right[i * n + j] -= factor * of_inverse;
            }
        }
    }
    right
        .iter()
        .all(|value| value.norm_sqr().is_finite())
        .then_some(right)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_times_the_matrix_is_one() {
        let n = 3;
        let matrix: Vec<c64> = (0..n * n)
            .map(|k| c64::new((1.3 * k as f64).sin(), (0.7 * k as f64).cos()))
            .collect();
        let inverse = inverse(&matrix, n).unwrap();
        for i in 0..n {
            for j in 0..n {
                let product: c64 = (0..n).map(|k| inverse[i * n + k] * matrix[k * n + j]).sum();
                let expected = f64::from(u8::from(i == j));
                assert!((product - c64::new(expected, 0.0)).norm() < 1e-12);
            }
        }
    }

    #[test]
    fn a_singular_matrix_has_none() {
        let one = c64::new(1.0, 1.0);
        assert!(inverse(&[one, one, one, one], 2).is_none());
    }
}
