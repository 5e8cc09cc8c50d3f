//! Which gains of columns a log can tell.

use crate::log::{Channel, Channels, Quantity};
use crate::model::Model;

/// Checks that a log can tell a gain that is to be estimated.
///
/// # Errors
///
/// The reason why it cannot, and a remedy.
pub(super) fn tellable(model: &Model, channels: &Channels, channel: usize) -> Result<(), String> {
    let source = &channels.all[channel];
    let name = &model.joints()[source.joint];
    let told = |why: String| {
        Err(format!(
            "the gain of \"{}\" cannot be estimated: {why}",
            source.column
        ))
    };
    let other = match source.quantity {
        Quantity::MotorTorque => return torque(model, channels, source.joint).or_else(told),
        Quantity::LinkPosition => Quantity::MotorPosition,
        Quantity::MotorPosition => Quantity::LinkPosition,
        Quantity::JointTorque => {
            return told(
                "sprung check compares the torque sensor with the motor torque, and a weight of known mass tells which \
                 of them is right; give it as a number in gain"
                    .to_owned(),
            );
        }
        Quantity::LinkDeflection
        | Quantity::MotorTarget
        | Quantity::DriveOn
        | Quantity::Inertial(..)
        | Quantity::Covariate(_) => {
            return told(format!(
                "it is the gain of a deflection of {name}, and the stiffness scales with it; give it as a number in gain"
            ));
        }
    };
    let Some(other) = channels.index(other, source.joint) else {
        return told(format!(
            "{name} has no other position to compare with, and all parameters scale with the gain; give it as a number \
             in gain"
        ));
    };
    let beside = &channels.all[other];
    if beside.open_gain {
        return told(format!(
            "the gain of \"{}\" is to be estimated as well, but one of the two must be known; give one as a number in \
             gain",
            beside.column
        ));
    }
    Ok(())
}

/// Checks that something tells the gain of a torque: a known parameter of its equation, or a torque of another joint.
fn torque(model: &Model, channels: &Channels, joint: usize) -> Result<(), String> {
    if channels.inertial.is_some() || !model.joints_without_link().is_empty() {
        return Err(
            "this needs the motor and link position of each joint with a spring; give it as a number in gain".to_owned(),
        );
    }
    let rows = (0..model.rows()).filter(|&row| model.joint_of(row) == joint);
    let mut columns = rows.flat_map(|row| model.row_columns(row));
    let is_other = |channel: &Channel| {
        channel.quantity == Quantity::MotorTorque && channel.joint != joint && !channel.open_gain
    };
    if channels.all.iter().any(is_other) || columns.any(|&column| model.known(column).is_some()) {
        return Ok(());
    }
    let name = &model.joints()[joint];
    Err(format!(
        "all parameters of {name} scale with it, and none of them is known; give a parameter as a number, as in fixed = {{ \
         \"{name}.rotor_inertia\" = 0.02 }} under [robot], or give the gain"
    ))
}
