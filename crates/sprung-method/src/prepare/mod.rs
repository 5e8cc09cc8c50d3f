//! Makes all choices for an estimate from the beginning of the first log: the cut-off of the
//! position filter, signs and gains, Stribeck velocities and weights of
//! samples.

// The compiler names each place that must handle a new law, parameter, quantity or format.
#![warn(clippy::wildcard_enum_match_arm)]

mod as_given;
mod cutoff;
mod deviation;
mod estimated_columns;
mod excerpt;
mod factors;
mod gain;
mod held_out;
mod inertial_findings;
mod link_rows;
mod mounting;
mod noise;
mod play;
mod prepared;
mod row;
mod sign;
mod smoothed;
mod springs;
mod stribeck;
mod sweep;
mod thinned;
mod torque_side;
mod velocity_by_likelihood;
mod weights;

pub(crate) use as_given::as_given;
pub(crate) use cutoff::{choose_cutoff, limit_by_rate};
pub(crate) use deviation::deviation;
pub(crate) use estimated_columns::{Doubt, FoundGain};
pub(crate) use excerpt::Excerpt;
pub use excerpt::excerpt;
pub use factors::{FactorError, Factors, find_factors};
pub(crate) use held_out::DelayGain;
pub(crate) use inertial_findings::inertial_findings;
pub(crate) use link_rows::{BodyScale, INACCURATE_FACTOR, LinkRows};
pub use noise::noise;
pub(crate) use noise::{sample_noise, velocity_noise, white_noise};
pub(crate) use play::find_plays;
pub(crate) use prepared::Prepared;
pub use prepared::{PrepareError, prepare};
pub(crate) use row::MotorRowFit;
pub(crate) use smoothed::{CUTOFF_STEP, Smoothed};
pub(crate) use springs::OPEN_STIFFNESS;
pub(crate) use stribeck::rms_speeds;
pub(crate) use sweep::Sweep;
pub(crate) use velocity_by_likelihood::VelocityByLikelihood;

pub(crate) use noise::velocity_per_position;
pub(crate) use row::{OfRow, RowFit, fit_all_rows, fit_rows, independent};
