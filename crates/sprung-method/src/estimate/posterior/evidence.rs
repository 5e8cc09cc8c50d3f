//! Information of the log about the parameters.

use faer::Mat;

use super::errors::PosteriorError;
use crate::estimate::possible::inverse;
use crate::estimate::result::{CovarianceOfErrors, EstimateResult};
use crate::model::Model;

/// Parameters that the log determines, with a normal distribution of their errors.
pub(super) struct Evidence {
    /// Indices in theta.
    pub(super) known: Vec<usize>,
    /// Estimates without constraints, \[known\].
    pub(super) values: Vec<f64>,
    /// Inverse of the covariance without constraints, \[known × known\].
    pub(super) information: Mat<f64>,
}

impl Evidence {
    /// The covariance of a result contains the bounds: its standard errors are those by profile likelihood. They are
    /// replaced by those of the equations, because the set of draws already contains the bounds.
    pub(super) fn new(model: &Model, result: &EstimateResult) -> Result<Self, PosteriorError> {
        let covariance =
            (result.covariance.as_ref()).ok_or_else(|| PosteriorError::NoCovariance {
                estimator: result.estimator.clone(),
            })?;
        let wrong = || PosteriorError::Covariance {
            estimator: result.estimator.clone(),
        };
        let size = covariance.parameters.len();
        let is_square = covariance.values.len() == size
            && (covariance.values.iter().enumerate()).all(|(i, row)| row.len() == i + 1);
        if size == 0 || !is_square {
            return Err(wrong());
        }
        let (mut known, mut values, mut factors) = (Vec::new(), Vec::new(), Vec::new());
        for (i, name) in covariance.parameters.iter().enumerate() {
            let other = || PosteriorError::OtherRobot { name: name.clone() };
            let index = model.index_of(name).map_err(|_| other())?;
            let estimate = result.parameter(name).ok_or_else(other)?;
            let error = covariance.values[i][i].sqrt();
            let by_equations = match estimate.unconstrained {
                Some(_) => estimate.error_by_equations().unwrap_or(error),
                None => error,
            };
            known.push(index);
            values.push(estimate.by_equations().ok_or_else(wrong)?);
            factors.push(by_equations / error);
        }
        Ok(Self {
            known,
            values,
            information: information(covariance, &factors).ok_or_else(wrong)?,
        })
    }
}

/// Returns the inverse of a covariance after the standard error of each parameter grew by a factor.
fn information(errors: &CovarianceOfErrors, factors: &[f64]) -> Option<Mat<f64>> {
    let size = factors.len();
    let covariance = Mat::from_fn(size, size, |i, j| {
        errors.values[i.max(j)][i.min(j)] * factors[i] * factors[j]
    });
    let information = inverse(&covariance)?;
    let is_finite = (0..size * size).all(|at| information[(at / size, at % size)].is_finite());
    is_finite.then_some(information)
}
