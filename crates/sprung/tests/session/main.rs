//! Sessions: every verb without a terminal, in memory and on disk, to the end and stopped.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod errors;
mod stopped;
mod support;
mod verbs;
