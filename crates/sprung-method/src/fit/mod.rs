//! Least squares on a reduced system: parameters, and their standard errors by the jackknife.

// The compiler names each place that must handle a new law, parameter, quantity or format.
#![warn(clippy::wildcard_enum_match_arm)]

mod column_fit;
mod growing;
mod hold_out;
mod jackknife;
mod joint_fit;
mod least_squares;
mod motor_row;
mod non_negative;
mod parts;
mod residual;
mod unknowns;

pub use growing::trace;
pub use least_squares::fit;
pub(crate) use least_squares::{
    Fitted, fit_quickly, fit_weighted, groups_for, row_weights, student_95,
};
pub(crate) use motor_row::{MotorRow, SAFE_SCALE};
pub use residual::{relative_residuals, residual, torques};

pub(crate) use column_fit::ColumnFit;
#[cfg(test)]
pub(crate) use growing::fits_of_growing;
#[cfg(test)]
pub(crate) use hold_out::tests::system_of;
pub(crate) use hold_out::{HoldOut, Missed, is_clearly_below, over_reference};
pub(crate) use joint_fit::{JointFit, joint_fits};
pub(crate) use least_squares::fit_values;
pub(crate) use non_negative::{RIDGE, non_negative};
pub(crate) use parts::{PartFit, fit_of_log, fits_of_quarters};
pub(crate) use unknowns::Free;
