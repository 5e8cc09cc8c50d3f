//! The frequency response from torques to positions: of the log, and of the identified model.

// The compiler names each place that must handle a new law, parameter, quantity or format.
#![warn(clippy::wildcard_enum_match_arm)]

mod compare;
mod findings;
mod fourier;
mod linear;
mod modes;
mod motor_side;
mod period;
mod pole;
mod record;
mod response;
mod result;
mod spectra;
#[cfg(test)]
mod tests;
mod weighted;

pub(crate) use compare::{Identified, frequency_response};
pub(crate) use findings::resonances_disagree;
pub(crate) use linear::{Linear, Pose};
pub(crate) use modes::{Mode, assigned};
pub use motor_side::SpringFromMotor;
pub(crate) use motor_side::{about_springs, springs_from_motor};
pub(crate) use record::Record;
pub use result::{Feature, FeatureKind, FrequencyResponse, JointResponse, ResponseCurves, Unseen};
