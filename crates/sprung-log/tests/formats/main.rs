//! Logs in every format. Programs that people use wrote them (`make_fixtures.py`).
#![expect(clippy::unwrap_used, reason = "a test may panic")]
#![expect(clippy::print_stdout, reason = "figures for people")]

mod archives;
mod bags;
mod broken;
mod clocks;
mod db3;
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
mod windows;

#[cfg(not(feature = "mat73"))]
#[test]
fn matlab_7_3() {
    sprung_testing::skipped(
        "hdf5",
        "built without the feature mat73, which needs libhdf5",
    );
}
