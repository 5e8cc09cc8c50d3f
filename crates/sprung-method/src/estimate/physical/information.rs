//! Information about theta: the metric in which possible bodies are near to an estimate.

use faer::Mat;
use faer::linalg::solvers::DenseSolveCore;

use crate::estimate::estimators::{Covariance, Numbers};
use crate::estimate::result::CovarianceOfErrors;
use crate::estimate::statistics::ROUNDING;
use crate::fit::{Free, residual};
use crate::model::Model;
use crate::regression::System;

/// Information about theta.
pub(in crate::estimate) struct Information {
    /// \[p × p\]; zero for known parameters and for directions that the log does not determine.
    pub(in crate::estimate) matrix: Mat<f64>,
    /// Standard error of each parameter over that by the estimator's own covariance or by its equations
    /// with white residuals, \[p\]; their median for parameters without a standard error.
    pub(in crate::estimate) factors: Vec<f64>,
    /// Median of the squared factors, by which the matrix is already smaller.
    inflation: f64,
}

/// Returns the information about theta, \[p × p\]; zero for known parameters and for directions that the
/// log does not determine. It is that of the estimator, or that of the equations with the residual of
/// each row, scaled by one factor such that the standard errors that follow from it have the median of
/// the estimator's.
///
/// - `errors`: these standard errors, \[p\].
pub(in crate::estimate) fn information(
    model: &Model,
    numbers: &Numbers,
    errors: &[f64],
    system: &System,
) -> Option<Information> {
    let p = numbers.theta.len();
    if !numbers.theta.iter().all(|value| value.is_finite()) {
        return None;
    }
    let mut information = match &numbers.covariance {
        Some(own) => of_covariance(own, p)?,
        None => of_equations(model, &numbers.theta, system)?,
    };
    let known = known(model, numbers, errors);
    let part = Mat::from_fn(known.len(), known.len(), |i, j| {
        information[(known[i], known[j])]
    });
    let covariance = inverse(&part)?;
    let ratio = |(at, &i): (usize, &usize)| {
        let ratio = errors[i].powi(2) / covariance[(at, at)];
        (ratio > 0.0 && ratio.is_finite()).then_some((i, ratio))
    };
    let ratios: Vec<(usize, f64)> = known.iter().enumerate().filter_map(ratio).collect();
    let mut sorted: Vec<f64> = ratios.iter().map(|(_, ratio)| *ratio).collect();
    sorted.sort_by(f64::total_cmp);
    let inflation = *sorted.get(sorted.len() / 2)?;
    let mut factors = vec![inflation.sqrt(); p];
    for (i, ratio) in ratios {
        factors[i] = ratio.sqrt();
    }
    information /= faer::Scale(inflation);
    let is_finite = (0..p * p).all(|at| information[(at / p, at % p)].is_finite());
    is_finite.then_some(Information {
        matrix: information,
        inflation,
        factors,
    })
}

impl Information {
    /// Returns the information with which each parameter has its standard error.
    pub(in crate::estimate) fn of_errors(&self) -> Mat<f64> {
        widened(&self.matrix, &self.factors, self.inflation)
    }
}

/// Returns the covariance of the errors of the determined parameters; its diagonal has the squares of the
/// standard errors.
pub(in crate::estimate) fn covariance(
    model: &Model,
    numbers: &Numbers,
    information: &Information,
) -> Option<CovarianceOfErrors> {
    let known = known(model, numbers, &numbers.errors);
    let own = information.of_errors();
    let inverse = inverse(&Mat::from_fn(known.len(), known.len(), |i, j| {
        own[(known[i], known[j])]
    }))?;
    Some(CovarianceOfErrors {
        parameters: (known.iter())
            .map(|&i| model.parameters()[i].name.clone())
            .collect(),
        values: (0..known.len())
            .map(|i| (0..=i).map(|j| inverse[(i, j)]).collect())
            .collect(),
    })
}

/// Returns the parameters that the log determines with a standard error.
fn known(model: &Model, numbers: &Numbers, errors: &[f64]) -> Vec<usize> {
    (0..numbers.theta.len())
        .filter(|&i| numbers.identifiable[i] && model.parameters()[i].fixed.is_none())
        .filter(|&i| errors[i] > 0.0 && errors[i].is_finite())
        .collect()
}

/// Returns an information matrix after the standard error of each parameter grew by a factor.
///
/// - `by`: factor of the whole matrix.
pub(in crate::estimate) fn widened(matrix: &Mat<f64>, factors: &[f64], by: f64) -> Mat<f64> {
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
        by * matrix[(i, j)] / (factors[i] * factors[j])
    })
}

fn of_covariance(own: &Covariance, p: usize) -> Option<Mat<f64>> {
    let width = own.free.len();
    let inverse = inverse(&Mat::from_fn(width, width, |i, j| {
        own.values[i * width + j]
    }))?;
    let mut information = Mat::zeros(p, p);
    for (i, &row) in own.free.iter().enumerate() {
        for (j, &column) in own.free.iter().enumerate() {
            information[(row, column)] = inverse[(i, j)];
        }
    }
    Some(information)
}

/// Returns the information of the equations with the residual of each row, as if residuals were white,
/// \[p × p\].
pub(in crate::estimate) fn of_equations(
    model: &Model,
    theta: &[f64],
    system: &System,
) -> Option<Mat<f64>> {
    let p = theta.len();
    let free = Free::new(model);
    let residuals = residual(model, system, theta);
    let largest = residuals.iter().map(|row| row.1).fold(0.0, f64::max);
    let mut information = Mat::zeros(p, p);
    let factors = free.factors(system.whole()?);
    for ((columns, factor), (residual, _)) in free.columns.iter().zip(&factors).zip(&residuals) {
        let by = residual.max(ROUNDING * largest).powi(-2);
        for (i, &row) in columns.iter().enumerate() {
            for (j, &column) in columns.iter().enumerate() {
                let product: f64 = (0..=i.min(j))
                    .map(|k| factor.entry(k, i) * factor.entry(k, j))
                    .sum();
                information[(free.unknowns[row], free.unknowns[column])] += by * product;
            }
        }
    }
    Some(information)
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
