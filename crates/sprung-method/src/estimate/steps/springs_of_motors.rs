//! The springs of joints whose motors alone are measured.

use super::basis::Basis;
use crate::finding::Finding;
use crate::frequency::{SpringFromMotor, about_springs, springs_from_motor};

/// Returns the springs from the motors, if the settings request them, and findings about them.
pub(super) fn springs_of_motors(basis: &Basis<'_>) -> (Vec<SpringFromMotor>, Vec<Finding>) {
    let reading = basis.ready.prepared.reading();
    if !reading.settings().springs_from_motor {
        return (Vec::new(), Vec::new());
    }
    let springs = springs_from_motor(&basis.read.record, reading.model());
    let names = basis.ready.prepared.names().join(", ");
    let findings = about_springs(&springs, reading.model(), &names);
    (springs, findings)
}
