//! Spectra of torques and positions, and the springs of joints whose motors alone are measured.

// The compiler names each place that must handle a new law, parameter, quantity or format.
#![warn(clippy::wildcard_enum_match_arm)]

mod fourier;
mod motor_side;
mod record;
mod spectra;

pub use motor_side::SpringFromMotor;
pub(crate) use motor_side::{about_springs, springs_from_motor};
pub(crate) use record::Record;
