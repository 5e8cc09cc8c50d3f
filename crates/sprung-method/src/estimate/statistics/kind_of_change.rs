//! The kind of parameters on which several logs disagree.

use sprung_core::parameters::JointParameter;

use crate::model::Model;

/// Returns a sentence about the kind of change between logs, with a space before it; empty if
/// parameters of several kinds disagree.
///
/// - `disagreeing`: indices in theta.
pub(in crate::estimate) fn kind_of_change(model: &Model, disagreeing: &[usize]) -> &'static str {
    let all = |is_kind: &dyn Fn(Option<JointParameter>) -> bool| {
        let kinds = disagreeing.iter().map(|&i| model.parameters()[i].joint);
        !disagreeing.is_empty() && kinds.map(|joint| joint.map(|(kind, _)| kind)).all(is_kind)
    };
    if all(&|kind| matches!(kind, Some(JointParameter::Friction(..)))) {
        " Only friction disagrees: it changed between the logs (temperature, load, wear?)."
    } else if all(&|kind| kind.is_none()) {
        " Only inertial parameters of links disagree: does the robot carry a payload in one log?"
    } else if all(&|kind| kind == Some(JointParameter::Stiffness)) {
        " Only stiffnesses disagree: does the scale of an encoder differ between the logs?"
    } else {
        ""
    }
}
