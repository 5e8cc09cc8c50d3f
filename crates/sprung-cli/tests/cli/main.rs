//! The program as a user runs it.

#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "these are tests"
)]

mod bad_experiment;
mod bad_log;
mod browser;
mod common;
mod new;
mod outputs;
mod readme;
mod real_machine;
mod trust;
