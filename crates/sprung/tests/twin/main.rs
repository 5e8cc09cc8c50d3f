//! The whole way from experiment to report, on the digital twin of the demo.
#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test may panic, and says what it measured or skips"
)]

mod arrays;
mod golden;
mod in_memory;
mod instruments;
mod ladder;
mod linear;
mod output_error;
mod paper;
mod progress;
mod refined;
mod report;
mod robots;
mod robust;
mod seven;
mod support;
