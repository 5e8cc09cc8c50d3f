//! The information of weighted equations, and its scale by standard errors.

use faer::Mat;
use faer::linalg::solvers::DenseSolveCore;

use crate::fit::Free;
use crate::model::Model;
use crate::regression::{System, Triangle};

/// Normal equations of all rows: `H θ = g`.
#[derive(Clone)]
pub(in crate::estimate) struct Normal {
    /// H, \[p × p\]; zero for known parameters.
    pub(in crate::estimate) information: Mat<f64>,
    /// g, \[p\].
    pub(in crate::estimate) gradient: Vec<f64>,
}

impl Normal {
    /// Returns the normal equations of rows that are multiplied by weights, \[rows\].
    pub(in crate::estimate) fn new(
        model: &Model,
        system: &System,
        weights: &[f64],
    ) -> Option<Self> {
        Some(Self::of(model, system.whole()?, weights))
    }

    /// Returns the normal equations of one factor per row.
    pub(in crate::estimate) fn of(model: &Model, factors: Vec<Triangle>, weights: &[f64]) -> Self {
        let p = model.parameters().len();
        let free = Free::new(model);
        let mut normal = Self {
            information: Mat::zeros(p, p),
            gradient: vec![0.0; p],
        };
        let factors = free.factors(factors);
        for ((columns, factor), weight) in free.columns.iter().zip(&factors).zip(weights) {
            let by = weight * weight;
            let product = |i: usize, j: usize| -> f64 {
                let both = (0..=i.min(j)).map(|k| factor.entry(k, i) * factor.entry(k, j));
                by * both.sum::<f64>()
            };
            for (i, &row) in columns.iter().enumerate() {
                let at = free.unknowns[row];
                normal.gradient[at] += product(i, columns.len());
                for (j, &column) in columns.iter().enumerate() {
                    normal.information[(at, free.unknowns[column])] += product(i, j);
                }
            }
        }
        normal
    }

    /// Adds the equations of other samples.
    pub(in crate::estimate) fn with(mut self, more: Self) -> Self {
        self.information += more.information;
        for (sum, more) in self.gradient.iter_mut().zip(more.gradient) {
            *sum += more;
        }
        self
    }

    /// Returns the equations of all samples but those of a part.
    pub(in crate::estimate) fn without(&self, part: &Self) -> Self {
        Self {
            information: &self.information - &part.information,
            gradient: (self.gradient.iter().zip(&part.gradient))
                .map(|(all, part)| all - part)
                .collect(),
        }
    }

    /// Returns the divisor of the equations with which the standard errors that follow from them have the median of given
    /// ones.
    ///
    /// - `known`: parameters that the log determines; `errors`: their standard errors among all, \[p\].
    pub(in crate::estimate) fn scale(&self, known: &[usize], errors: &[f64]) -> Option<f64> {
        median(&ratios(&self.information, known, errors)?)
    }

    /// Divides the equations by a number.
    pub(in crate::estimate) fn divided(mut self, by: f64) -> Self {
        self.information /= faer::Scale(by);
        for entry in &mut self.gradient {
            *entry /= by;
        }
        self
    }
}

/// Returns the parameters that the log determines with a standard error.
///
/// - `identifiable`: whether the log determines each parameter, \[p\]; `errors`: standard errors, \[p\].
pub(in crate::estimate) fn known(
    model: &Model,
    identifiable: &[bool],
    errors: &[f64],
) -> Vec<usize> {
    (0..errors.len())
        .filter(|&i| identifiable[i] && model.parameters()[i].fixed.is_none())
        .filter(|&i| errors[i] > 0.0 && errors[i].is_finite())
        .collect()
}

/// Returns the squared standard error of each parameter over the variance by an information matrix.
///
/// - `known`: parameters that the log determines, with a standard error in `errors`, \[p\].
pub(in crate::estimate) fn ratios(
    information: &Mat<f64>,
    known: &[usize],
    errors: &[f64],
) -> Option<Vec<(usize, f64)>> {
    let part = Mat::from_fn(known.len(), known.len(), |i, j| {
        information[(known[i], known[j])]
    });
    let covariance = inverse(&part)?;
    let ratio = |(at, &i): (usize, &usize)| {
        let ratio = errors[i].powi(2) / covariance[(at, at)];
        (ratio > 0.0 && ratio.is_finite()).then_some((i, ratio))
    };
    Some(known.iter().enumerate().filter_map(ratio).collect())
}

/// Returns the median of ratios.
pub(in crate::estimate) fn median(ratios: &[(usize, f64)]) -> Option<f64> {
    let mut sorted: Vec<f64> = ratios.iter().map(|(_, ratio)| *ratio).collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

/// Returns the inverse of a symmetric positive definite matrix, with unknowns scaled to one size; `None`
/// if it has none.
pub(in crate::estimate) fn inverse(matrix: &Mat<f64>) -> Option<Mat<f64>> {
    let n = matrix.nrows();
    let scale: Vec<f64> = (0..n).map(|i| matrix[(i, i)].sqrt().recip()).collect();
    let scaled = Mat::from_fn(n, n, |i, j| matrix[(i, j)] * scale[i] * scale[j]);
    let inverse = scaled.llt(faer::Side::Lower).ok()?.inverse();
    Some(Mat::from_fn(n, n, |i, j| {
        inverse[(i, j)] * scale[i] * scale[j]
    }))
}
