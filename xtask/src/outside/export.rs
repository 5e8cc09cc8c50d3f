//! Exported robots, loaded by MuJoCo, Pinocchio and Drake, and exported code beside Pinocchio's.

use super::mujoco::build;
use super::python::Python;
use crate::target;

/// Exports robots with known parameters, compares the dynamics of the tools, runs a designed controller in MuJoCo, and times
/// exported code beside Pinocchio's rnea; the scripts print tables and fail above their limits.
pub(super) fn check(python: &Python) -> Option<()> {
    build()?;
    let program = target().join("debug/sprung");
    let folder = python.folder.join("export");
    python.run("benches/export/tools.py", &[&program, &folder])?;
    python.run("benches/export/controlled.py", &[&program, &folder])?;
    python.run("benches/export/rnea.py", &[&program, &folder])
}
