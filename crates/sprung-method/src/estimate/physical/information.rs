//! Information about theta: the metric of the distance between possible bodies and an estimate.

use faer::Mat;

use crate::estimate::estimators::least_squares::PossibleFit;
use crate::estimate::estimators::{Covariance, Numbers};
use crate::estimate::possible::{Estimated, Limits, Normal, inverse, known, median, ratios};
use crate::estimate::result::CovarianceOfErrors;
use crate::estimate::statistics::ROUNDING;
use crate::fit::residual;
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
        Some(covariance) => of_covariance(covariance, p)?,
        None => of_equations(model, &numbers.theta, system)?,
    };
    let ratios = ratios(
        &information,
        &known(model, &numbers.identifiable, errors),
        errors,
    )?;
    let inflation = median(&ratios)?;
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
///
/// - `limits`: intervals of robots that can exist, \[p\]; `None` without constraints.
pub(in crate::estimate) fn covariance(
    model: &Model,
    numbers: &Numbers,
    information: &Information,
    limits: Option<&[Option<Limits>]>,
) -> Option<CovarianceOfErrors> {
    let known = known(model, &numbers.identifiable, &numbers.errors);
    let factor = |i: usize| {
        let error = limits.and_then(|limits| Some(limits[i]?.standard_error(numbers.interval)));
        let factor = error.map(|error| error / numbers.errors[i]);
        factor.filter(|factor| factor.is_finite()).unwrap_or(1.0)
    };
    let covariance = information.of_errors();
    let inverse = inverse(&Mat::from_fn(known.len(), known.len(), |i, j| {
        covariance[(known[i], known[j])]
    }))?;
    Some(CovarianceOfErrors {
        parameters: (known.iter())
            .map(|&i| model.parameters()[i].name.clone())
            .collect(),
        values: (0..known.len())
            .map(|i| {
                let entry = |j: usize| inverse[(i, j)] * factor(known[i]) * factor(known[j]);
                (0..=i).map(entry).collect()
            })
            .collect(),
    })
}

/// Returns the interval of each parameter of a robot that can exist, \[p\]; `None` for a parameter without one.
pub(in crate::estimate) fn limits(
    (possible, unconstrained): (&PossibleFit<'_>, &[f64]),
    numbers: &Numbers,
    information: &Information,
) -> Option<Vec<Option<Limits>>> {
    if !numbers.interval.is_finite() {
        return None;
    }
    let known = known(
        possible.robots.model,
        &numbers.identifiable,
        &numbers.errors,
    );
    let of_equations;
    let estimated = Estimated {
        information: if numbers.covariance.is_some() {
            &information.matrix
        } else {
            of_equations = possible.information();
            &of_equations
        },
        unconstrained,
        theta: &numbers.theta,
        errors: &numbers.errors,
    };
    let found = possible
        .robots
        .limits(&estimated, &known, numbers.interval)?;
    let mut all = vec![None; numbers.theta.len()];
    for (&i, value) in known.iter().zip(found) {
        all[i] = value;
    }
    Some(all)
}

/// Returns an information matrix after the standard error of each parameter grew by a factor.
///
/// - `by`: factor of the whole matrix.
pub(in crate::estimate) fn widened(matrix: &Mat<f64>, factors: &[f64], by: f64) -> Mat<f64> {
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
        by * matrix[(i, j)] / (factors[i] * factors[j])
    })
}

fn of_covariance(covariance: &Covariance, p: usize) -> Option<Mat<f64>> {
    let width = covariance.free.len();
    let inverse = inverse(&Mat::from_fn(width, width, |i, j| {
        covariance.values[i * width + j]
    }))?;
    let mut information = Mat::zeros(p, p);
    for (i, &row) in covariance.free.iter().enumerate() {
        for (j, &column) in covariance.free.iter().enumerate() {
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
    let residuals = residual(model, system, theta);
    let largest = residuals.iter().map(|row| row.1).fold(0.0, f64::max);
    let weights: Vec<f64> = (residuals.iter())
        .map(|(residual, _)| residual.max(ROUNDING * largest).recip())
        .collect();
    Some(Normal::new(model, system, &weights)?.information)
}
