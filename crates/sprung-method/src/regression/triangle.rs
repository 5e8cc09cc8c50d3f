//! Triangular factors of the rows of one equation.

use super::householder::{RowBlock, place};

/// The triangular factor of `[A | b]`. It represents `A^T A`, `A^T b` and `b^T b` of any number of
/// rows without the loss of accuracy that forming these products causes.
#[derive(Clone, Debug)]
pub struct Triangle {
    // Number of columns, m + 1.
    width: usize,
    // The columns down to the diagonal, one after another.
    r: Vec<f64>,
}

impl Triangle {
    /// Returns the factor of no rows.
    ///
    /// - `width`: number of columns, m + 1.
    pub(super) fn zero(width: usize) -> Self {
        Self {
            width,
            r: vec![0.0; place(0, width)],
        }
    }

    /// Adds the first rows of a block, which are overwritten.
    pub(super) fn fold(&mut self, block: &mut RowBlock, rows: usize) {
        block.fold_into(&mut self.r, rows);
    }

    /// Adds the rows of another factor with the same columns.
    pub(super) fn add(&mut self, other: &Self) {
        let mut block = RowBlock::zeros(self.width, self.width);
        for column in 0..self.width {
            let entries = &other.r[place(0, column)..=place(column, column)];
            block.column_mut(column)[..=column].copy_from_slice(entries);
        }
        block.fold_triangle_into(&mut self.r);
    }

    /// Returns the factor of rows `[A | b]`.
    ///
    /// - `entry`: returns the entry of a row and a column.
    pub(super) fn of_entries(
        rows: usize,
        width: usize,
        entry: impl Fn(usize, usize) -> f64,
    ) -> Self {
        let mut block = RowBlock::zeros(rows, width);
        for column in 0..width {
            for (row, value) in block.column_mut(column)[..rows].iter_mut().enumerate() {
                *value = entry(row, column);
            }
        }
        let mut all = Self::zero(width);
        all.fold(&mut block, rows);
        all
    }

    /// Returns the factor of rows `[A | b]`.
    #[must_use]
    pub fn of<const W: usize>(rows: &[[f64; W]]) -> Self {
        Self::of_entries(rows.len(), W, |i, j| rows[i][j])
    }

    /// Returns the factor of rows `[A | b]` of equal length.
    #[must_use]
    pub(crate) fn of_lines(rows: &[Vec<f64>]) -> Self {
        let width = rows.first().map_or(0, Vec::len);
        Self::of_entries(rows.len(), width, |i, j| rows[i][j])
    }

    /// Returns the factor of the rows of two factors together.
    pub(super) fn sum(&self, other: &Self) -> Self {
        let mut all = self.clone();
        all.add(other);
        all
    }

    /// Returns the factor of the rows of several factors together.
    pub(crate) fn merge<'a>(parts: impl IntoIterator<Item = &'a Self>) -> Option<Self> {
        let mut parts = parts.into_iter();
        let mut all = parts.next()?.clone();
        parts.for_each(|part| all.add(part));
        Some(all)
    }

    /// Returns the factor after some unknowns became known: their columns move to the right-hand
    /// side.
    ///
    /// - `known`: the value of each unknown, or `None` if it stays unknown, \[m\].
    #[must_use]
    pub fn with_known(&self, known: &[Option<f64>]) -> Self {
        let m = self.unknowns();
        let free: Vec<usize> = (0..m).filter(|&j| known[j].is_none()).collect();
        let rhs = |i: usize| {
            let moved = (known.iter().enumerate())
                .filter_map(|(k, value)| Some(self.entry(i, k) * (*value)?))
                .sum::<f64>();
            self.entry(i, m) - moved
        };
        Self::of_entries(m + 1, free.len() + 1, |i, j| {
            (free.get(j)).map_or_else(|| rhs(i), |&column| self.entry(i, column))
        })
    }

    /// Returns the factor of the same rows multiplied by `factor`.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            width: self.width,
            r: self.r.iter().map(|entry| factor * entry).collect(),
        }
    }

    /// Returns the factor of the rows `(A x - b) / x_k`, linearised about `x`. Its least-squares
    /// solution is the next iterate of the Gauss-Newton method.
    ///
    /// - `x`: \[m\]; `unknown`: k, with a value that is not zero.
    #[must_use]
    pub fn over_unknown(&self, x: &[f64], unknown: usize) -> Self {
        let m = self.unknowns();
        let residual = self.residual(x);
        let value = x[unknown];
        let slope = |i: usize, j: usize| {
            let correction = if j == unknown {
                residual[i] / value
            } else {
                0.0
            };
            (self.entry(i, j) - correction) / value
        };
        Self::of_entries(m + 1, m + 1, |i, j| {
            if j < m {
                return slope(i, j);
            }
            let fitted: f64 = (0..m).map(|j| slope(i, j) * x[j]).sum();
            fitted - residual[i] / value
        })
    }

    /// Returns the factor of the rows `[A|b] · [directions | -at]`: least squares for the steps from a
    /// point along directions.
    ///
    /// - `at`: the point followed by -1, \[m + 1\]; `directions`: each \[m + 1\], with the change of
    ///   the factor -1 of the right-hand side at the end.
    #[must_use]
    pub(crate) fn along(&self, at: &[f64], directions: &[Vec<f64>]) -> Self {
        let height = self.width;
        let product =
            |i: usize, v: &[f64]| -> f64 { (i..height).map(|j| self.entry(i, j) * v[j]).sum() };
        let width = directions.len() + 1;
        Self::of_entries(height, width, |i, j| {
            (directions.get(j)).map_or_else(|| -product(i, at), |v| product(i, v))
        })
    }

    /// Returns the number of unknowns.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.width - 1
    }

    /// Returns an entry of the factor; zero below the diagonal.
    #[must_use]
    pub fn entry(&self, row: usize, column: usize) -> f64 {
        if row > column {
            return 0.0;
        }
        self.r[place(row, column)]
    }

    /// Returns `Q^T (A x - b)`, which has the length of the residual of all rows, \[m + 1\].
    ///
    /// - `x`: \[m\].
    #[must_use]
    pub fn residual(&self, x: &[f64]) -> Vec<f64> {
        let m = self.unknowns();
        (0..=m)
            .map(|i| {
                let fitted: f64 = (i..m).map(|j| self.entry(i, j) * x[j]).sum();
                fitted - self.entry(i, m)
            })
            .collect()
    }

    /// Returns the length of the residual of all rows.
    ///
    /// - `x`: \[m\].
    #[must_use]
    pub fn residual_length(&self, x: &[f64]) -> f64 {
        let residual = self.residual(x);
        residual.iter().map(|r| r * r).sum::<f64>().sqrt()
    }

    /// Returns `A^T (A x - b)`, \[m\].
    #[must_use]
    pub fn gradient(&self, x: &[f64]) -> Vec<f64> {
        let residual = self.residual(x);
        (0..self.unknowns())
            .map(|j| (0..=j).map(|i| self.entry(i, j) * residual[i]).sum())
            .collect()
    }

    /// Returns the length of column `column` of `A`.
    #[must_use]
    pub fn column_norm(&self, column: usize) -> f64 {
        (0..=column)
            .map(|i| self.entry(i, column).powi(2))
            .sum::<f64>()
            .sqrt()
    }

    /// Returns the length of the right-hand side, `|b|`.
    #[must_use]
    pub fn rhs_norm(&self) -> f64 {
        self.column_norm(self.unknowns())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    fn rows(count: usize, shift: usize) -> Mat<f64> {
        Mat::from_fn(count, 4, |i, j| {
            (((i + shift) * 7 + j * 13) as f64 * 0.61).sin() + if j == 3 { 0.5 } else { 0.0 }
        })
    }

    fn gram(rows: &Mat<f64>) -> Mat<f64> {
        rows.transpose() * rows
    }

    fn of_rows(rows: &Mat<f64>) -> Triangle {
        Triangle::of_entries(rows.nrows(), rows.ncols(), |i, j| rows[(i, j)])
    }

    fn gram_of(triangle: &Triangle) -> Mat<f64> {
        gram(&Mat::from_fn(4, 4, |i, j| triangle.entry(i, j)))
    }

    #[test]
    fn factor_keeps_all_products() {
        for count in [1, 3, 4, 5, 300] {
            let a = rows(count, 0);
            let triangle = of_rows(&a);
            let difference = gram(&a) - gram_of(&triangle);
            assert!(difference.norm_max() < 1e-12 * (1.0 + count as f64));
        }
    }

    #[test]
    fn known_values_move_to_the_right_hand_side() {
        let a = rows(60, 3);
        let all = of_rows(&a);
        let reduced = all.with_known(&[None, Some(0.7), None]);
        let x = [0.3, 0.7, -1.1];
        let squared = |r: Vec<f64>| r.iter().map(|x| x * x).sum::<f64>();
        let (long, short) = (all.residual(&x), reduced.residual(&[x[0], x[2]]));
        assert!((squared(long) - squared(short)).abs() < 1e-12);
        assert_eq!(reduced.unknowns(), 2);
    }

    #[test]
    fn steps_along_directions_reach_the_same_residual() {
        let all = of_rows(&rows(60, 3));
        let (x, step) = ([0.3, 0.7, -1.1], [0.4, -0.2]);
        let directions = [vec![1.0, 0.0, 2.0, 0.0], vec![0.0, 0.0, 0.0, -1.0]];
        let along = all.along(&[x[0], x[1], x[2], -1.0], &directions);
        let squared = |r: Vec<f64>| r.iter().map(|x| x * x).sum::<f64>();
        // The second direction scales the right-hand side by 1 + step.
        let gain = 1.0 + step[1];
        let moved = [x[0] + step[0], x[1], x[2] + 2.0 * step[0]].map(|x| x / gain);
        let expected = gain * gain * squared(all.residual(&moved));
        assert!((squared(along.residual(&step)) - expected).abs() < 1e-12 * 60.0);
    }

    #[test]
    fn over_unknown_gives_the_gauss_newton_step() {
        let a = rows(60, 3);
        let triangle = of_rows(&a);
        let x = [0.3, 0.7, -1.1];
        let of = |x: &[f64; 3], i: usize| {
            ((0..3).map(|j| a[(i, j)] * x[j]).sum::<f64>() - a[(i, 3)]) / x[1]
        };
        let step = 1e-6;
        let linear = Mat::from_fn(60, 4, |i, j| {
            let slope = |j: usize| {
                let moved = |by: f64| std::array::from_fn(|k| x[k] + if k == j { by } else { 0.0 });
                (of(&moved(step), i) - of(&moved(-step), i)) / (2.0 * step)
            };
            if j < 3 {
                slope(j)
            } else {
                (0..3).map(|j| slope(j) * x[j]).sum::<f64>() - of(&x, i)
            }
        });
        let expected = of_rows(&linear);
        let found = triangle.over_unknown(&x, 1);
        let difference = gram_of(&expected) - gram_of(&found);
        // Rounding of values of up to four; the truncation, step² / x[1]³, is far below it.
        let limit = 4.0 * f64::EPSILON / step;
        assert!(difference.norm_max() < limit * gram_of(&found).norm_max());
    }

    #[test]
    fn merged_factors_are_the_factor_of_all_rows() {
        let (a, b) = (rows(50, 0), rows(70, 50));
        let parts = [a, b].map(|rows| of_rows(&rows));
        let merged = Triangle::merge(&parts).unwrap();
        let all = of_rows(&rows(120, 0));
        let difference = gram_of(&merged) - gram_of(&all);
        assert!(difference.norm_max() < 1e-12 * 120.0);
        let x = [0.3, -0.2, 0.9];
        let squared = |t: &Triangle| t.residual(&x).iter().map(|r| r * r).sum::<f64>();
        assert!((squared(&merged) - squared(&all)).abs() < 1e-10);
    }
}
