//! Householder reflections that fold rows into a triangular factor.
//!
//! A reflection acts on one row of the factor and on all rows of a block. A block is so small that
//! it stays in the fastest cache while all its columns are reflected.

use pulp::{Arch, Simd, WithSimd};

/// Rows are padded with zeros to a multiple of this, the widest vector of any processor.
const LANES: usize = 8;

/// Numbers in a block, 32 KiB.
const BLOCK_NUMBERS: usize = 4096;

/// Fewest and most rows of a block.
const BLOCK_ROWS: [usize; 2] = [32, 512];

/// Rows `[A | b]`, column after column.
#[derive(Clone, Debug)]
pub(super) struct RowBlock {
    width: usize,
    stride: usize,
    values: Vec<f64>,
}

impl RowBlock {
    /// Returns rows of zeros.
    pub(super) fn zeros(rows: usize, width: usize) -> Self {
        let stride = rows.next_multiple_of(LANES);
        Self {
            width,
            stride,
            values: vec![0.0; stride * width],
        }
    }

    /// Returns a block with the best number of rows to fold together.
    pub(super) fn of_width(width: usize) -> Self {
        let [fewest, most] = BLOCK_ROWS;
        let rows = (BLOCK_NUMBERS / width).clamp(fewest, most);
        Self::zeros(rows / LANES * LANES, width)
    }

    /// Returns the number of rows that the block can take.
    pub(super) fn capacity(&self) -> usize {
        self.stride
    }

    /// Returns the entries of a column.
    pub(super) fn column_mut(&mut self, column: usize) -> &mut [f64] {
        &mut self.values[column * self.stride..][..self.stride]
    }

    /// Folds the first rows into an upper triangular factor, and overwrites them.
    ///
    /// - `factor`: its columns down to the diagonal, one after another.
    pub(super) fn fold_into(&mut self, factor: &mut [f64], rows: usize) {
        let padded = rows.next_multiple_of(LANES).min(self.stride);
        for column in self.values.chunks_mut(self.stride) {
            column[rows..padded].fill(0.0);
        }
        self.reflect(factor, padded, false);
    }

    /// Folds the rows of an upper triangular factor, which the block holds, into another factor, and
    /// overwrites them.
    pub(super) fn fold_triangle_into(&mut self, factor: &mut [f64]) {
        self.reflect(factor, self.stride, true);
    }

    fn reflect(&mut self, factor: &mut [f64], rows: usize, is_triangle: bool) {
        Arch::new().dispatch(Reflections {
            block: self,
            factor,
            rows,
            is_triangle,
        });
    }
}

/// Returns the place of an entry in the columns of a triangular factor.
pub(super) fn place(row: usize, column: usize) -> usize {
    column * (column + 1) / 2 + row
}

/// The reflections that move all rows of a block into the factor.
struct Reflections<'a> {
    block: &'a mut RowBlock,
    factor: &'a mut [f64],
    // Rows of the block, a multiple of the lanes.
    rows: usize,
    // Whether a column has entries only down to its own row.
    is_triangle: bool,
}

impl WithSimd for Reflections<'_> {
    type Output = ();

    #[expect(
        clippy::inline_always,
        reason = "only code inlined into the dispatch uses wide vectors"
    )]
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            block,
            factor,
            rows,
            is_triangle,
        } = self;
        let (width, stride) = (block.width, block.stride);
        for row in (0..width).step_by(2) {
            let height = if is_triangle {
                (row + 2).next_multiple_of(LANES).min(rows)
            } else {
                rows
            };
            let behind = &mut block.values[row * stride..];
            let (first, behind) = behind.split_at_mut(stride);
            let (first, _) = S::as_mut_simd_f64s(&mut first[..height]);
            let mut pair = Pair {
                row,
                taus: [normalized(simd, first, &mut factor[place(row, row)]), 0.0],
                along: 0.0,
            };
            if row + 1 == width {
                break;
            }
            let (second, behind) = behind.split_at_mut(stride);
            let (second, _) = S::as_mut_simd_f64s(&mut second[..height]);
            let step = pair.taus[0]
                * (factor[place(row, row + 1)] + products(simd, [first], [&*second])[0][0]);
            factor[place(row, row + 1)] -= step;
            subtract(simd, [first], [second], [[step]]);
            pair.taus[1] = normalized(simd, second, &mut factor[place(row + 1, row + 1)]);
            pair.along = products(simd, [first], [&*second])[0][0];
            let vectors = [&*first, &*second];
            let mut column = row + 2;
            let mut groups = behind.chunks_exact_mut(4 * stride);
            for group in &mut groups {
                pair.reflect::<S, 4>(simd, vectors, group, column, factor);
                column += 4;
            }
            for single in groups.into_remainder().chunks_mut(stride) {
                pair.reflect::<S, 1>(simd, vectors, single, column, factor);
                column += 1;
            }
        }
    }
}

/// Two reflections that are applied together.
struct Pair {
    // Row of the factor that the first one changes; the second one changes the next.
    row: usize,
    taus: [f64; 2],
    // Product of the vectors of both.
    along: f64,
}

impl Pair {
    /// Reflects `N` neighbouring columns from `column` on.
    ///
    /// - `vectors`: of the reflections, below their first entries 1.
    #[expect(
        clippy::inline_always,
        reason = "only code inlined into the dispatch uses wide vectors"
    )]
    #[inline(always)]
    fn reflect<S: Simd, const N: usize>(
        &self,
        simd: S,
        vectors: [&[S::f64s]; 2],
        columns: &mut [f64],
        column: usize,
        factor: &mut [f64],
    ) {
        let stride = columns.len() / N;
        let height = vectors[0].len() * S::F64_LANES;
        let mut rest = columns;
        let columns: [&mut [S::f64s]; N] = std::array::from_fn(|_| {
            let (column, behind) = std::mem::take(&mut rest).split_at_mut(stride);
            rest = behind;
            S::as_mut_simd_f64s(&mut column[..height]).0
        });
        let along = products(simd, vectors, columns.each_ref().map(|column| &**column));
        let steps: [[f64; 2]; N] = std::array::from_fn(|k| {
            let at = place(self.row, column + k);
            let first = self.taus[0] * (factor[at] + along[k][0]);
            let second = self.taus[1] * (factor[at + 1] + along[k][1] - first * self.along);
            factor[at] -= first;
            factor[at + 1] -= second;
            [first, second]
        });
        subtract(simd, vectors, columns, steps);
    }
}

/// Turns the entries of a column into the vector of a reflection below its first entry 1, and the
/// diagonal entry into that of the new factor. Returns the factor tau of the reflection, zero for a
/// column of zeros.
#[expect(
    clippy::inline_always,
    reason = "only code inlined into the dispatch uses wide vectors"
)]
#[inline(always)]
fn normalized<S: Simd>(simd: S, column: &mut [S::f64s], diagonal: &mut f64) -> f64 {
    let squares = products(simd, [&*column], [&*column])[0][0];
    if squares == 0.0 {
        return 0.0;
    }
    let before = *diagonal;
    let length = (before * before + squares).sqrt();
    *diagonal = if before > 0.0 { -length } else { length };
    let scale = simd.splat_f64s(1.0 / (before - *diagonal));
    for entry in column {
        *entry = simd.mul_f64s(*entry, scale);
    }
    (*diagonal - before) / *diagonal
}

/// Subtracts from each column its steps times the vectors.
#[expect(
    clippy::inline_always,
    reason = "only code inlined into the dispatch uses wide vectors"
)]
#[inline(always)]
fn subtract<S: Simd, const M: usize, const N: usize>(
    simd: S,
    vectors: [&[S::f64s]; M],
    columns: [&mut [S::f64s]; N],
    steps: [[f64; M]; N],
) {
    let count = vectors[0].len();
    let vectors = vectors.map(|vector| &vector[..count]);
    let mut columns = columns.map(|column| &mut column[..count]);
    let steps = steps.map(|row| row.map(|step| simd.splat_f64s(step)));
    for i in 0..count {
        let at = vectors.map(|vector| vector[i]);
        for (column, steps) in columns.iter_mut().zip(&steps) {
            for (vector, step) in at.iter().zip(steps) {
                column[i] = simd.negate_mul_add_e_f64s(*vector, *step, column[i]);
            }
        }
    }
}

/// Returns the products of each column with the vectors.
#[expect(
    clippy::inline_always,
    reason = "only code inlined into the dispatch uses wide vectors"
)]
#[inline(always)]
fn products<S: Simd, const M: usize, const N: usize>(
    simd: S,
    vectors: [&[S::f64s]; M],
    columns: [&[S::f64s]; N],
) -> [[f64; M]; N] {
    let count = vectors[0].len();
    let vectors = vectors.map(|vector| &vector[..count]);
    let columns = columns.map(|column| &column[..count]);
    let mut sums = [[simd.splat_f64s(0.0); M]; N];
    for i in 0..count {
        let at = vectors.map(|vector| vector[i]);
        for (column, sums) in columns.iter().zip(&mut sums) {
            for (vector, sum) in at.iter().zip(sums) {
                *sum = simd.mul_add_e_f64s(*vector, column[i], *sum);
            }
        }
    }
    sums.map(|row| row.map(|sum| simd.reduce_sum_f64s(sum)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    fn entry(i: usize, j: usize) -> f64 {
        ((7 * i * i + 5 * i * j + 13 * j) as f64 * 0.61).sin()
    }

    fn block(rows: std::ops::Range<usize>, width: usize) -> RowBlock {
        let mut block = RowBlock::zeros(rows.len(), width);
        for j in 0..width {
            let column = block.column_mut(j).iter_mut();
            column.zip(rows.clone()).for_each(|(x, i)| *x = entry(i, j));
        }
        block
    }

    fn factor_of(rows: std::ops::Range<usize>, width: usize) -> Vec<f64> {
        let mut factor = vec![0.0; place(0, width)];
        block(rows.clone(), width).fold_into(&mut factor, rows.len());
        factor
    }

    fn assert_same(found: &[f64], expected: &[f64]) {
        for (found, expected) in found.iter().zip(expected) {
            // Rows of a factor have no sign. A column of up to 131 numbers has the length √131, and as many roundings
            // of random sign add up to √131 ε of it; four of these deviations.
            assert!(
                (found.abs() - expected.abs()).abs() < 4.0 * 131.0 * f64::EPSILON,
                "{found} {expected}"
            );
        }
    }

    #[test]
    fn factors_equal_those_of_faer() {
        for (rows, width) in [(9, 1), (40, 2), (37, 5), (64, 6), (131, 11)] {
            let reference = Mat::from_fn(rows, width, entry).qr().thin_R().to_owned();
            let expected: Vec<f64> = (0..width)
                .flat_map(|j| (0..=j).map(move |i| (i, j)))
                .map(|at| reference[at])
                .collect();
            assert_same(&factor_of(0..rows, width), &expected);
        }
    }

    #[test]
    fn blocks_and_triangles_give_the_factor_of_all_rows() {
        for width in [3, 8, 13] {
            let all = factor_of(0..90, width);
            let mut in_blocks = factor_of(0..50, width);
            block(50..90, width).fold_into(&mut in_blocks, 40);
            assert_same(&in_blocks, &all);
            let later = factor_of(50..90, width);
            let mut triangle = RowBlock::zeros(width, width);
            for j in 0..width {
                let column = &later[place(0, j)..=place(j, j)];
                triangle.column_mut(j)[..=j].copy_from_slice(column);
            }
            let mut merged = factor_of(0..50, width);
            triangle.fold_triangle_into(&mut merged);
            assert_same(&merged, &all);
        }
    }

    #[test]
    fn columns_of_zeros_and_no_rows_change_nothing() {
        let mut factor = factor_of(0..30, 4);
        let before = factor.clone();
        RowBlock::zeros(5, 4).fold_into(&mut factor, 5);
        block(0..8, 4).fold_into(&mut factor, 0);
        assert_eq!(factor, before);
        let mut block = block(0..8, 4);
        block.column_mut(1).fill(f64::NAN);
        block.fold_into(&mut factor, 8);
        assert!(factor[place(1, 1)].is_nan() && factor[place(0, 0)].is_finite());
    }
}
