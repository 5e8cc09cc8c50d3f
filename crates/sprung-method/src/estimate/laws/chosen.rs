//! Chosen laws, and the names of changes.

use sprung_core::parameters::Side;

use super::candidates::Change;
use crate::description::{Experiment, FrictionLaw, Laws, SpringTerm};
use crate::estimate::result::LawsByHoldOut;
use crate::finding::Finding;

/// Largest delay of a torque that its rate of change describes, s.
const MAX_DELAY_S: f64 = 0.02;

/// Laws by hold-out, and the changes that are to be made.
#[derive(Clone)]
pub(in crate::estimate) struct Chosen {
    pub(in crate::estimate) result: LawsByHoldOut,
    /// The experiment with the laws that `"auto"` adds; `None` if it adds none.
    pub(in crate::estimate) experiment: Option<Experiment>,
    pub(in crate::estimate) finding: Option<Finding>,
    /// Joints whose Stribeck velocity the ladder found.
    pub(in crate::estimate) open_velocities: Vec<usize>,
}

/// Returns the setting of the laws for a joint.
pub(in crate::estimate) fn laws_of(experiment: &Experiment, joint: usize) -> Laws {
    experiment.robot.joint[joint]
        .laws
        .unwrap_or(experiment.identify.laws)
}

/// Returns the key that a change concerns, and the name of the law.
pub(super) fn names(change: Change) -> (&'static str, &'static str) {
    match change {
        Change::Friction(Side::Link, family) => ("link_friction", FrictionLaw(family).name()),
        Change::Friction(Side::Motor, family) => ("motor_friction", FrictionLaw(family).name()),
        Change::Spring(SpringTerm::Cubic) => ("spring", "cubic"),
        Change::Spring(SpringTerm::Damping) => ("spring", "damping"),
        Change::Spring(SpringTerm::Linear) => ("spring", "linear"),
        Change::TorqueDelay => ("torque delay", ""),
        Change::TorqueLoad => ("friction proportional to the torque", ""),
    }
}

/// Returns a change in words.
pub(super) fn words(change: Change) -> String {
    let (of, law) = names(change);
    if law.is_empty() {
        of.to_owned()
    } else {
        format!("{of} \"{law}\"")
    }
}

/// Returns whether the rate of change of a torque describes its delay, s.
pub(super) fn is_small(delay: f64) -> bool {
    delay.abs() <= MAX_DELAY_S
}
