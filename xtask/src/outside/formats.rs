//! Logs written again by NumPy, SciPy, h5py, pandas, Arrow, MCAP and rosbags.

use std::process::Command;

use super::python::Python;
use crate::install::hdf5;
use crate::steps::succeeds;
use crate::test::features;

/// Runs the tests that read the same numbers from every format, on new files.
pub(super) fn check(python: &Python) -> Option<()> {
    let folder = python.folder.join("formats");
    python.run("crates/sprung/tests/formats/make_fixtures.py", &[&folder])?;
    let folder = folder
        .canonicalize()
        .inspect_err(|error| eprintln!("── {}: {error}", folder.display()))
        .ok()?;
    let tests = ["test", "--workspace", "--test", "formats", features(hdf5())];
    succeeds(
        Command::new(env!("CARGO"))
            .args(tests)
            .args(["--", "same"])
            .env("SPRUNG_TEST_FORMATS", folder),
    )
}
