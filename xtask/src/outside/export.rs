//! Exported robots, loaded by MuJoCo, Pinocchio and Drake.

use super::mujoco::build;
use super::python::Python;
use super::target;

/// Exports robots with known parameters and compares the dynamics of the tools; the script prints a table
/// and fails above its limits.
pub(super) fn check(python: &Python) -> Option<()> {
    build()?;
    let program = target().join("debug/sprung");
    python.run(
        "benches/export/tools.py",
        &[&program, &python.folder.join("export")],
    )
}
