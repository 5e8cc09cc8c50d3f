//! Tests whether motor positions that are declared as after the gearbox are before it.

use super::resolution::UNEXPLAINED;
use super::robot::{WholeRobot, percent};
use super::scale::USUAL_RATIOS;
use super::trial::{gain, is_certain, root_mean_square};
use crate::description::Quantity;
use crate::finding::{Finding, Severity};
use crate::log::rounded;

/// Joints whose positions are before the gearbox by the equations of the robot.
pub(super) struct Geared {
    joints: Vec<usize>,
    ratios: Vec<f64>,
    /// Whether the file gives the ratios.
    is_given: bool,
    /// Unexplained parts of the links' torques with these ratios.
    pub(super) left: Vec<f64>,
}

impl WholeRobot<'_> {
    /// Finds positions before the gearbox that are declared as after it, of joints without link encoder. The ratios are
    /// those of the file, or a usual one for all joints.
    pub(super) fn geared(&self) -> Option<Geared> {
        let context = self.context;
        let channels = context.reading.channels();
        let joints: Vec<usize> = (self.moving.iter().copied())
            .filter(|&joint| context.is_said_in_radians(joint))
            .filter(|&joint| {
                let motor = channels.index(Quantity::MotorPosition, joint);
                channels.index(Quantity::LinkPosition, joint).is_none()
                    && motor.is_some_and(|motor| !channels.all[motor].before_gear)
            })
            .collect();
        let ratio = |joint: usize| context.experiment.robot.joint.get(joint)?.gear_ratio;
        let given: Option<Vec<f64>> = joints.iter().map(|&joint| ratio(joint)).collect();
        let is_given = given.is_some();
        let tried = given.map_or_else(
            || USUAL_RATIOS.map(|ratio| vec![ratio; joints.len()]).to_vec(),
            |given| vec![given],
        );
        (tried.into_iter())
            .filter(|_| !joints.is_empty())
            .filter_map(|ratios| {
                let pairs = joints.iter().zip(&ratios);
                let trial = pairs.fold(self.given.clone(), |trial, (&joint, ratio)| {
                    trial.with_positions(joint, ratio.recip())
                });
                let left = self.left(&trial)?;
                let is_sound = root_mean_square(&left) < UNEXPLAINED;
                (is_sound && is_certain(&self.given_left, &left)).then(|| Geared {
                    joints: joints.clone(),
                    ratios,
                    is_given,
                    left,
                })
            })
            .max_by(|a, b| {
                let gain = |geared: &Geared| gain(&self.given_left, &geared.left);
                gain(a).total_cmp(&gain(b))
            })
    }

    /// Finding: the equations of the robot fit if the positions are before the gearbox.
    pub(super) fn by_gears(&self, geared: &Geared, is_equal: bool) -> Finding {
        let line = "motor_position_side = \"motor\"";
        let (table, line) = if geared.is_given {
            ("[log]", line.to_owned())
        } else {
            let ratio = geared.ratios.first().copied().unwrap_or(1.0);
            (
                "[[robot.joint]]",
                format!("gear_ratio = {}\n[log] {line}", rounded(ratio)),
            )
        };
        let or = if is_equal {
            "; degrees explain the log equally well"
        } else {
            ""
        };
        let first = geared.joints.first().copied().unwrap_or_default();
        Finding::new(
            Severity::Error,
            "motor-side-positions",
            format!(
                "{}: the positions are those of the motors before the gearbox. If sprung divides them by the \
                 gear ratio, the equations of the robot leave {} of the links' torques unexplained instead of \
                 {} (root mean squares); {}{or}",
                self.names(&geared.joints),
                percent(&geared.left),
                percent(&self.given_left),
                self.context.widest(&geared.joints)
            ),
            &format!("set {line} in {table}"),
        )
        .seen(
            self.context.file,
            self.context.position_column(first),
            self.context.range(first),
            "rad",
        )
        .mended_by(table, &line)
    }
}
