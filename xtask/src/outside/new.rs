//! Forty logs of ten known arms, begun by `sprung new` and identified without an edit.

use super::mujoco::build;
use super::python::Python;
use crate::target;

/// Runs the forty cases; the script prints a table and fails below 36.
pub(super) fn check(python: &Python) -> Option<()> {
    build()?;
    let program = target().join("debug/sprung");
    python.run(
        "benches/arms/forty.py",
        &[&program, &python.folder.join("arms")],
    )
}
