//! Tests whether positions that are declared as radians are degrees, or the reverse.

use sprung_core::friction::Law;
use sprung_core::parameters::JointParameter;

use super::context::CheckContext;
use super::robot::{AboutRobot, WholeRobot, percent};
use super::trial::{gain, is_certain};
use crate::description::Quantity;
use crate::finding::{Finding, Severity};
use crate::log::{LOOKS_LIKE_DEGREES, LOOKS_LIKE_RADIANS, Signal};
use crate::prepare::RowFit;

/// Gains (sums of logarithms): minimum for a further joint in degrees, and limit at which the declared unit is certain.
const FURTHER_GAIN: f64 = 1.0;
const CERTAIN_LOSS: f64 = -0.3;

/// Difference of gains below which degrees and a missing gear ratio explain a log equally well.
const SAME_GAIN: f64 = 0.25;

/// Largest factor between the nominal values and those of the log in the right unit.
const NOMINAL_FACTOR: f64 = 6.0;

/// Fastest plausible speed of a joint, rad/s, and the time over which speeds are measured, s.
const FASTEST_JOINT: f64 = 50.0;
const SPEED_INTERVAL: f64 = 0.02;

/// Smallest range of positions in radians for which degrees are considered, rad.
const MIN_RANGE: f64 = std::f64::consts::TAU;

/// Largest range of positions in degrees, in turns, for which radians are considered.
const MAX_RANGE_OF_DEGREES: f64 = 3.0;

/// Degrees per radian.
const DEGREES: f64 = 180.0 / std::f64::consts::PI;

impl WholeRobot<'_> {
    /// Tests the units of the positions.
    pub(super) fn degrees(&self, fits: &[RowFit]) -> AboutRobot {
        let wide: Vec<usize> = (self.moving.iter().copied())
            .filter(|&joint| self.context.is_said_in_radians(joint))
            .filter(|&joint| self.context.range(joint) > MIN_RANGE)
            .collect();
        let mut about = AboutRobot::default();
        if let Some(finding) = self.radians_as_degrees() {
            about.findings.push(finding);
            about.explains_all = true;
            return about;
        }
        if wide.is_empty() {
            return about;
        }
        let certain = self.certain_degrees(&wide);
        let degrees = if certain.joints.is_empty() {
            f64::NEG_INFINITY
        } else {
            gain(&self.given_left, &certain.left)
        };
        let geared = self.geared();
        let of_gears = (geared.as_ref()).map_or(f64::NEG_INFINITY, |geared| {
            gain(&self.given_left, &geared.left)
        });
        let is_equal = (of_gears - degrees).abs() < SAME_GAIN;
        let by_equations = match geared {
            Some(geared) if of_gears > degrees => Some(self.by_gears(&geared, is_equal)),
            _ if degrees.is_finite() => Some(self.by_equations(&certain, is_equal)),
            _ => None,
        };
        if let Some(finding) = by_equations {
            about.findings.push(finding);
            about.explains_all = true;
            return about;
        }
        let mut by_nominal = Vec::new();
        for (&joint, gain) in wide.iter().zip(&certain.single) {
            let is_radians = certain.all < CERTAIN_LOSS || *gain < CERTAIN_LOSS;
            if is_radians {
                continue;
            }
            match self.over_nominal(joint, &fits[joint]) {
                Some(ratio) if is_near(ratio) => {}
                Some(ratio) if is_near(ratio * DEGREES) => by_nominal.push((joint, ratio)),
                _ => about.findings.push(self.by_speed(joint)),
            }
        }
        if !by_nominal.is_empty() {
            about.findings.push(self.by_nominal_values(&by_nominal));
            about.explains_all = true;
        }
        about
    }

    /// Finds the joints whose positions are degrees by the equations of the robot.
    fn certain_degrees(&self, wide: &[usize]) -> CertainDegrees {
        let context = self.context;
        let revolute: Vec<usize> = (self.moving.iter().copied())
            .filter(|&joint| context.is_said_in_radians(joint))
            .collect();
        let left_of = |joints: &[usize]| {
            let trial = joints.iter().fold(self.given.clone(), |trial, &joint| {
                trial.with_positions(joint, DEGREES.recip())
            });
            self.left(&trial)
        };
        let gain_of = |left: &Option<Vec<f64>>| {
            (left.as_ref()).map_or(f64::NEG_INFINITY, |left| gain(&self.given_left, left))
        };
        let all = left_of(&revolute);
        let mut found = CertainDegrees {
            joints: Vec::new(),
            all: gain_of(&all),
            single: Vec::new(),
            left: Vec::new(),
        };
        let mut best = (found.all, revolute.clone(), all);
        // Joints that are added one by one, by decreasing gain.
        let mut chosen: Vec<usize> = Vec::new();
        let mut before = 0.0;
        loop {
            let mut next: Option<(f64, usize, Option<Vec<f64>>)> = None;
            for &joint in wide.iter().filter(|joint| !chosen.contains(*joint)) {
                let left = left_of(&[&chosen[..], &[joint]].concat());
                let gain = gain_of(&left);
                if chosen.is_empty() {
                    found.single.push(gain);
                }
                if next.as_ref().is_none_or(|(most, ..)| gain > *most) {
                    next = Some((gain, joint, left));
                }
            }
            let Some((gain, joint, left)) = next else {
                break;
            };
            if gain < before + FURTHER_GAIN {
                break;
            }
            chosen.push(joint);
            before = gain;
            if gain > best.0 + FURTHER_GAIN || chosen.len() == revolute.len() {
                best = (gain, chosen.clone(), left);
            }
        }
        if let (_, joints, Some(left)) = best
            && is_certain(&self.given_left, &left)
        {
            found.joints = joints;
            found.joints.sort_unstable();
            found.left = left;
        }
        found
    }

    /// Finding: the equations of the robot fit if the positions are degrees.
    fn by_equations(&self, certain: &CertainDegrees, is_equal: bool) -> Finding {
        let or = if is_equal {
            "; a motor position before the gearbox explains the log equally well"
        } else {
            ""
        };
        let text = format!(
            "{}: the positions are degrees, not radians. If sprung reads them as degrees, the equations of \
             the robot leave {} of the links' torques unexplained instead of {} (root mean squares); {}{or}",
            self.names(&certain.joints),
            percent(&certain.left),
            percent(&self.given_left),
            self.context.widest(&certain.joints)
        );
        self.context
            .degrees_finding(Severity::Error, text, &certain.joints)
    }

    /// Finding: the parameters are too small by the factor of degrees.
    fn by_nominal_values(&self, found: &[(usize, f64)]) -> Finding {
        let joints: Vec<usize> = found.iter().map(|(joint, _)| *joint).collect();
        let ratios: Vec<String> = (found.iter())
            .map(|(_, ratio)| format!("{:.0}", ratio.recip()))
            .collect();
        let gears: Vec<f64> = (joints.iter())
            .filter_map(|&joint| self.context.experiment.robot.joint[joint].gear_ratio)
            .filter(|ratio| is_near(ratio.abs() / DEGREES))
            .collect();
        // A torque on the other side of such a gearbox has the same effect.
        let (severity, or) = if gears.is_empty() {
            (Severity::Error, String::new())
        } else {
            (
                Severity::Serious,
                format!(
                    "; positions or torques that were recorded before the gearbox (gear_ratio = {}) look the \
                     same (motor_position_side or motor_torque_side = \"motor\" in [log])",
                    gears[0]
                ),
            )
        };
        let text = format!(
            "{}: the positions look like degrees: stiffness, inertia and viscous friction are {} times \
             smaller than their nominal values (57.3 is expected for degrees); {}{or}",
            self.names(&joints),
            ratios.join(", "),
            self.context.widest(&joints)
        );
        let mut finding = self.context.degrees_finding(severity, text, &joints);
        // Two causes are possible, so no line is suggested.
        if !gears.is_empty() {
            finding.setting = None;
        }
        finding
    }

    /// Finding: only range and speed show the unit.
    fn by_speed(&self, joint: usize) -> Finding {
        let (range, speed) = (self.context.range(joint), self.context.speed(joint));
        let severity = if speed > FASTEST_JOINT {
            Severity::Warning
        } else {
            Severity::Info
        };
        let text = format!(
            "{}: the position spans {range:.1} rad ({:.1} turns) at up to {speed:.0} rad/s; are these \
             degrees, or the angle of a motor before its gearbox? Neither the equations of the robot nor nominal values \
             tell the unit of this joint. With degrees as radians, stiffness and inertia would be 57.3 times too small",
            self.context.name(joint),
            range / std::f64::consts::TAU
        );
        // Range and speed do not prove a line.
        let finding = self.context.degrees_finding(severity, text, &[joint]);
        Finding {
            remedy: format!(
                "{}; before the gearbox, give gear_ratio of the joint and motor_position_side = \"motor\"",
                finding.remedy
            ),
            setting: None,
            ..finding
        }
    }

    /// Finding: positions that are declared as degrees are radians.
    fn radians_as_degrees(&self) -> Option<Finding> {
        let context = self.context;
        let joints: Vec<usize> = (self.moving.iter().copied())
            .filter(|&joint| context.is_said_in_degrees(joint))
            .collect();
        let limit = std::f64::consts::TAU * MAX_RANGE_OF_DEGREES / DEGREES;
        if joints.is_empty() || joints.iter().any(|&joint| context.range(joint) > limit) {
            return None;
        }
        let trial = joints.iter().fold(self.given.clone(), |trial, &joint| {
            trial.with_positions(joint, DEGREES)
        });
        let left = self.left(&trial)?;
        if !is_certain(&self.given_left, &left) {
            return None;
        }
        let lines = context.unit_lines(&joints, "rad");
        Some(
            Finding::new(
                Severity::Error,
                LOOKS_LIKE_RADIANS,
                format!(
                    "{}: the positions are radians, not degrees. If sprung reads them as radians, the \
                     equations of the robot leave {} of the links' torques unexplained instead of {} (root \
                     mean squares)",
                    self.names(&joints),
                    percent(&left),
                    percent(&self.given_left)
                ),
                &format!("set {} in [log]", lines.replace('\n', " and ")),
            )
            .seen(
                context.file,
                context.position_column(joints[0]),
                context.range(joints[0]),
                "rad",
            )
            .mended_by("[log]", &lines),
        )
    }

    /// Returns the geometric mean of the values of a joint over their nominal values, of the
    /// parameters that degrees change; `None` without nominal values.
    pub(super) fn over_nominal(&self, joint: usize, fit: &RowFit) -> Option<f64> {
        let model = self.context.reading.model();
        let of_joint = fit.values().filter_map(|(column, value)| {
            let parameter = &model.parameters()[column];
            let changes = match parameter.joint {
                Some((kind, _)) => is_per_angle(kind),
                None => self.moving.len() == 1,
            };
            Some(value / parameter.nominal?).filter(|_| changes)
        });
        let of_bodies = (self.scales.iter())
            .filter(|body| body.joint == joint)
            .map(|body| body.scale);
        let logarithms: Vec<f64> = (of_joint.chain(of_bodies))
            .filter(|ratio| ratio.is_finite() && *ratio > 0.0)
            .map(f64::ln)
            .collect();
        let sum: f64 = logarithms.iter().sum();
        (!logarithms.is_empty()).then(|| (sum / logarithms.len() as f64).exp())
    }
}

/// Joints whose positions are degrees by the equations of the robot.
struct CertainDegrees {
    /// The joints; empty if the equations do not determine it.
    joints: Vec<usize>,
    /// Gain if all joints are read as degrees.
    all: f64,
    /// Gain if one joint is read as degrees.
    single: Vec<f64>,
    /// Unexplained parts of the links' torques with degrees.
    left: Vec<f64>,
}

/// Returns whether a ratio is near one.
fn is_near(ratio: f64) -> bool {
    ratio.ln().abs() < NOMINAL_FACTOR.ln()
}

/// Returns whether a parameter is a torque per angle or its derivatives.
fn is_per_angle(kind: JointParameter) -> bool {
    match kind {
        JointParameter::RotorInertia | JointParameter::Stiffness => true,
        JointParameter::Friction(_, law) => law == Law::Viscous,
        JointParameter::CubicStiffness
        | JointParameter::Damping
        | JointParameter::Hysteresis(_)
        | JointParameter::Preload
        | JointParameter::Change(..)
        | JointParameter::BackEmf
        | JointParameter::TorqueOffset => false,
    }
}

impl CheckContext<'_> {
    /// Returns the channels with absolute positions of a joint.
    fn positions(&self, joint: usize) -> impl Iterator<Item = usize> + '_ {
        [Quantity::MotorPosition, Quantity::LinkPosition]
            .into_iter()
            .filter_map(move |quantity| self.reading.channels().index(quantity, joint))
    }

    pub(super) fn is_said_in_radians(&self, joint: usize) -> bool {
        let channels = self.reading.channels();
        channels.turns[joint]
            && (self.positions(joint)).all(|channel| channels.all[channel].is_in_radians())
    }

    fn is_said_in_degrees(&self, joint: usize) -> bool {
        let channels = self.reading.channels();
        channels.turns[joint]
            && (self.positions(joint)).all(|channel| channels.all[channel].is_in_degrees())
    }

    pub(super) fn position_column(&self, joint: usize) -> &str {
        let channel = self.reading.channels().telling(Signal::Motor, joint);
        channel.map_or("", |channel| &self.reading.channels().all[channel].column)
    }

    /// Returns the largest range of the positions of a joint, rad; zero for motors before a coupled
    /// transmission, which may turn many times.
    pub(super) fn range(&self, joint: usize) -> f64 {
        let channels = self.reading.channels();
        let coupled = channels.position_mix.is_some();
        (self.positions(joint))
            .filter(|&channel| !coupled || channels.all[channel].quantity == Quantity::LinkPosition)
            .map(|channel| {
                let values = || self.excerpt.channel(channel);
                values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
            })
            .fold(0.0, f64::max)
    }

    /// Returns the largest mean speed of a joint over a short interval, rad/s.
    fn speed(&self, joint: usize) -> f64 {
        let Some(channel) = self.reading.channels().telling(Signal::Motor, joint) else {
            return 0.0;
        };
        let period = self.excerpt.period();
        let steps = (SPEED_INTERVAL / period).ceil().max(1.0);
        (self.excerpt.blocks().iter())
            .flat_map(|block| {
                let values = &block.values[channel];
                let later = values.iter().skip(steps as usize);
                later.zip(values).map(|(b, a)| (b - a).abs())
            })
            .fold(0.0, f64::max)
            / (steps * period)
    }

    /// Returns the widest range of joints in words.
    pub(super) fn widest(&self, joints: &[usize]) -> String {
        let widest = (joints.iter().copied())
            .max_by(|&a, &b| self.range(a).total_cmp(&self.range(b)))
            .unwrap_or_default();
        let range = self.range(widest);
        format!(
            "\"{}\" spans {range:.1}, which would be {:.1} turns in radians",
            self.position_column(widest),
            range / std::f64::consts::TAU
        )
    }

    fn degrees_finding(&self, severity: Severity, text: String, joints: &[usize]) -> Finding {
        let lines = self.unit_lines(joints, "deg");
        let column = joints
            .first()
            .map_or("", |&joint| self.position_column(joint));
        let range = joints.first().map_or(0.0, |&joint| self.range(joint));
        Finding::new(
            severity,
            LOOKS_LIKE_DEGREES,
            text,
            &format!(
                "if the columns hold degrees, set {} in [log] instead of the present keys",
                lines.replace('\n', " and ")
            ),
        )
        .seen(self.file, column, range, "rad")
        .mended_by("[log]", &lines)
    }
}
