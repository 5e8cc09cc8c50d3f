//! The identification method: from the description of an experiment and blocks of samples to parameters, standard
//! errors, verdicts and validations.
//!
//! This crate is internal to `sprung`. Its items may change in any version; use the crate `sprung`, which re-exports the
//! public names.

pub mod check;
pub mod compare;
pub mod control;
pub mod estimate;
pub mod excite;
pub mod fit;
pub mod frequency;
pub mod prepare;
pub mod preprocess;
pub mod regression;
pub mod simulate;
pub mod unknowns;
pub mod validate;
pub mod watch;

use sprung_base::{curves, finding, named, numbers, progress, sha256, stopwatch};
use sprung_log as log;
use sprung_model as model;
use sprung_robot as description;

#[cfg(test)]
use sprung_base::demo;
