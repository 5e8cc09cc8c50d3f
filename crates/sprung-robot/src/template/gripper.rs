//! Distinguishes the joints of a gripper from those of the arm.

use sprung_core::chain::JointKind;

use crate::urdf::{Urdf, UrdfJoint};

/// Parts of names, and whole words, of grippers.
const PARTS: [&str; 5] = ["finger", "gripper", "knuckle", "thumb", "jaw"];
const WORDS: [&str; 2] = ["hand", "tool"];

/// Largest stroke of a slide that only a gripper has, m.
const STROKE: f64 = 0.06;

/// Returns why a joint is one of a gripper; `None` for a joint of the arm.
///
/// A joint with a name of a gripper is one. At the end of the arm, a joint that another one mimics is one as well, and
/// so is a short slide of a robot with revolute joints.
pub(super) fn of_gripper(joint: &UrdfJoint, urdf: &Urdf) -> Option<String> {
    let name = joint.name.to_lowercase();
    let mut words = name.split(|c: char| !c.is_alphabetic());
    if PARTS.iter().any(|part| name.contains(part)) || words.any(|word| WORDS.contains(&word)) {
        return Some("by its name".to_owned());
    }
    if !joint.is_last {
        return None;
    }
    if let Some((follower, _)) = urdf.mimics().find(|(_, leader)| *leader == joint.name) {
        return Some(format!("because {follower} mimics it"));
    }
    let stroke = joint
        .lower
        .zip(joint.upper)
        .map(|(lower, upper)| upper - lower);
    let turns = |other: &UrdfJoint| other.kind == JointKind::Revolute;
    let is_short =
        joint.kind == JointKind::Prismatic && stroke.is_some_and(|stroke| stroke < STROKE);
    (is_short && urdf.movable().iter().any(turns))
        .then(|| "because it slides less than 60 mm".to_owned())
}
