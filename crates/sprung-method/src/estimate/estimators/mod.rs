//! The estimators. Each returns a [`Found`].

mod damping;
mod estimator_result;
mod feasible;
pub(super) mod least_squares;
pub(super) mod lsff;
pub(super) mod prediction_error;

pub(super) use estimator_result::{Covariance, Criterion, Found, Numbers};
