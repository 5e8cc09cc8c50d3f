//! Least squares and its checks: sweeps of the cut-off, cross-checks, instrumental variables.

mod cross_checks;
mod estimate;
mod instruments;
mod parts;
mod sweep;
mod uncertainty;

pub(crate) use cross_checks::{Route, cross_checks};
pub(crate) use parts::Parts;
pub(crate) use sweep::cutoff_choice;
pub(crate) use uncertainty::widened;

pub(super) use estimate::least_squares;
pub(super) use instruments::add_instruments;

pub(super) use crate::fit::Fitted;
