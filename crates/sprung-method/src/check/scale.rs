//! Units and sides of the gearbox that explain a factor between torques and nominal values.

use super::context::CheckContext;
use crate::description::Joint;
use crate::log::{Quantity, rounded};

/// Ratios of usual gears.
pub(super) const USUAL_RATIOS: [f64; 11] = [
    30.0, 50.0, 51.0, 80.0, 81.0, 100.0, 101.0, 120.0, 121.0, 160.0, 161.0,
];

/// Factors of other units of one torque, beside mN·m, and their inverses.
pub(super) const POWERS_OF_TEN: [f64; 5] = [10.0, 100.0, 0.1, 0.01, 0.001];

/// A mistake in the description of the torques.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Explanation {
    /// Factor by which the torques of each joint are wrong.
    pub(super) factors: Vec<f64>,
    /// The mistake, as a sentence without its end.
    pub(super) cause: String,
    /// Table of the experiment file.
    pub(super) table: &'static str,
    /// Line that corrects the mistake.
    pub(super) line: String,
}

/// Returns the mistakes that are possible for some joints.
pub(super) fn explanations(context: &CheckContext<'_>, joints: &[usize]) -> Vec<Explanation> {
    let robot = &context.experiment.robot;
    let robot_joints = context.reading.model().joint_count();
    let key = context.key(Quantity::MotorTorque);
    let columns = context.column_list(Quantity::MotorTorque);
    let is_current = key.starts_with("motor_current");
    let is_voltage = key.starts_with("drive_voltage");
    let channels = context.reading.channels();
    let before_gear = (joints.first())
        .and_then(|&joint| channels.index(Quantity::MotorTorque, joint))
        .is_some_and(|index| channels.all[index].before_gear);
    let side = side_of_torques(context);
    let all = |factor: &dyn Fn(usize) -> Option<f64>| -> Option<Vec<f64>> {
        joints.iter().map(|&joint| factor(joint)).collect()
    };
    let ratio = |joint: usize| -> Option<f64> {
        let given = match &robot.transmission_matrix {
            Some(matrix) => *matrix.get(joint)?.get(joint)?,
            None => robot.joint.get(joint)?.gear_ratio?,
        };
        Some(given.abs())
    };
    let mut found = Vec::new();
    let gear = if before_gear {
        (
            all(&ratio),
            "The torques are probably those after the gearbox already, and sprung multiplies them by \
             gear_ratio",
            "output",
        )
    } else {
        (
            all(&|joint| Some(ratio(joint)?.recip())),
            "The torques are probably those of the motors before the gearbox, which sprung takes for torques \
             after it",
            "motor",
        )
    };
    if let (Some(factors), cause, word) = gear {
        found.push(Explanation {
            factors,
            cause: cause.to_owned(),
            table: side.0,
            line: format!("{} = \"{word}\"", side.1),
        });
    }
    let thousand = if is_current {
        ("milliamperes", "motor_current", "mA")
    } else if is_voltage {
        ("millivolts", "drive_voltage", "mV")
    } else {
        ("millinewton metres", "motor_torque", "mN·m")
    };
    found.push(Explanation {
        factors: vec![1e3; joints.len()],
        cause: format!("The readings are probably {}", thousand.0),
        table: "[log]",
        line: format!(
            "{} = {{ column = {columns}, unit = \"{}\" }}",
            thousand.1, thousand.2
        ),
    });
    let constant = |joint: usize| {
        let of = robot.joint.get(joint).and_then(Joint::torque_per_ampere)?;
        Some(of.abs())
    };
    let of_constant = if is_current {
        (
            all(&constant),
            "The readings are probably torques already, and sprung multiplies them by the torque constant",
            "motor_torque_nm",
        )
    } else {
        (
            all(&|joint| Some(constant(joint)?.recip())),
            "The readings are probably currents, and sprung takes them for torques",
            "motor_current_a",
        )
    };
    if let (Some(factors), cause, key) = of_constant {
        found.push(Explanation {
            factors,
            cause: cause.to_owned(),
            table: "[log]",
            line: format!("{key} = {columns}"),
        });
    }
    if let [joint] = joints
        && robot_joints > 1
    {
        found.extend(POWERS_OF_TEN.map(|factor| Explanation {
            factors: vec![factor],
            cause: "The readings have probably another unit, by a power of ten".to_owned(),
            table: "[log]",
            line: String::new(),
        }));
        for cause in &mut found {
            (cause.table, cause.line) = ("[log]", gain_line(context, *joint, cause.factors[0]));
        }
    }
    found
}

/// Returns the line that corrects the torque of one joint.
///
/// - `factor`: factor by which the torque is wrong.
pub(super) fn gain_line(context: &CheckContext<'_>, joint: usize, factor: f64) -> String {
    format!(
        "gain = {{ \"{}\" = {} }}",
        context.column(&[Quantity::MotorTorque], joint),
        rounded(factor.recip())
    )
}

/// Returns table and key of the side of the gearbox of the torques.
pub(super) fn side_of_torques(context: &CheckContext<'_>) -> (&'static str, &'static str) {
    let key = context.key(Quantity::MotorTorque);
    if key.starts_with("motor_current") || key.starts_with("drive_voltage") {
        ("[[robot.joint]]", "torque_constant_side")
    } else {
        ("[log]", "motor_torque_side")
    }
}
