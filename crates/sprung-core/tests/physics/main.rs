//! The equations of motion against laws of physics and independent numbers.
#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a test may panic, and says what it measured or skips"
)]

mod bodies;
mod chains;
mod controllers;
mod laws;
mod linearized;
mod mixed;
mod support;
mod tables;
mod trees;
