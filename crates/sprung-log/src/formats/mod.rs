//! Formats of logs: each turns a file into rows of numbers.
//!
//! The first bytes of a file determine its format; its name is ignored. A format reads the wanted columns in
//! blocks; it does not deal with units or joints.

mod array_shape;
mod arrays;
#[cfg(feature = "arrow")]
mod arrow;
#[cfg(feature = "arrow")]
mod arrow_claims;
#[cfg(feature = "arrow")]
mod arrow_lists;
#[cfg(feature = "arrow")]
mod arrow_shared;
#[cfg(any(feature = "db3", feature = "mcap"))]
mod bag;
#[cfg(any(feature = "db3", feature = "mcap"))]
mod cdr;
pub(super) mod contents;
mod csv;
mod damaged;
#[cfg(feature = "db3")]
mod db3;
#[cfg(any(feature = "db3", feature = "mcap"))]
mod definition;
mod delimited;
mod json;
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
mod recording;
#[cfg(feature = "db3")]
mod sqlite;
mod strips;
pub(super) mod table;
mod zip;

pub use damaged::panics_are_caught;
