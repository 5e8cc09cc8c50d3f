//! Effects that the model lacks, and wrong descriptions, in a log.

use crate::arm::{Arm, Drive};
use crate::columns::Table;
use crate::kind::{Fault, Misfit, WrongUnit};

/// Velocity below which the friction of an effect that the model lacks changes its direction, rad/s.
const REVERSAL_RAD_PER_S: f64 = 0.01;

/// Returns the torque that a log contains if the robot has an effect that the model lacks.
///
/// - `motion`: link position, motor position and its velocity; `part`: time over duration.
pub(crate) fn logged_torque(
    drive: &Drive,
    misfit: Misfit,
    torque: f64,
    [q, phi, velocity]: [f64; 3],
    part: f64,
) -> f64 {
    let direction = (velocity / REVERSAL_RAD_PER_S).tanh();
    match misfit {
        Misfit::Ripple(size, periods) => torque + size * drive.effort * (periods * phi).sin(),
        Misfit::Warming(change) => torque + change * part * drive.motor_coulomb * direction,
        Misfit::LoadFriction(factor) => {
            torque + factor * (drive.stiffness * (phi - q)).abs() * direction
        }
        Misfit::Saturation(change) => {
            torque / (1.0 + change * (torque / drive.effort).powi(2)).max(0.5)
        }
        Misfit::Stribeck(_)
        | Misfit::Cubic(_)
        | Misfit::TorqueDelay(_)
        | Misfit::Eccentric(_)
        | Misfit::LateLinks(_) => torque,
    }
}

/// Applies delays and wrong units to a log.
pub(crate) fn damage(arm: &Arm, seed: u64, table: &mut Table, fault: Fault) {
    let n = arm.joints();
    let (one, two) = (seed as usize % n, (seed as usize + 1) % n);
    let (links, motors, torques) = (0..n, n..2 * n, 2 * n..3 * n);
    let wrong = match fault {
        Fault::Misfit(Misfit::TorqueDelay(samples)) => {
            // The record precedes the action: the positions belong to earlier rows.
            table.shift(0..2 * n, samples);
            return;
        }
        Fault::Misfit(Misfit::LateLinks(samples)) => {
            table.shift(links, samples);
            return;
        }
        Fault::WrongUnit(wrong) => wrong,
        Fault::None | Fault::Misfit(_) | Fault::Weak(_) => return,
    };
    match wrong {
        WrongUnit::MotorSide { one: single } => {
            for (joint, drive) in arm.drives.iter().enumerate() {
                if !single || joint == one {
                    table.scale(2 * n + joint, 1.0 / drive.gear_ratio);
                }
            }
        }
        WrongUnit::Millinewton => torques.for_each(|column| table.scale(column, 1e3)),
        WrongUnit::Current(constant) => {
            torques.for_each(|column| table.scale(column, 1.0 / constant));
        }
        WrongUnit::Degrees { all } => {
            let first = if all { 0 } else { n };
            (first..2 * n).for_each(|column| table.scale(column, 1_f64.to_degrees()));
        }
        WrongUnit::LinkDegrees => table.scale(one, 1_f64.to_degrees()),
        WrongUnit::MotorTurns => {
            for (column, drive) in motors.zip(&arm.drives) {
                table.scale(column, drive.gear_ratio);
            }
        }
        WrongUnit::Gear(by) => table.scale(n + one, by),
        WrongUnit::Sign(which) => table.scale([2 * n, n, 0][which] + one, -1.0),
        WrongUnit::Swapped(which) => {
            let first = [2 * n, n, 0][which];
            table.columns.swap(first + one, first + two);
        }
        WrongUnit::Exchanged => table.columns.swap(one, n + one),
        WrongUnit::Milliseconds => table.time.iter_mut().for_each(|time| *time *= 1e3),
        WrongUnit::Foreign => {}
    }
}
