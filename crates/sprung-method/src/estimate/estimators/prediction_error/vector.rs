//! Operations on rows of numbers.

/// Adds a multiple of a row to another row.
#[inline]
pub(super) fn add(sum: &mut [f64], factor: f64, row: &[f64]) {
    for (sum, x) in sum.iter_mut().zip(row) {
        *sum += factor * x;
    }
}

/// A number with a mantissa of 16 bits, in three bytes. Gains take most of the memory of a refinement.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Short([u8; 3]);

impl Short {
    pub(super) fn new(x: f64) -> Self {
        // Rounds the lowest byte of the mantissa away.
        let [_, low, middle, high] = ((x as f32).to_bits().saturating_add(0x80)).to_le_bytes();
        Self([low, middle, high])
    }
}

impl From<Short> for f64 {
    fn from(Short([low, middle, high]): Short) -> Self {
        Self::from(f32::from_le_bytes([0, low, middle, high]))
    }
}

/// Adds a multiple of a row of short numbers to a row.
pub(super) fn add_short(sum: &mut [f64], factor: f64, row: &[Short]) {
    for (sum, x) in sum.iter_mut().zip(row) {
        *sum += factor * f64::from(*x);
    }
}

/// Replaces a row by the values of another one.
pub(super) fn widen<T: Copy + Into<f64>>(row: &mut Vec<f64>, other: &[T]) {
    row.clear();
    row.extend(other.iter().map(|x| (*x).into()));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_numbers_are_rounded_to_the_nearest() {
        for x in [0.0, 1.0, -1.5, 0.1, -3e-7, 65_536.0, 1e12] {
            let short = f64::from(Short::new(x));
            assert!(
                (short - x).abs() <= 2_f64.powi(-17) * x.abs(),
                "{short} {x}"
            );
            assert_eq!(Short::new(short), Short::new(x));
        }
        assert!(f64::from(Short::new(f64::INFINITY)).is_infinite());
    }
}
