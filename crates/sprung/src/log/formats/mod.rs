//! Formats of logs: each turns a file into rows of numbers.
//!
//! What a file is shows in its first bytes; its name says nothing. A format
//! reads the wanted columns in blocks, and knows neither units nor joints.

mod array_shape;
mod arrays;
#[cfg(feature = "arrow")]
mod arrow;
#[cfg(feature = "arrow")]
mod arrow_claims;
mod bag;
mod cdr;
mod csv;
mod damaged;
mod db3;
mod definition;
mod delimited;
mod mat;
#[cfg(feature = "mat73")]
mod mat73;
mod matlab;
#[cfg(feature = "mcap")]
mod mcap;
pub(super) mod memory;
mod npy;
mod number;
pub(super) mod open;
mod sqlite;
mod strips;
pub(super) mod table;
mod zip;

pub use damaged::panics_are_caught;
