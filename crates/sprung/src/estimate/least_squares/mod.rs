//! Least squares and its checks: sweeps of the cut-off, cross-checks, instrumental variables.

mod cross_checks;
mod estimate;
mod instruments;
mod sweep;

pub(crate) use cross_checks::cross_checks;
pub(crate) use sweep::sweep;

pub(super) use estimate::least_squares;
pub(super) use instruments::add_instruments;

pub(super) use crate::fit::Fitted;
