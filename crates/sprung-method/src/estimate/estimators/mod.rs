//! The estimators. Each returns a [`Found`].

mod damping;
mod feasible;
mod found;
pub(super) mod least_squares;
pub(super) mod lsff;
pub(super) mod output_error;
pub(super) mod prediction_error;

pub(super) use found::{Covariance, Criterion, Found, Numbers};
