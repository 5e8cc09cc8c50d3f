//! Weighted least squares of complex numbers with few unknowns.

use std::cell::OnceCell;

use faer::c64;

/// Pivot of a scaled normal matrix below which its columns count as dependent.
const LEAST_PIVOT: f64 = 1e-11;

const ZERO: c64 = c64::new(0.0, 0.0);

/// A linear regression, row by row.
#[derive(Clone, Debug, Default)]
pub(super) struct Regression {
    /// Number of unknowns.
    pub(super) unknowns: usize,
    /// Regressors, \[rows × unknowns\], row by row.
    pub(super) regressors: Vec<c64>,
    /// Weights, \[rows\].
    pub(super) weights: Vec<f64>,
}

/// The factored normal equations of a regression.
#[derive(Clone, Debug)]
pub(super) struct Factored<'r> {
    regression: &'r Regression,
    /// Length of each column.
    sizes: Vec<f64>,
    /// Lower Cholesky factor of the scaled normal matrix, row by row.
    factor: Vec<c64>,
    /// Leverage of each row, after the first request of a variance.
    leverages: OnceCell<Vec<f64>>,
}

/// A solution.
#[derive(Clone, Debug)]
pub(super) struct Solution {
    /// The unknowns.
    pub(super) values: Vec<c64>,
    /// Left sides minus the regressors times the unknowns, \[rows\].
    pub(super) residuals: Vec<c64>,
}

impl Regression {
    fn rows(&self) -> impl Iterator<Item = (&[c64], f64)> {
        self.regressors
            .chunks(self.unknowns.max(1))
            .zip(self.weights.iter().copied())
    }

    /// Factors the normal equations; `None` if the columns are dependent.
    #[must_use]
    pub(super) fn factored(&self) -> Option<Factored<'_>> {
        let p = self.unknowns;
        let mut normal = vec![ZERO; p * p];
        for (row, weight) in self.rows() {
            for i in 0..p {
                let left = row[i].conj() * weight;
                for j in 0..=i {
                    normal[i * p + j] += left * row[j];
                }
            }
        }
        let sizes: Vec<f64> = (0..p).map(|i| normal[i * p + i].re.sqrt()).collect();
        if sizes.iter().any(|size| !(*size > 0.0 && size.is_finite())) {
            return None;
        }
        for i in 0..p {
            for j in 0..=i {
                normal[i * p + j] /= sizes[i] * sizes[j];
            }
        }
        for i in 0..p {
            for j in 0..=i {
                let known: c64 = (0..j)
                    .map(|k| normal[i * p + k] * normal[j * p + k].conj())
                    .sum();
                let rest = normal[i * p + j] - known;
                normal[i * p + j] = if i == j {
                    if rest.re < LEAST_PIVOT {
                        return None;
                    }
                    c64::new(rest.re.sqrt(), 0.0)
                } else {
                    rest / normal[j * p + j].re
                };
            }
        }
        Some(Factored {
            regression: self,
            sizes,
            factor: normal,
            leverages: OnceCell::new(),
        })
    }
}

impl Factored<'_> {
    /// Solves for left sides, \[rows\].
    #[must_use]
    pub(super) fn solve(&self, left: &[c64]) -> Solution {
        let mut values = vec![ZERO; self.sizes.len()];
        for ((row, weight), y) in self.regression.rows().zip(left) {
            for (sum, x) in values.iter_mut().zip(row) {
                *sum += x.conj() * *y * weight;
            }
        }
        self.apply(&mut values);
        let residuals = (self.regression.rows().zip(left))
            .map(|((row, _), y)| *y - row.iter().zip(&values).map(|(x, v)| *x * *v).sum::<c64>())
            .collect();
        Solution { values, residuals }
    }

    /// Multiplies a vector by the inverse of the normal matrix.
    fn apply(&self, x: &mut [c64]) {
        let p = x.len();
        self.apply_lower(x);
        for i in (0..p).rev() {
            let known: c64 = (i + 1..p)
                .map(|k| self.factor[k * p + i].conj() * x[k])
                .sum();
            x[i] = (x[i] - known) / self.factor[i * p + i].re;
        }
        for (x, size) in x.iter_mut().zip(&self.sizes) {
            *x /= *size;
        }
    }

    /// Scales a vector and multiplies it by the inverse of the factor.
    fn apply_lower(&self, x: &mut [c64]) {
        let p = x.len();
        for i in 0..p {
            let row = &self.factor[i * p..=i * p + i];
            let known: c64 = row.iter().zip(&x[..i]).map(|(l, x)| *l * *x).sum();
            x[i] = (x[i] / self.sizes[i] - known) / row[i].re;
        }
    }

    /// Returns the leverage of each row: the weighted length of its regressors in the metric of the
    /// inverse normal matrix.
    fn leverages(&self) -> &[f64] {
        self.leverages.get_or_init(|| {
            let mut spread = vec![ZERO; self.sizes.len()];
            (self.regression.rows())
                .map(|(row, weight)| {
                    for (entry, x) in spread.iter_mut().zip(row) {
                        *entry = x.conj();
                    }
                    self.apply_lower(&mut spread);
                    weight * spread.iter().map(c64::norm_sqr).sum::<f64>()
                })
                .collect()
        })
    }

    /// Returns the variance of one unknown by the residuals of each row, for any variances.
    ///
    /// # Source
    ///
    /// `MacKinnon` and White, Journal of Econometrics 1985: the estimate `HC2`, in which the square of a
    /// row's residual is divided by one minus its leverage.
    #[must_use]
    pub(super) fn variance(&self, unknown: usize, residuals: &[c64]) -> f64 {
        let mut direction = vec![ZERO; self.sizes.len()];
        direction[unknown] = c64::new(1.0, 0.0);
        self.apply(&mut direction);
        let mut sum = 0.0;
        let rows = self.regression.rows().zip(residuals).zip(self.leverages());
        for (((row, weight), residual), leverage) in rows {
            let influence: c64 = (direction.iter().zip(row))
                .map(|(d, x)| d.conj() * x.conj())
                .sum();
            let left = (1.0 - leverage).max(1e-3);
            sum += influence.norm_sqr() * weight.powi(2) / left * residual.norm_sqr();
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> Regression {
        let rows = 9;
        Regression {
            unknowns: 2,
            regressors: (0..rows)
                .flat_map(|k| {
                    let x = f64::from(k);
                    [c64::new(1.0, 0.2 * x), c64::new(x.sin(), x)]
                })
                .collect(),
            weights: (0..rows).map(|k| 1.0 + f64::from(k % 3)).collect(),
        }
    }

    #[test]
    fn exact_left_sides_give_their_unknowns_and_no_variance() {
        let regression = example();
        let truth = [c64::new(0.3, -2.0), c64::new(-1.5, 0.1)];
        let left: Vec<c64> = (regression.rows())
            .map(|(row, _)| row[0] * truth[0] + row[1] * truth[1])
            .collect();
        let factored = regression.factored().unwrap();
        let found = factored.solve(&left);
        for (value, truth) in found.values.iter().zip(truth) {
            assert!((value - truth).norm() < 1e-12);
        }
        assert!(factored.variance(0, &found.residuals) < 1e-20);
    }

    #[test]
    fn dependent_columns_have_no_solution() {
        let mut regression = example();
        for row in regression.regressors.chunks_mut(2) {
            row[1] = row[0] * c64::new(0.0, 3.0);
        }
        assert!(regression.factored().is_none());
    }
}
