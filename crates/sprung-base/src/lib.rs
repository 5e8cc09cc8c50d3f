//! Values that every stage may return: findings, curves, ellipsoids, named numbers, progress, digests.
//!
//! This crate is internal to `sprung`. Its items may change in any version; use the crate `sprung`, which re-exports the
//! public names.

pub mod curves;
pub mod demo;
pub mod ellipsoid;
pub mod explanation;
pub mod finding;
pub mod foreign;
pub mod limits;
pub mod named;
pub mod numbers;
pub mod progress;
pub mod sha256;
pub mod stopwatch;
