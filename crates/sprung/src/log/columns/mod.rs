//! Assigns columns to quantities, and converts their rows to SI units.
//!
//! [`from_keys`] makes [`Channels`] from a description. [`names`] finds their columns in a file.
//! [`rows`] unwraps, checks and scales the readings of one stream. [`follow`] interpolates streams
//! with their own clock.

pub(super) mod channel;
pub(super) mod channels;
pub(super) mod follow;
mod from_keys;
mod gyroscopes;
pub(super) mod mix;
pub(super) mod names;
pub(super) mod origin;
pub(super) mod rows;
mod time;

#[cfg(test)]
pub(crate) use channel::Channel;
pub use channel::ChannelError;
pub use channels::Channels;
pub(crate) use gyroscopes::{Gyroscope, Gyroscopes};
pub(crate) use mix::Mix;
#[cfg(test)]
pub(crate) use origin::{Origin, TimeOrigin};
