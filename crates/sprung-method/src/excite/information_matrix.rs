//! Information of experiments about the parameters.

use faer::Mat;

use super::objective::{condition, inverse};
use crate::estimate::Bound;

/// Information about the free parameters, SI units.
#[derive(Clone, Debug)]
pub struct Information(pub(super) Mat<f64>);

impl Information {
    /// Returns the information of a bound; `None` if its covariance is not positive definite.
    #[must_use]
    pub fn of_bound(bound: &Bound) -> Option<Self> {
        let count = bound.free.len();
        let covariance = Mat::from_fn(count, count, |i, j| bound.covariance[i * count + j]);
        inverse(&covariance).map(Self)
    }

    /// Returns the information about the first parameters while the others are unknown; `None` if it does not determine
    /// all.
    pub(super) fn of_first(&self, count: usize) -> Option<Self> {
        let covariance = inverse(&self.0)?;
        inverse(&covariance.submatrix(0, 0, count, count).to_owned()).map(Self)
    }

    /// Returns the information of both experiments.
    #[must_use]
    pub fn with(&self, other: &Self) -> Self {
        Self(&self.0 + &other.0)
    }

    /// Returns the information of an experiment that is repeated.
    #[must_use]
    pub fn times(&self, factor: f64) -> Self {
        Self(&self.0 * faer::Scale(factor))
    }

    /// Returns the condition number of the columns of some parameters, each of length one; infinite if they do not
    /// determine these parameters.
    #[must_use]
    pub fn condition_number(&self, places: &[usize]) -> f64 {
        condition(&self.0, places).map_or(f64::INFINITY, |judged| judged.value.exp())
    }

    /// Returns the standard errors; infinite if the information does not determine all parameters.
    #[must_use]
    pub fn standard_errors(&self) -> Vec<f64> {
        match inverse(&self.0) {
            Some(inverse) => (0..inverse.nrows())
                .map(|i| inverse[(i, i)].sqrt())
                .collect(),
            None => vec![f64::INFINITY; self.0.nrows()],
        }
    }
}
