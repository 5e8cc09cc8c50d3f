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

pub use channel::{Channel, ChannelError};
pub use channels::Channels;
pub use mix::Mix;
pub use origin::{Origin, Pick, Start, Stream, TimeOrigin};
