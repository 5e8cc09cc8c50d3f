//! Finds the side of the gearbox for which the torque constants hold, from the masses of the links.

use super::estimated_columns::FoundSide;
use super::excerpt::Excerpt;
use super::link_rows::{INACCURATE_FACTOR, LinkRows};
use super::row::independent;
use crate::description::{Joint, Side};
use crate::log::{Channel, Quantity, rounded};
use crate::regression::Reading;

/// Returns the side of the open torque constants.
///
/// The torques of the right side carry the nominal bodies of the links; those of the other side are too large or too
/// small by the gear ratio.
///
/// # Errors
///
/// The reason, with the torques of both sides and the remedy, if the log does not determine the side.
pub(super) fn torque_side(
    joints: &[Joint],
    reading: &Reading,
    excerpt: &Excerpt,
    file: &str,
) -> Result<FoundSide, String> {
    let channels = &reading.channels().all;
    let open: Vec<(usize, &Channel)> = (channels.iter().enumerate())
        .filter(|(_, channel)| channel.open_side)
        .collect();
    let Some(&(index, first)) = open.first() else {
        return Err("no torque constant has an open side".to_owned());
    };
    let not_told = |because: &str| {
        let joint = &joints[first.joint];
        let largest = (excerpt.channel(index)).fold(0.0, |most: f64, tau| most.max(tau.abs()));
        let both = match joint.gear_ratio {
            Some(ratio) => format!(
                "gear_ratio = {ratio} is not 1. If the constant holds for the output (it contains the gear ratio), the \
                 largest torque at the beginning of the log is {} N·m; if it holds for the motor, the torque at the output \
                 is {} N·m",
                rounded(largest),
                rounded(largest * ratio.abs())
            ),
            None => "the transmission is coupled".to_owned(),
        };
        Err(format!(
            "{file}: {}: the side of torque_constant_nm_per_a is not given, and {both}. {because}. Add \
             torque_constant_side = \"output\" or torque_constant_side = \"motor\" to [robot.joint_defaults]",
            joint.name,
        ))
    };
    let model = reading.model();
    if open
        .iter()
        .any(|(_, channel)| joints[channel.joint].gear_ratio.is_none())
    {
        return not_told("The motion does not tell the side of a coupled transmission");
    }
    let Some(bodies) = model.nominal_bodies() else {
        return not_told(
            "The motion does not tell the side, because the links have no nominal masses",
        );
    };
    let moving: Vec<usize> = (channels.iter().enumerate())
        .filter(|(i, channel)| {
            channel.quantity == Quantity::MotorPosition && excerpt.deviation(*i) > 0.0
        })
        .map(|(_, channel)| channel.joint)
        .collect();
    let independent = independent(excerpt, reading);
    let rows = (model.joints_without_link().is_empty())
        .then(|| LinkRows::new(excerpt, reading, &moving))
        .flatten();
    let scales: Vec<(f64, f64)> = (rows.iter())
        .flat_map(|rows| rows.scales(model, &bodies))
        .filter(|body| body.is_determined(independent))
        .filter(|body| open.iter().any(|(_, channel)| channel.joint == body.joint))
        .map(|body| (body.scale, body.scale * joints[body.joint].ratio().abs()))
        .collect();
    if scales.is_empty() {
        return not_told(
            "The motion does not tell the side, because the nominal masses explain too little of the torques",
        );
    }
    let agrees = |scale: f64| scale.ln().abs() < INACCURATE_FACTOR.ln();
    let shown = |of: fn(&(f64, f64)) -> f64| {
        let all: Vec<String> = scales.iter().map(|scale| rounded(of(scale))).collect();
        all.join(", ")
    };
    let [output, motor] = [|scale: &(f64, f64)| scale.0, |scale: &(f64, f64)| scale.1];
    let (side, with, without) = match [output, motor]
        .map(|of| scales.iter().all(|scale| agrees(of(scale))))
    {
        [true, false] => (Side::Output, shown(output), shown(motor)),
        [false, true] => (Side::Motor, shown(motor), shown(output)),
        [both, _] => {
            return not_told(&format!(
                "The motion does not tell the side: the torques are {} times those of the nominal masses with \"output\", \
                 and {} times with \"motor\", so {} side agrees",
                shown(output),
                shown(motor),
                if both { "either" } else { "neither" }
            ));
        }
    };
    Ok(FoundSide {
        side,
        column: first.column.clone(),
        because: format!(
            "so the torques are {with} times those of the nominal masses; for the other side they would be {without} times"
        ),
    })
}
