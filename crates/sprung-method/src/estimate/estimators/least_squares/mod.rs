//! Least squares and its checks: sweeps of the cut-off, cross-checks.

mod band;
mod cross_checks;
mod estimate;
mod held_out;
mod linear;
mod nuisances;
mod parts;
mod possible;
mod sweep;
mod uncertainty;

pub(crate) use cross_checks::Route;
pub(in crate::estimate) use held_out::{HeldOut, Price};
pub(in crate::estimate) use linear::{Linear, linear_numbers};
pub(in crate::estimate) use possible::{Contradicted, PossibleFit};
pub(crate) use sweep::cutoff_choice;

pub(in crate::estimate) use estimate::least_squares;
