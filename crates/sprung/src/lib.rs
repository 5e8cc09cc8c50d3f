//! Identifies the dynamic parameters of flexible-joint robots from logs.
//!
//! Data flow in one direction: a module uses only the modules to its left.
//!
//! ```text
//! finding, curves, named, progress, stopwatch |
//! description → model → log → simulate → preprocess → regression → fit → prepare → check → estimate → validate → compare → session → report
//! ```
//!
//! A [`session::Session`] does all the work on an experiment and its logs, and opens their files.
//! All other functions take values and readers and return values or strings. The library prints
//! nothing. It uses SI units and radians internally.

pub mod check;
pub mod compare;
pub mod curves;
pub mod demo;
pub mod description;
pub mod estimate;
pub mod finding;
mod fit;
pub mod log;
pub mod model;
pub mod named;
#[doc(hidden)]
pub mod prepare;
#[doc(hidden)]
pub mod preprocess;
pub mod progress;
#[doc(hidden)]
pub mod regression;
pub mod report;
pub mod session;
pub mod simulate;
mod stopwatch;
pub mod validate;

#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
