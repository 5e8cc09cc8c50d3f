//! Logs in every format, written by the programs that people use
//! (`make_fixtures.py`), read back.
#![expect(clippy::unwrap_used, reason = "a test may panic")]
#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "figures for people"
)]

mod bags;
mod broken;
mod clocks;
mod keys;
mod machines;
#[cfg(feature = "mat73")]
mod mat73;
mod mcap_bytes;
mod memory;
mod resampling;
mod same;
mod support;
mod units;
