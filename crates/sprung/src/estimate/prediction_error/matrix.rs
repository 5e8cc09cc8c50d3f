//! Products of small dense matrices, row by row, with the widest vectors of the processor. Each entry
//! is summed in the order of its factors, so the result has the same bits on every processor.

use pulp::{Arch, Simd, WithSimd};

/// Rows of a tile, whose sums stay in registers.
const TALL: usize = 6;
const SHORT: usize = 2;

/// Writes the product `out = a b`.
///
/// - `a`: \[m × k\]; `b`: \[k × columns\], further rows are ignored; `out`: \[m × columns\].
pub(super) fn multiply(a: &[f64], b: &[f64], columns: usize, out: &mut [f64]) {
    Arch::new().dispatch(Product { a, b, columns, out });
}

/// A product.
struct Product<'a> {
    a: &'a [f64],
    b: &'a [f64],
    columns: usize,
    out: &'a mut [f64],
}

impl WithSimd for Product<'_> {
    type Output = ();

    #[expect(clippy::inline_always, reason = "only inlined code uses wide vectors")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (columns, out) = (self.columns, self.out);
        let rows = out.len() / columns.max(1);
        let inner = self.a.len() / rows.max(1);
        let shape = (inner, columns);
        let (mut a, mut out) = (self.a, out);
        let mut left = rows;
        while left >= TALL {
            (a, out) = rows_of_product::<S, TALL>(simd, a, self.b, shape, out);
            left -= TALL;
        }
        while left >= SHORT {
            (a, out) = rows_of_product::<S, SHORT>(simd, a, self.b, shape, out);
            left -= SHORT;
        }
        if left > 0 {
            rows_of_product::<S, 1>(simd, a, self.b, shape, out);
        }
    }
}

/// Writes the first R rows of a product. Returns the further rows of the factor and of the product.
#[expect(clippy::inline_always, reason = "only inlined code uses wide vectors")]
#[inline(always)]
fn rows_of_product<'a, S: Simd, const R: usize>(
    simd: S,
    a: &'a [f64],
    b: &[f64],
    (inner, columns): (usize, usize),
    out: &'a mut [f64],
) -> (&'a [f64], &'a mut [f64]) {
    let (own, further) = a.split_at(R * inner);
    let (out, below) = out.split_at_mut(R * columns);
    let mut from = 0;
    while from < columns {
        let to = (from + S::F64_LANES).min(columns);
        let mut sums = [simd.splat_f64s(0.0); R];
        for k in 0..inner {
            let row = &b[k * columns + from..k * columns + to];
            let row = match S::as_simd_f64s(row).0 {
                [whole] => *whole,
                _ => simd.partial_load_f64s(row),
            };
            for r in 0..R {
                let factor = simd.splat_f64s(own[r * inner + k]);
                sums[r] = simd.add_f64s(sums[r], simd.mul_f64s(factor, row));
            }
        }
        for r in 0..R {
            simd.partial_store_f64s(&mut out[r * columns + from..r * columns + to], sums[r]);
        }
        from = to;
    }
    (further, below)
}

/// Writes the transpose of a matrix.
///
/// - `a`: \[m × columns\]; `out`: \[columns × m\].
pub(super) fn transpose(a: &[f64], columns: usize, out: &mut [f64]) {
    let rows = a.len() / columns.max(1);
    for (i, row) in a.chunks(columns).enumerate() {
        for (x, out) in row.iter().zip(out[i..].iter_mut().step_by(rows)) {
            *out = *x;
        }
    }
}

/// Adds a product of a column and a row: `a ← a + factor u vᵀ`.
pub(super) fn add_outer(a: &mut [f64], factor: f64, u: &[f64], v: &[f64]) {
    Arch::new().dispatch(|| {
        for (row, u) in a.chunks_mut(v.len().max(1)).zip(u) {
            let factor = factor * u;
            for (a, v) in row.iter_mut().zip(v) {
                *a += factor * v;
            }
        }
    });
}

/// Adds the square of a row to the lower triangle of a symmetric matrix: `a ← a + factor u uᵀ`.
pub(super) fn add_square(a: &mut [f64], factor: f64, u: &[f64]) {
    Arch::new().dispatch(|| {
        for (i, row) in a.chunks_mut(u.len().max(1)).enumerate() {
            let factor = factor * u[i];
            if factor != 0.0 {
                for (a, u) in row.iter_mut().zip(&u[..=i]) {
                    *a += factor * u;
                }
            }
        }
    });
}

/// Adds a multiple of each row of a matrix to a row: `sum ← sum + uᵀ a`.
pub(super) fn add_rows(sum: &mut [f64], u: &[f64], a: &[f64]) {
    let columns = sum.len().max(1);
    Arch::new().dispatch(|| {
        for (row, u) in a.chunks(columns).zip(u) {
            for (sum, a) in sum.iter_mut().zip(row) {
                *sum += u * a;
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(count: usize) -> Vec<f64> {
        (0..count).map(|i| (1.3 * i as f64).sin()).collect()
    }

    #[test]
    fn products_of_all_shapes_are_sums_of_products() {
        for (rows, inner, columns) in [(1, 1, 1), (4, 3, 8), (14, 21, 21), (6, 0, 5), (7, 14, 13)] {
            let (a, b) = (numbers(rows * inner), numbers(inner * columns + columns));
            let mut out = vec![f64::NAN; rows * columns];
            multiply(&a, &b, columns, &mut out);
            let mut turned = vec![0.0; columns * rows];
            transpose(&out, columns, &mut turned);
            for i in 0..rows {
                for j in 0..columns {
                    let products = (0..inner).map(|k| a[i * inner + k] * b[k * columns + j]);
                    let expected = products.fold(0.0, |sum: f64, x| sum + x);
                    assert_eq!(out[i * columns + j].to_bits(), expected.to_bits());
                    assert_eq!(turned[j * rows + i].to_bits(), expected.to_bits());
                }
            }
        }
    }

    #[test]
    fn rows_are_added_with_their_factors() {
        let (u, v) = (numbers(5), numbers(7));
        let mut a = vec![1.0; 35];
        add_outer(&mut a, 2.0, &u, &v);
        assert!((a[3 * 7 + 4] - (1.0 + 2.0 * u[3] * v[4])).abs() < 1e-15);
        let mut square = vec![1.0; 25];
        add_square(&mut square, 2.0, &u);
        assert!((square[3 * 5 + 2] - (1.0 + 2.0 * u[3] * u[2])).abs() < 1e-15);
        assert_eq!(square[2 * 5 + 3].to_bits(), 1.0_f64.to_bits());
        let mut sum = vec![1.0; 7];
        add_rows(&mut sum, &u, &a);
        let expected = 1.0 + (0..5).map(|i| u[i] * a[i * 7 + 2]).sum::<f64>();
        assert!((sum[2] - expected).abs() < 1e-13);
    }
}
