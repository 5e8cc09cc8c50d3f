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

    /// Returns a block of as many rows as are folded together best.
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
        self.reflect(factor, |_| padded);
    }

    /// Folds the rows of an upper triangular factor, which the block holds, into another factor, and
    /// overwrites them.
    pub(super) fn fold_triangle_into(&mut self, factor: &mut [f64]) {
        let stride = self.stride;
        self.reflect(factor, |column| {
            (column + 1).next_multiple_of(LANES).min(stride)
        });
    }

    fn reflect(&mut self, factor: &mut [f64], height: impl Fn(usize) -> usize) {
        let arch = Arch::new();
        for column in 0..self.width {
            arch.dispatch(Reflection {
                factor,
                values: &mut self.values[column * self.stride..],
                stride: self.stride,
                column,
                height: height(column),
            });
        }
    }
}

/// Returns the place of an entry in the columns of a triangular factor.
pub(super) fn place(row: usize, column: usize) -> usize {
    column * (column + 1) / 2 + row
}

/// The reflection that moves one column of a block into the factor.
struct Reflection<'a> {
    factor: &'a mut [f64],
    // The column and those behind it.
    values: &'a mut [f64],
    stride: usize,
    column: usize,
    // Rows of the block that are not zero, a multiple of the lanes.
    height: usize,
}

impl WithSimd for Reflection<'_> {
    type Output = ();

    #[expect(
        clippy::inline_always,
        reason = "only code inlined into the dispatch uses wide vectors"
    )]
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (own, behind) = self.values.split_at_mut(self.stride);
        let (own, _) = S::as_mut_simd_f64s(&mut own[..self.height]);
        let squares = products(simd, own, [&*own])[0];
        let diagonal = &mut self.factor[place(self.column, self.column)];
        if squares == 0.0 {
            return;
        }
        let before = *diagonal;
        let length = (before * before + squares).sqrt();
        *diagonal = if before > 0.0 { -length } else { length };
        let tau = (*diagonal - before) / *diagonal;
        let scale = simd.splat_f64s(1.0 / (before - *diagonal));
        for entry in &mut *own {
            *entry = simd.mul_f64s(*entry, scale);
        }
        let mut column = self.column + 1;
        let mut groups = behind.chunks_exact_mut(8 * self.stride);
        for group in &mut groups {
            let rows = (self.column, column, self.height);
            reflect::<S, 8>(simd, own, group, self.factor, rows, tau);
            column += 8;
        }
        let rest = groups.into_remainder();
        let mut groups = rest.chunks_exact_mut(4 * self.stride);
        for group in &mut groups {
            let rows = (self.column, column, self.height);
            reflect::<S, 4>(simd, own, group, self.factor, rows, tau);
            column += 4;
        }
        for single in groups.into_remainder().chunks_mut(self.stride) {
            let rows = (self.column, column, self.height);
            reflect::<S, 1>(simd, own, single, self.factor, rows, tau);
            column += 1;
        }
    }
}

/// Reflects `N` neighbouring columns.
///
/// - `own`: the vector of the reflection below its first entry 1; `tau`: its factor.
/// - `rows`: row of the factor, first column, and rows of the block that are not zero.
#[expect(
    clippy::inline_always,
    reason = "only code inlined into the dispatch uses wide vectors"
)]
#[inline(always)]
fn reflect<S: Simd, const N: usize>(
    simd: S,
    own: &[S::f64s],
    columns: &mut [f64],
    factor: &mut [f64],
    (row, first, height): (usize, usize, usize),
    tau: f64,
) {
    let stride = columns.len() / N;
    let mut rest = columns;
    let mut columns: [&mut [S::f64s]; N] = std::array::from_fn(|_| {
        let (column, behind) = std::mem::take(&mut rest).split_at_mut(stride);
        rest = behind;
        S::as_mut_simd_f64s(&mut column[..height]).0
    });
    let along = products(simd, own, columns.each_ref().map(|column| &**column));
    let mut steps = [simd.splat_f64s(0.0); N];
    for (k, along) in along.into_iter().enumerate() {
        let entry = &mut factor[place(row, first + k)];
        let step = tau * (*entry + along);
        *entry -= step;
        steps[k] = simd.splat_f64s(step);
    }
    let count = own.len();
    let mut columns = columns.each_mut().map(|column| &mut column[..count]);
    for (i, own) in own.iter().enumerate() {
        for (column, step) in columns.iter_mut().zip(&steps) {
            column[i] = simd.negate_mul_add_e_f64s(*own, *step, column[i]);
        }
    }
}

/// Returns the products of a vector with `N` others.
#[expect(
    clippy::inline_always,
    reason = "only code inlined into the dispatch uses wide vectors"
)]
#[inline(always)]
fn products<S: Simd, const N: usize>(
    simd: S,
    own: &[S::f64s],
    others: [&[S::f64s]; N],
) -> [f64; N] {
    let count = own.len();
    let others = others.map(|other| &other[..count]);
    let mut sums = [simd.splat_f64s(0.0); N];
    for (i, own) in own.iter().enumerate() {
        for (sum, other) in sums.iter_mut().zip(&others) {
            *sum = simd.mul_add_e_f64s(*own, other[i], *sum);
        }
    }
    sums.map(|sum| simd.reduce_sum_f64s(sum))
}
