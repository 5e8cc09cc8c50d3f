//! Operations on rows of numbers.

/// Adds a multiple of a row to another row.
#[inline]
pub(super) fn add(sum: &mut [f64], factor: f64, row: &[f64]) {
    for (sum, x) in sum.iter_mut().zip(row) {
        *sum += factor * x;
    }
}

/// Adds a multiple of a row in single precision to a row.
pub(super) fn add_single(sum: &mut [f64], factor: f64, row: &[f32]) {
    for (sum, x) in sum.iter_mut().zip(row) {
        *sum += factor * f64::from(*x);
    }
}

/// Replaces a row by numbers in single precision.
pub(super) fn widen(row: &mut Vec<f64>, single: &[f32]) {
    row.clear();
    row.extend(single.iter().copied().map(f64::from));
}

/// Appends a row in single precision.
pub(super) fn extend_single(single: &mut Vec<f32>, row: impl IntoIterator<Item = f64>) {
    single.extend(row.into_iter().map(|x| x as f32));
}

/// Multiplies a row by a factor.
pub(super) fn scale(row: &mut [f64], factor: f64) {
    for x in row {
        *x *= factor;
    }
}

/// Returns the scalar product.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
