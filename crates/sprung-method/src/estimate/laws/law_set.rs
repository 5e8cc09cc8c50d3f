//! Chosen laws, and the names of changes.

use std::collections::BTreeSet;

use sprung_core::parameters::Side;

use super::candidates::Change;
use crate::description::{Experiment, FrictionLaw, Laws, SpringTerm};
use crate::estimate::result::LawsByHoldOut;
use crate::finding::Finding;

/// Laws by cross-validation, and the changes to be made.
#[derive(Clone)]
pub(in crate::estimate) struct Chosen {
    pub(in crate::estimate) result: LawsByHoldOut,
    /// The experiment with the laws that `"auto"` adds; `None` if it adds none.
    pub(in crate::estimate) experiment: Option<Experiment>,
    pub(in crate::estimate) finding: Option<Finding>,
    /// Joints whose Stribeck velocity the ladder found.
    pub(in crate::estimate) open_velocities: Vec<usize>,
}

impl Chosen {
    /// Returns whether other chosen laws add the same.
    pub(in crate::estimate) fn adds_as(&self, other: &Self) -> bool {
        let added = |chosen: &Self| -> BTreeSet<[String; 3]> {
            (chosen.result.rungs.iter().filter(|rung| rung.made))
                .map(|rung| [&rung.joint, &rung.of, &rung.law].map(String::clone))
                .collect()
        };
        added(self) == added(other)
    }
}

/// Returns the setting of the laws for a joint.
pub(super) fn laws_of(experiment: &Experiment, joint: usize) -> Laws {
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
