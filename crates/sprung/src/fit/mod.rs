//! Least squares on a reduced system: parameters, and standard errors from stretches of the
//! log that are left out in turn.

mod jackknife;
mod least_squares;

pub use least_squares::{Fitted, MotorRow, TorqueOf, fit, fit_quickly, residual, torques, trace};

pub(crate) use least_squares::{Free, fit_values, fits_of_growing, unweighted};
