//! The result for one joint.

use sprung_core::parameters::JointParameter;

use crate::estimate::result::{EstimateResult, MotorRowResult, ParameterEstimate};
use crate::model::Model;

/// Returns the fit of a joint's motor row alone.
pub(super) fn motor_row<'a>(
    model: &Model,
    result: &'a EstimateResult,
    joint: usize,
) -> Option<&'a MotorRowResult> {
    let name = &model.joints()[joint];
    result.motor_rows.iter().find(|row| row.joint == *name)
}

/// Returns a parameter of a flexible joint, if the joint has it.
pub(super) fn of<'a>(
    model: &Model,
    result: &'a EstimateResult,
    kind: JointParameter,
    joint: usize,
) -> Option<&'a ParameterEstimate> {
    // The rotor of a rigid joint is lumped with its link.
    (model.is_flexible(joint)).then_some(())?;
    Some(&result.parameters[model.index(kind, joint)?])
}
