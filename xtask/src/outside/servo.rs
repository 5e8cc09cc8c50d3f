//! A servo that logs targets and positions, identified by sprung and by BAM's CMA-ES from the same logs.

use std::path::Path;

use super::mujoco::build;
use super::python::Python;
use crate::target;

/// Trials of CMA-ES: enough for a comparison with sprung, not for convergence.
const TRIALS: &str = "50";

/// Identifies the servo of `examples/servo-pendulum`; the script prints a table and fails if sprung is more
/// than 5 % off.
pub(super) fn check(python: &Python) -> Option<()> {
    build()?;
    let program = target().join("debug/sprung");
    let folder = python.folder.join("servo");
    python.run(
        "benches/peers/servo_bam.py",
        &[&program, &folder, Path::new(TRIALS)],
    )
}
