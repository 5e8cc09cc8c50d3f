//! Sessions without a terminal: every verb, in memory and on disk, run to its end or stopped.
#![expect(clippy::unwrap_used, reason = "a test may panic")]
#![expect(clippy::print_stdout, reason = "figures for the documentation")]

mod covariates;
mod errors;
mod loaded;
mod many_logs;
mod proof;
mod regions;
mod sampled;
mod stopped;
mod support;
mod verbs;
mod voltage;
mod what_works;
