//! What is chosen before anything is estimated from a log: its beginning, the cut-off of
//! the position filter, signs and gains, delays by least squares, Stribeck velocities and
//! weights of samples.

mod as_given;
mod cutoff;
mod delay;
mod delays;
mod excerpt;
mod factors;
mod found;
mod gain;
mod noise;
mod prepared;
mod row;
mod sign;
mod stribeck;
mod weights;

pub use as_given::as_given;
pub use cutoff::choose_cutoff;
pub use delay::{DelayEstimate, estimate_delays};
pub use delays::{DelayByLikelihood, DelayError, Delays};
pub use excerpt::{Excerpt, excerpt};
pub use factors::{FactorError, Factors, find_factors};
pub use found::{FoundGain, FoundSign};
pub use noise::{noise, velocity_noise, white_noise};
pub use prepared::{PrepareError, Prepared, prepare};
pub use row::{MotorRowFit, fit_motor_rows};
pub use stribeck::find_stribeck;
pub use weights::find_weights;

pub(crate) use noise::velocity_per_position;
pub(crate) use row::{RowFit, fit_rows, independent};
