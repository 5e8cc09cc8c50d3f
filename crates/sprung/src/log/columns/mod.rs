//! Which columns hold what, and rows of them in SI units.
//!
//! [`from_keys`] makes [`Channels`] of a description; [`names`] finds their columns in a file;
//! [`rows`] unwraps, checks and scales the readings of one stream; [`follow`] interpolates
//! those of other clocks.

pub(super) mod channel;
pub(super) mod channels;
pub(super) mod follow;
mod from_keys;
pub(super) mod mix;
pub(super) mod names;
pub(super) mod origin;
pub(super) mod rows;
mod time;

#[cfg(test)]
pub(crate) use channel::Channel;
pub use channel::ChannelError;
pub use channels::Channels;
pub(crate) use mix::Mix;
#[cfg(test)]
pub(crate) use origin::{Origin, TimeOrigin};
