//! What the figures of a log say about its columns.

use super::channels::{Channels, Quantity};
use super::{LogError, Summary};
use crate::finding::{Finding, Severity};

const DEGREES_PER_RADIAN: f64 = 180.0 / std::f64::consts::PI;

/// Judges a log by its figures.
///
/// - `file`: name for messages; `joints`: names of the joints.
///
/// # Errors
///
/// [`LogError::Implausible`] for columns that cannot be what they are said to
/// be: a position that never changes although its joint moves, an encoder in
/// degrees or on the other side of the gearbox beside one in radians.
pub fn check(
    file: &str,
    channels: &Channels,
    joints: &[String],
    summary: &Summary,
) -> Result<Vec<Finding>, LogError> {
    let mut findings = Vec::new();
    for (joint, name) in joints.iter().enumerate() {
        if let Some(finding) = still(file, channels, name, joint, summary)? {
            findings.push(finding);
            continue;
        }
        units(file, channels, name, joint, summary)?;
        findings.extend(degrees(channels, name, joint, summary));
        findings.extend(opposite(channels, name, joint, summary));
    }
    Ok(findings)
}

/// Judges one joint: nothing moves (a finding) or one column alone stands
/// still (an error).
fn still(
    file: &str,
    channels: &Channels,
    name: &str,
    joint: usize,
    summary: &Summary,
) -> Result<Option<Finding>, LogError> {
    let of_joint: Vec<(&str, Quantity, super::summary::Extent)> = channels
        .all
        .iter()
        .enumerate()
        .filter(|(_, channel)| channel.joint == joint)
        .filter_map(|(i, channel)| {
            Some((
                channel.column.as_str(),
                channel.quantity,
                summary.extent(i)?,
            ))
        })
        .collect();
    let moves = |wanted: &[Quantity]| {
        of_joint
            .iter()
            .any(|(_, quantity, extent)| wanted.contains(quantity) && !extent.is_constant())
    };
    if !moves(&[
        Quantity::MotorPosition,
        Quantity::LinkPosition,
        Quantity::LinkDeflection,
    ]) {
        return Ok(Some(Finding::new(
            Severity::Serious,
            "unexcited-joint",
            format!(
                "{name} stands still in all {} samples, so nothing of it can be identified",
                summary.samples()
            ),
            "record a log in which the joint moves through its working range",
        )));
    }
    // The motors of a coupled transmission may stand still while joints move.
    let Some((column, quantity, extent)) =
        of_joint.iter().find(|(_, _, extent)| extent.is_constant())
    else {
        return Ok(None);
    };
    let (unit, likely) = match quantity {
        Quantity::MotorPosition => ("rad", "is the motor encoder connected"),
        Quantity::LinkPosition => ("rad", "is the link encoder connected"),
        Quantity::LinkDeflection => ("rad", "is the deflection sensor connected"),
        Quantity::MotorTorque => ("N·m", "is the current or torque recorded"),
    };
    Err(LogError::Implausible {
        message: format!(
            "{name}: column \"{column}\" never changes ({:.4} {unit} in all {} samples) in {file}; \
             {likely}, or is the column name wrong?",
            extent.first,
            summary.samples()
        ),
    })
}

/// Compares how far the two encoders of a joint move. A spring lets the link
/// swing farther than the motor or less far, but not twenty times.
fn units(
    file: &str,
    channels: &Channels,
    name: &str,
    joint: usize,
    summary: &Summary,
) -> Result<(), LogError> {
    let pair = [Quantity::MotorPosition, Quantity::LinkPosition].map(|quantity| {
        let i = channels.index(quantity, joint)?;
        Some((channels.all[i].column.as_str(), summary.extent(i)?.range()))
    });
    let [Some((motor, motor_range)), Some((link, link_range))] = pair else {
        return Ok(());
    };
    let ratio = motor_range / link_range;
    let likely = if ratio > DEGREES_PER_RADIAN / 3.0 {
        format!(
            "\"{motor}\" looks like degrees (give it as motor_position_deg) or like the motor side of \
             the gearbox (set motor_position_side = \"motor\" in [log] and gear_ratio of the joint)"
        )
    } else if ratio < 3.0 / DEGREES_PER_RADIAN {
        format!("\"{link}\" looks like degrees; give it as link_position_deg")
    } else {
        return Ok(());
    };
    Err(LogError::Implausible {
        message: format!(
            "{name}: \"{motor}\" spans {motor_range:.3} rad and \"{link}\" {link_range:.3} rad in \
             {file}, about the same is expected; {likely}"
        ),
    })
}

fn opposite(channels: &Channels, name: &str, joint: usize, summary: &Summary) -> Option<Finding> {
    let motor = &channels.all[channels.index(Quantity::MotorPosition, joint)?].column;
    let link = &channels.all[channels.index(Quantity::LinkPosition, joint)?].column;
    let correlation = summary.correlation(joint)?;
    (correlation < -0.5).then(|| {
        Finding::new(
            Severity::Warning,
            "opposite-signs",
            format!(
                "{name}: \"{motor}\" and \"{link}\" move against each other (correlation \
                 {correlation:.2}): unless the joint was driven above its resonance, one of them \
                 counts the other way"
            ),
            &format!("set sign = {{ \"{link}\" = -1 }} or sign = {{ \"{motor}\" = -1 }} in [log]"),
        )
    })
}

fn degrees(channels: &Channels, name: &str, joint: usize, summary: &Summary) -> Option<Finding> {
    let motor = channels.index(Quantity::MotorPosition, joint)?;
    let range = summary.extent(motor)?.range();
    // Motors before a coupled transmission turn many times.
    let known = channels.turns[joint] && channels.position_mix.is_none();
    (known && range > std::f64::consts::TAU).then(|| {
        Finding::new(
            Severity::Warning,
            "looks-like-degrees",
            format!(
                "{name}: \"{}\" spans {range:.1} rad, more than a full turn; are these degrees? \
                 ({range:.1}° would be {:.3} rad; stiffness and inertia would come out 57.3 times \
                 too small)",
                channels.all[motor].column,
                range / DEGREES_PER_RADIAN
            ),
            "if the columns hold degrees, name them under motor_position_deg and link_position_deg",
        )
    })
}
