//! Assigns columns to quantities, and converts their rows to SI units.
//!
//! [`from_keys`] makes [`Channels`] from a description. [`names`] finds their columns in a file.
//! [`rows`] unwraps, checks and scales the readings of one stream. [`follow`] interpolates streams
//! with their own clock.

pub(super) mod channel;
pub(super) mod channels;
pub(super) mod follow;
mod from_keys;
mod inertial;
pub(super) mod mix;
pub(super) mod names;
pub(super) mod origin;
pub(super) mod rows;
mod time;

pub use channel::Channel;
pub use channel::ChannelError;
pub use channels::{Channels, CovariateOfJoint};
pub use inertial::{InertialSensor, InertialSensors, LinkMotion};
pub use mix::Mix;
pub use origin::{Origin, TimeOrigin};
pub use time::TimeSource;
