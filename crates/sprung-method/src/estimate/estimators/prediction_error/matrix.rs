//! Products of small dense matrices, row by row, with the widest vectors of the processor. Each entry
//! is summed in the order of its factors, so the result does not depend on the shape of the tiles.

use pulp::{Arch, Simd, WithSimd};

/// Rows of a tile, whose sums stay in registers.
const TALL: usize = 6;

/// Columns of a tile.
const SHORT: usize = 2;

/// Writes the product `out = a b`.
///
/// - `a`: \[m × k\]; `b`: \[k × columns\], further rows are ignored; `out`: \[m × columns\].
pub(super) fn multiply(a: &[f64], b: &[f64], columns: usize, out: &mut [f64]) {
    let rows = out.len() / columns.max(1);
    let terms = a.len() / rows.max(1);
    if terms == 0 {
        out.fill(0.0);
        return;
    }
    Arch::new().dispatch(Product {
        a,
        b: &b[..terms * columns],
        columns,
        out,
        kind: Kind::Write,
    });
}

/// Adds the product of a transpose and a matrix: `out ← out + aᵀ b`.
///
/// - `a`: \[k × m\]; `b`: \[k × columns\]; `out`: \[m × columns\].
pub(super) fn add_product(a: &[f64], b: &[f64], columns: usize, out: &mut [f64]) {
    add(a, b, columns, out, Kind::Add);
}

/// Adds the squares of some rows to the lower triangle of a symmetric matrix: `out ← out + aᵀ a`.
/// Entries above the diagonal become meaningless.
///
/// - `a`: \[k × columns\]; `out`: \[columns × columns\].
pub(super) fn add_squares(a: &[f64], columns: usize, out: &mut [f64]) {
    add(a, a, columns, out, Kind::AddLower);
}

fn add(a: &[f64], b: &[f64], columns: usize, out: &mut [f64], kind: Kind) {
    if a.is_empty() || b.is_empty() {
        return;
    }
    Arch::new().dispatch(Product {
        a,
        b,
        columns,
        out,
        kind,
    });
}

/// Use of the entries of a product.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// Writes those of `a b`.
    Write,
    /// Adds those of `aᵀ b`.
    Add,
    /// Adds the lower triangle of `aᵀ b`.
    AddLower,
}

/// A product. No factor is empty.
struct Product<'a> {
    a: &'a [f64],
    b: &'a [f64],
    columns: usize,
    out: &'a mut [f64],
    kind: Kind,
}

impl WithSimd for Product<'_> {
    type Output = ();

    #[expect(clippy::inline_always, reason = "only inlined code uses wide vectors")]
    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let rows = self.out.len() / self.columns;
        let mut row = 0;
        while row + TALL <= rows {
            self.rows::<S, TALL>(simd, row);
            row += TALL;
        }
        while row + SHORT <= rows {
            self.rows::<S, SHORT>(simd, row);
            row += SHORT;
        }
        if row < rows {
            self.rows::<S, 1>(simd, row);
        }
    }
}

impl Product<'_> {
    /// Computes R rows.
    #[expect(clippy::inline_always, reason = "only inlined code uses wide vectors")]
    #[inline(always)]
    fn rows<S: Simd, const R: usize>(&mut self, simd: S, row: usize) {
        let end = match self.kind {
            Kind::Write | Kind::Add => self.columns,
            Kind::AddLower => row + R,
        };
        let mut from = 0;
        while from + 2 * S::F64_LANES <= self.columns && from < end {
            self.tile::<S, R, 2, false>(simd, row, from);
            from += 2 * S::F64_LANES;
        }
        while from + S::F64_LANES <= self.columns && from < end {
            self.tile::<S, R, 1, false>(simd, row, from);
            from += S::F64_LANES;
        }
        if from < end {
            self.tile::<S, R, 1, true>(simd, row, from);
        }
    }

    /// Computes R rows of V vectors; the columns after the last whole vector if `EDGE`.
    #[expect(clippy::inline_always, reason = "only inlined code uses wide vectors")]
    #[inline(always)]
    fn tile<S: Simd, const R: usize, const V: usize, const EDGE: bool>(
        &mut self,
        simd: S,
        row: usize,
        from: usize,
    ) {
        let columns = self.columns;
        let out = &mut self.out[row * columns..(row + R) * columns];
        let mut sums = [[simd.splat_f64s(0.0); V]; R];
        let terms = self.b.len() / columns;
        let b = self.b.chunks_exact(columns);
        if self.kind == Kind::Write {
            let a: [&[f64]; R] =
                std::array::from_fn(|r| &self.a[(row + r) * terms..(row + r + 1) * terms]);
            for (k, b) in b.enumerate().take(terms) {
                let b = load::<S, V, EDGE>(simd, &b[from..]);
                add_terms(simd, &mut sums, b, |r| a[r][k]);
            }
        } else {
            for (sums, out) in sums.iter_mut().zip(out.chunks_exact(columns)) {
                *sums = load::<S, V, EDGE>(simd, &out[from..]);
            }
            for (a, b) in self.a.chunks_exact(self.a.len() / terms).zip(b) {
                let b = load::<S, V, EDGE>(simd, &b[from..]);
                let a = &a[row..row + R];
                add_terms(simd, &mut sums, b, |r| a[r]);
            }
        }
        for (sums, out) in sums.iter().zip(out.chunks_exact_mut(columns)) {
            let out = &mut out[from..];
            if EDGE {
                simd.partial_store_f64s(out, sums[0]);
            } else {
                let (vectors, _) = S::as_mut_simd_f64s(&mut out[..V * S::F64_LANES]);
                vectors.copy_from_slice(sums);
            }
        }
    }
}

/// Adds the products of the factors of each row and a part of a row.
#[expect(clippy::inline_always, reason = "only inlined code uses wide vectors")]
#[inline(always)]
fn add_terms<S: Simd, const R: usize, const V: usize>(
    simd: S,
    sums: &mut [[S::f64s; V]; R],
    row: [S::f64s; V],
    factor: impl Fn(usize) -> f64,
) {
    for (r, sums) in sums.iter_mut().enumerate() {
        let factor = simd.splat_f64s(factor(r));
        for (sum, value) in sums.iter_mut().zip(row) {
            *sum = simd.mul_add_e_f64s(factor, value, *sum);
        }
    }
}

/// Loads V vectors, or the rest of a row if `EDGE`.
#[expect(clippy::inline_always, reason = "only inlined code uses wide vectors")]
#[inline(always)]
fn load<S: Simd, const V: usize, const EDGE: bool>(simd: S, row: &[f64]) -> [S::f64s; V] {
    if EDGE {
        [simd.partial_load_f64s(row); V]
    } else {
        let (vectors, _) = S::as_simd_f64s(&row[..V * S::F64_LANES]);
        std::array::from_fn(|v| vectors[v])
    }
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

    fn near(found: f64, products: impl Iterator<Item = f64>) {
        let expected: f64 = products.sum();
        assert!(
            (found - expected).abs() < 1e-13,
            "{found} against {expected}"
        );
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
                    let found = out[i * columns + j];
                    near(
                        found,
                        (0..inner).map(|k| a[i * inner + k] * b[k * columns + j]),
                    );
                    assert_eq!(turned[j * rows + i].to_bits(), found.to_bits());
                }
            }
        }
    }

    #[test]
    fn products_of_transposes_are_added() {
        for (inner, rows, columns) in [(1, 1, 1), (3, 21, 40), (5, 7, 7), (33, 13, 13), (0, 9, 4)] {
            let (a, b) = (numbers(inner * rows), numbers(inner * columns));
            let before = numbers(rows * columns);
            let mut out = before.clone();
            add_product(&a, &b, columns, &mut out);
            let mut squares = numbers(rows * rows);
            add_squares(&a, rows, &mut squares);
            for i in 0..rows {
                for j in 0..columns {
                    let terms = (0..inner).map(|k| a[k * rows + i] * b[k * columns + j]);
                    near(out[i * columns + j], terms.chain([before[i * columns + j]]));
                }
                for j in 0..=i {
                    let terms = (0..inner).map(|k| a[k * rows + i] * a[k * rows + j]);
                    let first = numbers(rows * rows)[i * rows + j];
                    near(squares[i * rows + j], terms.chain([first]));
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
