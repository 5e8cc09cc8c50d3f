//! Sessions without a terminal: every verb, in memory and on disk, run to its end or stopped.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod errors;
mod proof;
mod stopped;
mod support;
mod temperature;
mod verbs;
mod voltage;
