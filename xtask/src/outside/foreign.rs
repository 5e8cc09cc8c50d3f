//! Logs whose torques do not act when they are recorded, of an arm whose friction is sharper than usual.

use super::mujoco::build;
use super::python::Python;
use crate::target;

/// Identifies two such logs; the script prints tables and fails if a requirement is missed.
pub(super) fn check(python: &Python) -> Option<()> {
    build()?;
    let program = target().join("debug/sprung");
    let folder = python.folder.join("foreign");
    python.run(
        "benches/foreign/run.py",
        &[
            &"--strict",
            &"--binary",
            &program,
            &"--out",
            &folder,
            &"--arms",
            &"ur5",
            &"--seeds",
            &"1-1",
            &"--sharpness",
            &"200",
            &"--records",
            &"held,late",
            &"--rates",
            &"250",
        ],
    )
}
