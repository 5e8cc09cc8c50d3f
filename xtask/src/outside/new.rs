//! A hundred logs of ten known arms, begun by `sprung new` and identified without an edit.

use super::mujoco::build;
use super::python::Python;
use crate::target;

/// Runs the cases; the script prints a table and fails below 55 of the first sixty and 36 of the other forty.
pub(super) fn check(python: &Python) -> Option<()> {
    build()?;
    let program = target().join("debug/sprung");
    python.run(
        "benches/arms/known_arms.py",
        &[&program, &python.folder.join("arms")],
    )
}
