//! Compares the torque of the links with that of the nominal bodies: scale of the torques, and
//! descriptions of another robot.

use super::robot::{WholeRobot, percent};
use super::scale::{Explanation, explanations, side_of_torques};
use super::trial::{gain, root_mean_square};
use crate::finding::{Finding, Severity};
use crate::log::{Quantity, rounded};
use crate::model::Model;
use crate::prepare::{BodyScale, INACCURATE_FACTOR};

/// Largest difference from an explanation on average, and of one joint.
const SAME_ON_AVERAGE: f64 = 1.15;
const SAME_IN_A_JOINT: f64 = 2.0;

/// Factor of an explanation above which nominal values cannot be the cause.
const IMPOSSIBLE_FACTOR: f64 = 10.0;

/// Largest ratio of the scales of two joints for a common cause without explanation.
const COMMON_SPREAD: f64 = 3.0;

/// Conditions for wrong kinematics: mean logarithm by which the residual of all equations together
/// exceeds that of each alone; part of the bodies' torque that all equations together leave
/// unexplained (root mean square over the joints), for a warning and for a serious finding.
const CONTRADICTION: f64 = 0.4;
const UNEXPLAINED_BODIES: f64 = 0.35;
const MOSTLY_UNEXPLAINED_BODIES: f64 = 0.5;

/// Limit of this part if the torque of the nominal bodies has another shape as well.
const UNEXPLAINED_STRANGE_BODIES: f64 = 0.25;

/// Smallest torque of the bodies, as part of the links' torque, of the joints that are compared.
const MATTERING_BODIES: f64 = 0.2;

/// Smallest unexplained part of the links' torques: below it, the kinematics are right.
const MIN_UNEXPLAINED: f64 = 0.02;

/// Tilt of gravity that is tried, radians.
const TILT: f64 = 0.35;

impl WholeRobot<'_> {
    /// Compares the torques of the log with those of the nominal bodies. Returns findings, and the
    /// joints whose torques have the right scale or are in a finding.
    pub(super) fn torque_scales(&self) -> (Vec<Finding>, Vec<usize>) {
        let limit = INACCURATE_FACTOR.ln();
        let all = || self.scales.iter().map(|body| body.scale.ln());
        let outside = all().all(|log| log > limit) || all().all(|log| log < -limit);
        if !self.scales.is_empty() && outside {
            let every: Vec<&BodyScale> = self.scales.iter().collect();
            let finding = match self.explanation(&every) {
                Some(explanation) => self.explained_scale(&explanation),
                None => self.unexplained_scale(&all().collect::<Vec<f64>>()),
            };
            return (vec![finding], self.moving.to_vec());
        }
        let (mut findings, mut known) = (Vec::new(), Vec::new());
        for body in &self.scales {
            if body.scale.ln().abs() < limit {
                known.push(body.joint);
            } else if let Some(explanation) = self.explanation(&[body]) {
                findings.push(self.scale_of_one(body, &explanation));
                known.push(body.joint);
            }
        }
        (findings, known)
    }

    /// Returns the mistake that explains the scales of some joints best, if one agrees with them.
    fn explanation(&self, scales: &[&BodyScale]) -> Option<Explanation> {
        let joints: Vec<usize> = scales.iter().map(|body| body.joint).collect();
        (explanations(self.context, &joints).into_iter())
            .filter_map(|explanation| {
                let off: Vec<f64> = (scales.iter().zip(&explanation.factors))
                    .map(|(body, factor)| (body.scale / factor).ln())
                    .collect();
                let mean = off.iter().sum::<f64>() / off.len() as f64;
                // The factors of one torque are far apart, so inaccurate bodies do not mix them up.
                let agrees = (off.len() == 1 || mean.abs() < SAME_ON_AVERAGE.ln())
                    && off.iter().all(|off| off.abs() < SAME_IN_A_JOINT.ln());
                agrees.then_some((mean.abs(), explanation))
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, explanation)| explanation)
    }

    /// Finding: a unit or a side of the gearbox explains the scale of the torque of one joint.
    fn scale_of_one(&self, body: &BodyScale, explanation: &Explanation) -> Finding {
        let column = (self.context).column(&[Quantity::MotorTorque], body.joint);
        let line = &explanation.line;
        Finding::new(
            Severity::Warning,
            "torque-scale",
            format!(
                "{}: the torque of the log is {} times that of the nominal bodies of the links, although the \
                 torques of other joints agree. {}, which makes this factor {}",
                self.context.name(body.joint),
                rounded(body.scale),
                explanation.cause,
                rounded(explanation.factors[0])
            ),
            &format!("set {line} in [log] if unit or side of this column differ from the others"),
        )
        .seen(self.context.file, column, body.scale, "")
        .mended_by(explanation.table, line)
    }

    fn scale_words(&self) -> String {
        let words: Vec<String> = (self.scales.iter())
            .map(|body| format!("{} {}", self.context.name(body.joint), rounded(body.scale)))
            .collect();
        words.join(", ")
    }

    fn torque_column(&self) -> &str {
        let joint = self.scales.first().map_or(0, |body| body.joint);
        self.context.column(&[Quantity::MotorTorque], joint)
    }

    /// Finding: a unit or a side of the gearbox explains the scale of the torques.
    fn explained_scale(&self, explanation: &Explanation) -> Finding {
        let impossible =
            (explanation.factors.iter()).all(|factor| factor.ln().abs() > IMPOSSIBLE_FACTOR.ln());
        let severity = if impossible && self.scales.len() > 1 {
            Severity::Error
        } else {
            Severity::Serious
        };
        let factors: Vec<String> = (explanation.factors.iter())
            .map(|factor| rounded(*factor))
            .collect();
        let all_same = factors.iter().all(|factor| *factor == factors[0]);
        let expected = if all_same {
            factors[0].clone()
        } else {
            factors.join(", ")
        };
        Finding::new(
            severity,
            "torque-scale",
            format!(
                "the torques of the log are too {} for the nominal bodies of the links (torque of the log over \
                 torque of these bodies: {}). {}, which makes this factor {expected}",
                if self.scales[0].scale < 1.0 { "small" } else { "large" },
                self.scale_words(),
                explanation.cause
            ),
            &format!("set {} in {}", explanation.line, explanation.table),
        )
        .seen(self.context.file, self.torque_column(), self.scales[0].scale, "")
        .mended_by(explanation.table, &explanation.line)
    }

    /// Finding: the torques do not belong to the nominal bodies, and no unit explains this.
    fn unexplained_scale(&self, logarithms: &[f64]) -> Finding {
        let fold = |pick: fn(f64, f64) -> f64| logarithms.iter().copied().reduce(pick);
        let (least, most) = (fold(f64::min), fold(f64::max));
        let spread = most.zip(least).map_or(0.0, |(most, least)| most - least);
        let common = if spread < COMMON_SPREAD.ln() {
            "The factor is similar in all joints, so the torques have another unit, or are of the other side \
             of the gearbox, or the nominal bodies are of a lighter or heavier robot"
        } else {
            "The factor differs from joint to joint, so the nominal bodies are probably those of another \
             robot"
        };
        let source = self.source();
        let mean = (logarithms.iter().sum::<f64>() / logarithms.len() as f64).exp();
        let gear = if mean < IMPOSSIBLE_FACTOR.recip() {
            let (table, key) = side_of_torques(self.context);
            format!(
                "; if the torques are those of the motors, set {key} = \"motor\" in {table} and gear_ratio of \
                 each joint, here about {}",
                rounded_to_two(mean.recip())
            )
        } else {
            String::new()
        };
        Finding::new(
            Severity::Warning,
            "torque-scale",
            format!(
                "the torques of the log do not belong to the nominal bodies of the links in {source} (torque \
                 of the log over torque of these bodies: {}). {common}",
                self.scale_words()
            ),
            &format!(
                "check that {source} describes this robot with its masses, and the unit of the torques{gear}"
            ),
        )
        .seen(self.context.file, self.torque_column(), self.scales[0].scale, "")
    }

    /// Returns where the experiment describes the bodies.
    fn source(&self) -> String {
        match &self.context.experiment.robot.urdf {
            Some(path) => format!("\"{}\"", path.display()),
            None => "[robot]".to_owned(),
        }
    }

    /// Finding: the equations of the robot fit with no bodies, although each motor alone fits.
    pub(super) fn other_kinematics(&self) -> Option<Finding> {
        let robot = &self.context.experiment.robot;
        if robot.tree.is_none() || !(self.is_long_enough() && self.is_suspicious()) {
            return None;
        }
        let matter: Vec<usize> = (0..self.moving.len())
            .filter(|&i| self.without[i] > MATTERING_BODIES)
            .collect();
        let pick = |values: &[f64]| matter.iter().map(|&i| values[i]).collect::<Vec<f64>>();
        let (together, each) = (pick(&self.together), pick(&self.each));
        if matter.len() < 2 || root_mean_square(&together) < MIN_UNEXPLAINED {
            return None;
        }
        let of_bodies: Vec<f64> = (together.iter().zip(pick(&self.without)))
            .map(|(left, without)| left / without)
            .collect();
        let of_bodies = root_mean_square(&of_bodies);
        let contradicts = gain(&together, &each) / matter.len() as f64 > CONTRADICTION;
        let limit = if self.bodies_are_strange() {
            UNEXPLAINED_STRANGE_BODIES
        } else {
            UNEXPLAINED_BODIES
        };
        if !contradicts && of_bodies < limit {
            return None;
        }
        // A wrong direction of gravity is not another robot; the identification names it.
        let severity = if of_bodies < MOSTLY_UNEXPLAINED_BODIES || self.is_tilted() {
            Severity::Warning
        } else {
            Severity::Serious
        };
        let source = self.source();
        let bodies: Vec<f64> = matter.iter().map(|&i| self.together[i]).collect();
        let masses = if self.scales.is_empty() {
            String::new()
        } else {
            format!(
                "; torque of the log over torque of its bodies: {}",
                self.scale_words()
            )
        };
        Some(
            Finding::new(
                severity,
                "other-robot",
                format!(
                    "the links in {source} do not move like those of the log: with any masses, its equations \
                     leave {} of the links' torques unexplained, {:.0} % of the torque of the bodies; each \
                     joint alone leaves {} (root mean squares){masses}. Lengths, axes or zero positions of \
                     the joints are those of another robot, or gravity has another direction",
                    percent(&bodies),
                    100.0 * of_bodies.min(1.0),
                    percent(&each)
                ),
                &format!(
                    "name the description of this robot ({}), and check position_offset_deg of each joint and \
                     gravity_m_per_s2",
                    if robot.urdf.is_some() {
                        "urdf = \"…\" in [robot]"
                    } else {
                        "the table of [robot]"
                    }
                ),
            )
            .seen(self.context.file, "", of_bodies, ""),
        )
    }

    /// Returns whether another direction of gravity explains the torques much better.
    fn is_tilted(&self) -> bool {
        let given = self.context.experiment.robot.gravity();
        let size = given.iter().map(|g| g * g).sum::<f64>().sqrt();
        if size == 0.0 {
            return false;
        }
        let left = |gravity: [f64; 3]| {
            let mut changed = self.context.experiment.clone();
            changed.robot.gravity_m_per_s2 = Some(gravity);
            let model = Model::new(&changed).ok()?;
            self.given
                .left(&self.context.reading.with_model(model), self.moving)
        };
        (0..3)
            .flat_map(|axis| [-1.0, 1.0].map(|sign| (axis, sign)))
            .flat_map(|(axis, sign)| {
                let mut along = [0.0; 3];
                along[axis] = sign * size;
                let mut tilted = given;
                tilted[axis] += sign * size * TILT;
                let length = tilted.iter().map(|g| g * g).sum::<f64>().sqrt();
                [along, tilted.map(|g| g * size / length)]
            })
            .filter_map(left)
            .any(|left| gain(&self.given_left, &left) > CONTRADICTION * left.len() as f64)
    }
}

/// Formats a number above 1 with two significant digits.
fn rounded_to_two(value: f64) -> String {
    let unit = 10_f64.powi(value.log10().floor() as i32 - 1);
    rounded((value / unit).round() * unit)
}
