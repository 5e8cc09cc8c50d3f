//! The equations of motion against laws of physics and independent numbers.
#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test may panic, and prints what it measured"
)]

mod bodies;
mod chains;
mod closed_form;
mod controllers;
mod feedforward;
mod laws;
mod linearized;
mod mixed;
#[path = "../planar_2r/mod.rs"]
mod planar_2r;
#[path = "../planar_2r/rows.rs"]
mod rows;
mod shapers;
mod support;
mod tables;
mod trees;
