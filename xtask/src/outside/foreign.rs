//! Logs whose torques do not act when they are recorded, of an arm whose friction is sharper than usual.

use std::path::Path;

use super::mujoco::build;
use super::python::Python;
use crate::target;

/// Robot and records: two logs, of a minute each.
const LOGS: [&str; 12] = [
    "--jobs",
    "2",
    "--arms",
    "ur5",
    "--seeds",
    "1-1",
    "--sharpness",
    "200",
    "--records",
    "held,late",
    "--rates",
    "500",
];

/// Identifies the logs; the script prints tables and fails if a requirement is missed.
pub(super) fn check(python: &Python) -> Option<()> {
    build()?;
    let program = target().join("debug/sprung");
    let folder = python.folder.join("foreign");
    let mut arguments = vec![
        Path::new("--strict"),
        Path::new("--binary"),
        &program,
        Path::new("--out"),
        &folder,
    ];
    arguments.extend(LOGS.map(Path::new));
    python.run("benches/foreign/run.py", &arguments)
}
