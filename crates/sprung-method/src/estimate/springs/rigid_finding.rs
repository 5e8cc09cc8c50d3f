//! The finding about joints that are taken as rigid.

use crate::estimate::result::RigidJoint;
use crate::estimate::statistics::NORMAL_95;
use crate::finding::{Finding, Severity};
use crate::model::Model;
use crate::numbers::rounded_down;
use sprung_core::chain::JointKind;

/// Code of the finding that a log does not determine springs.
pub(in crate::estimate) const NOT_DETERMINED: &str = "stiffness-not-determined";

/// Returns the finding about joints that are taken as rigid; `None` without such joints.
pub(in crate::estimate) fn finding(model: &Model, joints: &[RigidJoint]) -> Option<Finding> {
    let (first, more) = joints.split_first()?;
    let bounds: Vec<String> = joints.iter().map(|joint| bound(model, joint)).collect();
    let (their, they) = if more.is_empty() {
        ("its deflection", "it is")
    } else {
        ("their deflections", "they are")
    };
    let is_open = |joint: &RigidJoint| {
        joint.compliance_rad_per_nm < NORMAL_95 * joint.compliance_standard_error_rad_per_nm
    };
    let shows = if joints.iter().all(is_open) {
        "does not show"
    } else {
        "hardly shows"
    };
    let replaced: Vec<&str> = (joints.iter())
        .filter(|joint| joint.hold_out.is_some())
        .map(|joint| joint.joint.as_str())
        .collect();
    let equations = if replaced.is_empty() {
        ". The torque sensor separates link and motor; simulations take the spring at the bound"
            .to_owned()
    } else {
        format!(
            ". The log shows only the sum of link and motor of {}: one friction, and the rotor with the links",
            replaced.join(", ")
        )
    };
    let names = std::iter::once(first).chain(more);
    Some(
        Finding::new(
            Severity::Info,
            NOT_DETERMINED,
            format!(
                "{} (95 %): the log {shows} {their}; {they} taken as rigid{equations}",
                bounds.join(", ")
            ),
            "for a stiffness record larger torques, faster motion or finer encoders; otherwise nothing",
        )
        .about(names.map(RigidJoint::stiffness)),
    )
}

fn bound(model: &Model, rigid: &RigidJoint) -> String {
    let at = model.joints().iter().position(|name| *name == rigid.joint);
    let unit = match at.map(|joint| model.kind(joint)) {
        Some(JointKind::Prismatic) => "N/m",
        Some(JointKind::Revolute) | None => "N·m/rad",
    };
    format!(
        "{} is stiffer than {} {unit}",
        rigid.joint,
        rounded_down(rigid.stiffness_above_nm_per_rad)
    )
}
