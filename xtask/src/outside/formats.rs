//! Logs written again by NumPy, SciPy, h5py, pandas, Arrow, MCAP and rosbags.

use super::python::Python;
use crate::install::hdf5;
use crate::steps::{cargo, said, succeeds};
use crate::test::features;
use crate::test::{FORMATS, check_of};

/// Runs the tests that read the same numbers from every format, on new files.
pub(super) fn check(python: &Python) -> Option<()> {
    let folder = python.folder.join("formats");
    python.run(
        "crates/sprung-log/tests/formats/make_fixtures.py",
        &[&folder],
    )?;
    let folder = said(folder.display(), folder.canonicalize())?;
    let tests = ["test", "--workspace", "--test", "formats", features(hdf5())];
    succeeds(
        cargo()
            .args(tests)
            .args(["--", "same"])
            .env("SPRUNG_TEST_FORMATS", folder),
    )
}

/// Checks the feature `mat73-static`, with the CMake of pip: that of Debian 12 is too old for libhdf5.
pub(super) fn with_own_libhdf5(python: &Python) -> Option<()> {
    let mut command = cargo();
    command.args(check_of(FORMATS, "mat73-static"));
    succeeds(command.env("CMAKE", python.script("cmake")))
}
