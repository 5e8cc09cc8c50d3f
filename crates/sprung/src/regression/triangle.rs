//! Triangular factors of the rows of one equation.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::qr::no_pivoting::factor;
use faer::prelude::ReborrowMut;
use faer::{Mat, MatMut, Par, Spec};

/// The triangular factor of `[A | b]`. It represents `A^T A`, `A^T b` and `b^T b` of any number of
/// rows without the loss of accuracy that forming these products causes.
#[derive(Clone, Debug)]
pub struct Triangle {
    // [m + 1 × m + 1], upper triangular.
    r: Mat<f64>,
}

impl Triangle {
    /// Returns the factor of rows `[A | b]`, which are overwritten.
    pub(super) fn of_rows(mut rows: MatMut<'_, f64>) -> Self {
        let (count, width) = (rows.nrows(), rows.ncols());
        let size = count.min(width);
        let block = factor::recommended_block_size::<f64>(count, width);
        let mut coefficients = Mat::zeros(block, size);
        let request =
            factor::qr_in_place_scratch::<f64>(count, width, block, Par::Seq, Spec::default());
        let mut memory = MemBuffer::new(request);
        factor::qr_in_place(
            rows.rb_mut(),
            coefficients.as_mut(),
            Par::Seq,
            MemStack::new(&mut memory),
            Spec::default(),
        );
        let r = Mat::from_fn(width, width, |i, j| {
            if i <= j && i < size {
                rows[(i, j)]
            } else {
                0.0
            }
        });
        Self { r }
    }

    /// Returns the factor of rows `[A | b]`.
    #[must_use]
    pub fn of<const W: usize>(rows: &[[f64; W]]) -> Self {
        Self::of_rows(Mat::from_fn(rows.len(), W, |i, j| rows[i][j]).as_mut())
    }

    /// Returns the factor of rows `[A | b]` of equal length.
    #[must_use]
    pub(crate) fn of_lines(rows: &[Vec<f64>]) -> Self {
        let width = rows.first().map_or(0, Vec::len);
        Self::of_rows(Mat::from_fn(rows.len(), width, |i, j| rows[i][j]).as_mut())
    }

    /// Returns the factor of the rows of several factors together.
    pub(crate) fn merge<'a>(parts: impl IntoIterator<Item = &'a Self>) -> Option<Self> {
        let parts: Vec<&Self> = parts.into_iter().collect();
        let width = parts.first()?.r.ncols();
        let mut rows = Mat::from_fn(parts.len() * width, width, |i, j| {
            parts[i / width].r[(i % width, j)]
        });
        Some(Self::of_rows(rows.as_mut()))
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
                .filter_map(|(k, value)| Some(self.r[(i, k)] * (*value)?))
                .sum::<f64>();
            self.r[(i, m)] - moved
        };
        let mut rows = Mat::from_fn(m + 1, free.len() + 1, |i, j| {
            (free.get(j)).map_or_else(|| rhs(i), |&column| self.r[(i, column)])
        });
        Self::of_rows(rows.as_mut())
    }

    /// Returns the factor of the same rows multiplied by `factor`.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let r = &self.r;
        Self {
            r: Mat::from_fn(r.nrows(), r.ncols(), |i, j| factor * r[(i, j)]),
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
            let own = if j == unknown {
                residual[i] / value
            } else {
                0.0
            };
            (self.r[(i, j)] - own) / value
        };
        let mut rows = Mat::from_fn(m + 1, m + 1, |i, j| {
            if j < m {
                return slope(i, j);
            }
            let fitted: f64 = (0..m).map(|j| slope(i, j) * x[j]).sum();
            fitted - residual[i] / value
        });
        Self::of_rows(rows.as_mut())
    }

    /// Returns the factor of the rows `[A|b] · [directions | -at]`: least squares for the steps from a
    /// point along directions.
    ///
    /// - `at`: the point followed by -1, \[m + 1\]; `directions`: each \[m + 1\], with the change of
    ///   the factor -1 of the right-hand side at the end.
    #[must_use]
    pub(crate) fn along(&self, at: &[f64], directions: &[Vec<f64>]) -> Self {
        let height = self.r.nrows();
        let product =
            |i: usize, v: &[f64]| -> f64 { (i..height).map(|j| self.r[(i, j)] * v[j]).sum() };
        let width = directions.len() + 1;
        let mut rows = Mat::from_fn(height, width, |i, j| {
            (directions.get(j)).map_or_else(|| -product(i, at), |v| product(i, v))
        });
        Self::of_rows(rows.as_mut())
    }

    /// Returns the number of unknowns.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.r.ncols() - 1
    }

    /// Returns an entry of the factor.
    #[must_use]
    pub fn entry(&self, row: usize, column: usize) -> f64 {
        self.r[(row, column)]
    }

    /// Returns `Q^T (A x - b)`, which has the length of the residual of all rows, \[m + 1\].
    ///
    /// - `x`: \[m\].
    #[must_use]
    pub fn residual(&self, x: &[f64]) -> Vec<f64> {
        let m = self.unknowns();
        (0..=m)
            .map(|i| {
                let fitted: f64 = (i..m).map(|j| self.r[(i, j)] * x[j]).sum();
                fitted - self.r[(i, m)]
            })
            .collect()
    }

    /// Returns `A^T (A x - b)`, \[m\].
    #[must_use]
    pub fn gradient(&self, x: &[f64]) -> Vec<f64> {
        let residual = self.residual(x);
        (0..self.unknowns())
            .map(|j| (0..=j).map(|i| self.r[(i, j)] * residual[i]).sum())
            .collect()
    }

    /// Returns the length of column `column` of `A`.
    #[must_use]
    pub fn column_norm(&self, column: usize) -> f64 {
        (0..=column)
            .map(|i| self.r[(i, column)].powi(2))
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

    fn rows(count: usize, shift: usize) -> Mat<f64> {
        Mat::from_fn(count, 4, |i, j| {
            (((i + shift) * 7 + j * 13) as f64 * 0.61).sin() + if j == 3 { 0.5 } else { 0.0 }
        })
    }

    fn gram(rows: &Mat<f64>) -> Mat<f64> {
        rows.transpose() * rows
    }

    #[test]
    fn factor_keeps_all_products() {
        for count in [1, 3, 4, 5, 300] {
            let a = rows(count, 0);
            let triangle = Triangle::of_rows(a.clone().as_mut());
            let difference = gram(&a) - gram(&triangle.r);
            assert!(difference.norm_max() < 1e-12 * (1.0 + count as f64));
        }
    }

    #[test]
    fn known_values_move_to_the_right_hand_side() {
        let a = rows(60, 3);
        let all = Triangle::of_rows(a.clone().as_mut());
        let reduced = all.with_known(&[None, Some(0.7), None]);
        let x = [0.3, 0.7, -1.1];
        let squared = |r: Vec<f64>| r.iter().map(|x| x * x).sum::<f64>();
        let (long, short) = (all.residual(&x), reduced.residual(&[x[0], x[2]]));
        assert!((squared(long) - squared(short)).abs() < 1e-12);
        assert_eq!(reduced.unknowns(), 2);
    }

    #[test]
    fn steps_along_directions_reach_the_same_residual() {
        let all = Triangle::of_rows(rows(60, 3).as_mut());
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
        let triangle = Triangle::of_rows(a.clone().as_mut());
        let x = [0.3, 0.7, -1.1];
        let of = |x: &[f64; 3], i: usize| {
            ((0..3).map(|j| a[(i, j)] * x[j]).sum::<f64>() - a[(i, 3)]) / x[1]
        };
        let step = 1e-6;
        let mut linear = Mat::from_fn(60, 4, |i, j| {
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
        let expected = Triangle::of_rows(linear.as_mut());
        let found = triangle.over_unknown(&x, 1);
        let difference = gram(&expected.r) - gram(&found.r);
        // Error of the differences, measured 5.8e-11; the limit allows a factor of 17.
        assert!(difference.norm_max() < 1e-9 * gram(&found.r).norm_max());
    }

    #[test]
    fn merged_factors_are_the_factor_of_all_rows() {
        let (a, b) = (rows(50, 0), rows(70, 50));
        let parts = [a, b].map(|mut rows| Triangle::of_rows(rows.as_mut()));
        let merged = Triangle::merge(&parts).unwrap();
        let all = Triangle::of_rows(rows(120, 0).as_mut());
        let difference = gram(&merged.r) - gram(&all.r);
        assert!(difference.norm_max() < 1e-12 * 120.0);
        let x = [0.3, -0.2, 0.9];
        let squared = |t: &Triangle| t.residual(&x).iter().map(|r| r * r).sum::<f64>();
        assert!((squared(&merged) - squared(&all)).abs() < 1e-10);
    }
}
