//! Findings about columns, made from the statistics of a log.

use super::channel::Extent;
use super::covariates::covariates;
use super::faults::{faults, longer_part};
use super::slope::slope_remedy;
use super::summary::Summary;
use crate::columns::channel::Channel;
use crate::columns::channels::Channels;
use crate::description::Quantity;
use crate::finding::{Finding, Severity};
use crate::mend::Mended;
use crate::numbers::Shown;

/// Code of the finding that positions seem to be in degrees.
pub const LOOKS_LIKE_DEGREES: &str = "looks-like-degrees";

/// Code of a finding about positions that are declared as degrees and seem to be in radians.
pub const LOOKS_LIKE_RADIANS: &str = "looks-like-radians";

const DEGREES_PER_RADIAN: f64 = 180.0 / std::f64::consts::PI;

/// Limits of the slope of motor position versus link position, which should be 1. The joint spring
/// changes the link's amplitude, but less than this while both move together.
const SUSPECT_SLOPE: f64 = 1.25;
const IMPOSSIBLE_SLOPE: f64 = 2.5;

/// Correlation above which two encoders count as moving together.
const MIN_CORRELATION: f64 = 0.97;

/// Largest part of the motor's motion beside the line, over the logarithm of the slope. The spring of a
/// joint that hardly moves scatters the line and bends its slope.
const MAX_SCATTER_OF_SLOPE: f64 = 0.25;

/// A joint whose range is below this number of encoder steps hardly moves.
const MIN_ENCODER_STEPS: f64 = 30.0;

/// Returns findings about the columns of a log.
///
/// - `file`: name for messages; `joints`: names of the joints.
/// - `mended`: corrected samples of each channel, \[channels\].
///
/// A column that contradicts its declaration gives a finding of [`Severity::Error`]: a position
/// that never changes although its joint moves, an encoder in degrees or on the other side of the
/// gearbox beside an encoder in radians, a counter that wraps around.
#[must_use]
pub fn check(
    file: &str,
    channels: &Channels,
    joints: &[String],
    summary: &Summary,
    mended: &[Mended],
) -> Vec<Finding> {
    let columns = ColumnCheck {
        file,
        channels,
        summary,
    };
    let mut findings = Vec::new();
    for (joint, name) in joints.iter().enumerate() {
        if let Some(finding) = columns.stands_still(name, joint) {
            findings.push(finding);
            continue;
        }
        let before = findings.len();
        for (i, channel) in channels.all.iter().enumerate() {
            if channel.joint == joint
                && !channel.quantity.is_covariate()
                && let Some(figures) = summary.figures(i)
            {
                findings.extend(faults((file, name), channel, figures, &mended[i]));
                findings.extend(columns.hardly_moves(name, channel, i));
            }
        }
        findings.extend(covariates((file, name), channels, summary, joint));
        // What else is wrong with the samples may cause a jump.
        let is_loud = |finding: &Finding| finding.severity != Severity::Info;
        if !findings[before..].iter().any(is_loud) {
            findings.extend(columns.lost_counts(name, joint));
        }
        // A counter that wraps around says nothing of units and signs.
        let is_wrong = |finding: &Finding| finding.severity == Severity::Error;
        if !findings[before..].iter().any(is_wrong) {
            let scale = columns
                .exchanged(name, joint)
                .or_else(|| columns.units_disagree(name, joint))
                .or_else(|| columns.slope_not_one(name, joint));
            findings.extend(scale);
            findings.extend(columns.looks_like_degrees(name, joint));
            findings.extend(columns.opposite_signs(name, joint));
        }
    }
    findings
}

/// A log and its statistics.
struct ColumnCheck<'a> {
    file: &'a str,
    channels: &'a Channels,
    summary: &'a Summary,
}

impl ColumnCheck<'_> {
    /// Reports a joint that never moves, or a single constant column of a joint that moves.
    fn stands_still(&self, name: &str, joint: usize) -> Option<Finding> {
        let summary = self.summary;
        let of_joint: Vec<(&Channel, Extent)> = (self.channels.all.iter().enumerate())
            .filter(|(_, channel)| channel.joint == joint)
            .filter(|(_, channel)| !channel.quantity.is_covariate())
            .filter_map(|(i, channel)| Some((channel, summary.extent(i)?)))
            .collect();
        let moves = of_joint
            .iter()
            .any(|(channel, extent)| channel.quantity.is_position() && !extent.is_constant());
        if !moves {
            return Some(
                Finding::new(
                    Severity::Serious,
                    "unexcited-joint",
                    format!(
                        "{name} stands still in all {} samples, so its parameters cannot be identified",
                        summary.samples()
                    ),
                    "record a log in which the joint moves through its working range",
                )
                .seen(self.file, "", 0.0, "rad"),
            );
        }
        // The motors of a coupled transmission may stand still while joints move.
        let (channel, extent) = of_joint.iter().find(|(_, extent)| extent.is_constant())?;
        let likely = channel.quantity.suspicion();
        let (column, file) = (&channel.column, self.file);
        let unit = channel.quantity.unit(self.channels.turns[joint]);
        Some(
            Finding::new(
                Severity::Error,
                "constant-column",
                format!(
                    "{name}: column \"{column}\" never changes ({} {unit} in all {} samples) in \
                     {file}; {likely}, or is the column name wrong?",
                    constant(extent.first),
                    summary.samples()
                ),
                "name the column that holds the quantity, or record it",
            )
            .seen(file, column, extent.first, unit),
        )
    }

    /// Returns the channel and the range of the motor encoder and of the link encoder of a joint.
    fn pair(&self, joint: usize) -> Option<[(&Channel, f64); 2]> {
        let of = |quantity| {
            let i = self.channels.index(quantity, joint)?;
            Some((&self.channels.all[i], self.summary.extent(i)?.range()))
        };
        Some([of(Quantity::MotorPosition)?, of(Quantity::LinkPosition)?])
    }

    /// Reports a position that jumps once against the other one of its joint.
    fn lost_counts(&self, name: &str, joint: usize) -> Option<Finding> {
        let jump = self.summary.deflection_jump(joint)?;
        let quantity = if jump.is_motor {
            Quantity::MotorPosition
        } else {
            Quantity::LinkPosition
        };
        let at = self.channels.index(quantity, joint)?;
        let column = &self.channels.all[at].column;
        let unit = quantity.unit(self.channels.turns[joint]);
        let finding = Finding::new(
            Severity::Warning,
            "position-jumps",
            format!(
                "{name}: \"{column}\" jumps by {:.3e} {unit} at {:.3} s against the other position of the joint, {:.0} times every other \
                 step of their difference, and then stays at the new position: counts were lost, or the sensor was reset",
                jump.size, jump.time, jump.ratio
            ),
            "use the log up to this time, or after it: the zero of the encoder is another one in each part",
        );
        let span = self.summary.figures(at)?.span();
        Some(
            (finding.seen(self.file, column, jump.size, unit))
                .at(jump.time)
                .mended_by("[log]", &longer_part(self.file, jump.time, span)),
        )
    }

    /// Returns whether only an exchange explains the ranges of the two encoders of a joint: the motor's is divided by the gear ratio
    /// although it is the link's, and the other way round.
    fn is_exchanged(&self, joint: usize) -> bool {
        let Some([(motor, motor_range), (link, link_range)]) = self.pair(joint) else {
            return false;
        };
        let Some(gear) = motor.gear_ratio.filter(|_| motor.before_gear) else {
            return false;
        };
        let ratio = link_range / motor_range;
        let is_about = |expected: f64| (ratio / expected).ln().abs() < SUSPECT_SLOPE.ln();
        gear * gear > SUSPECT_SLOPE
            && is_about(gear * gear)
            && !is_about(DEGREES_PER_RADIAN)
            && motor.is_in_radians()
            && link.is_in_radians()
    }

    fn exchanged(&self, name: &str, joint: usize) -> Option<Finding> {
        if !self.is_exchanged(joint) {
            return None;
        }
        let [(motor, motor_range), (link, link_range)] = self.pair(joint)?;
        let list = |here: Quantity, there: Quantity| {
            let mut channels: Vec<&Channel> = (self.channels.all.iter())
                .filter(|channel| {
                    let quantity = if self.is_exchanged(channel.joint) {
                        there
                    } else {
                        here
                    };
                    channel.quantity == quantity
                })
                .collect();
            channels.sort_by_key(|channel| channel.joint);
            let names = channels
                .iter()
                .map(|channel| format!("\"{}\"", channel.column));
            names.collect::<Vec<String>>().join(", ")
        };
        let lines = format!(
            "link_position_rad = [{}]\nmotor_position_rad = [{}]",
            list(Quantity::LinkPosition, Quantity::MotorPosition),
            list(Quantity::MotorPosition, Quantity::LinkPosition)
        );
        let (motor, link, gear) = (&motor.column, &link.column, motor.gear_ratio?);
        let finding = Finding::new(
            Severity::Error,
            "exchanged-columns",
            format!(
                "{name}: \"{motor}\" spans {motor_range:.2e} rad behind the gearbox and \"{link}\" {link_range:.3} rad, the square of \
                 the gear ratio {gear} apart: the columns of motor and link are exchanged"
            ),
            "exchange the two columns under link_position_rad and motor_position_rad",
        );
        Some(
            finding
                .seen(self.file, link, link_range, "rad")
                .mended_by("[log]", &lines),
        )
    }

    /// Compares the ranges of the two encoders of a joint. The spring changes the ratio, but less
    /// than the factor of about 19 that is tested here.
    fn units_disagree(&self, name: &str, joint: usize) -> Option<Finding> {
        let [(motor, motor_range), (link, link_range)] = self.pair(joint)?;
        // If a joint barely moves, an encoder may not have counted yet.
        let few = |quantity| {
            let i = self.channels.index(quantity, joint)?;
            self.span_in_steps(i)
        };
        let counted = |quantity| few(quantity).is_none_or(|steps| steps > MIN_ENCODER_STEPS);
        if !(counted(Quantity::MotorPosition) && counted(Quantity::LinkPosition)) {
            return None;
        }
        let (file, motor, link) = (self.file, &motor.column, &link.column);
        let ratio = motor_range / link_range;
        let (likely, column, setting) = if ratio > DEGREES_PER_RADIAN / 3.0 {
            let likely = format!(
                "\"{motor}\" looks like degrees (give it as motor_position_deg) or like the motor \
                 side of the gearbox (set motor_position_side = \"motor\" in [log] and gear_ratio \
                 of the joint)"
            );
            let degrees = (ratio / DEGREES_PER_RADIAN - 1.0).abs() < 0.2;
            let setting = if degrees {
                format!("motor_position_deg = [\"{motor}\"]")
            } else {
                "motor_position_side = \"motor\"".to_owned()
            };
            (likely, motor, setting)
        } else if ratio < 3.0 / DEGREES_PER_RADIAN {
            (
                format!("\"{link}\" looks like degrees; give it as link_position_deg"),
                link,
                format!("link_position_deg = [\"{link}\"]"),
            )
        } else {
            return None;
        };
        Some(
            Finding::new(
                Severity::Error,
                "units-disagree",
                format!(
                    "{name}: \"{motor}\" spans {motor_range:.3} rad and \"{link}\" {link_range:.3} \
                     rad in {file}, although the two should span about the same; {likely}"
                ),
                "give the unit and the side of each column",
            )
            .seen(file, column, ratio, "")
            .mended_by("[log]", &setting),
        )
    }

    /// Compares the slope of motor position versus link position with 1.
    fn slope_not_one(&self, name: &str, joint: usize) -> Option<Finding> {
        let [(motor, _), (link, _)] = self.pair(joint)?;
        let line = self.summary.line(joint)?;
        let slope = line.slope.abs();
        let far = slope.max(1.0 / slope);
        let scatter = (1.0 - line.correlation.powi(2)).max(0.0).sqrt();
        if line.correlation.abs() < MIN_CORRELATION
            || far < SUSPECT_SLOPE
            || scatter > MAX_SCATTER_OF_SLOPE * far.ln()
        {
            return None;
        }
        let remedy = slope_remedy(motor, link, slope);
        let (motor, link) = (&motor.column, &link.column);
        let finding = Finding::new(
            if far > IMPOSSIBLE_SLOPE {
                Severity::Error
            } else {
                Severity::Warning
            },
            "slope-not-one",
            format!(
                "{name}: \"{motor}\" moves {slope:.4} rad for each rad of \"{link}\" (correlation \
                 {:.3}), although both should be on the output side: a gear ratio, a number of \
                 counts per turn or a unit is wrong",
                line.correlation
            ),
            &remedy.words,
        )
        .seen(self.file, motor, line.slope, "rad/rad");
        Some(finding.mended_by(remedy.table, &remedy.line))
    }

    fn opposite_signs(&self, name: &str, joint: usize) -> Option<Finding> {
        let [(motor, _), (link, _)] = self.pair(joint)?;
        let (motor, link) = (&motor.column, &link.column);
        let correlation = self.summary.correlation(joint)?;
        (correlation < -0.5).then(|| {
            Finding::new(
                Severity::Warning,
                "opposite-signs",
                format!(
                    "{name}: \"{motor}\" and \"{link}\" move against each other (correlation \
                     {correlation:.2}): unless the joint was driven above its resonance, one of \
                     them counts the other way"
                ),
                &format!(
                    "set sign = {{ \"{link}\" = -1 }} or sign = {{ \"{motor}\" = -1 }} in [log]"
                ),
            )
            .seen(self.file, link, correlation, "")
            .mended_by("[log]", &format!("sign = {{ \"{link}\" = -1 }}"))
        })
    }

    fn looks_like_degrees(&self, name: &str, joint: usize) -> Option<Finding> {
        let channels = self.channels;
        let motor = channels.index(Quantity::MotorPosition, joint)?;
        let range = self.summary.extent(motor)?.range();
        // Motors before a coupled transmission may turn many times.
        let known = channels.turns[joint]
            && channels.position_mix.is_none()
            && channels.all[motor].is_in_radians();
        (known && range > std::f64::consts::TAU).then(|| {
            let column = &channels.all[motor].column;
            Finding::new(
                // Many joints turn more than once; only the equations of the robot decide.
                Severity::Info,
                LOOKS_LIKE_DEGREES,
                format!(
                    "{name}: \"{column}\" spans {range:.1} rad, more than a full turn; are these \
                     degrees? ({range:.1}° would be {:.3} rad; stiffness and inertia would come out \
                     57.3 times too small)",
                    range / DEGREES_PER_RADIAN
                ),
                "if the columns hold degrees, name them under motor_position_deg and \
                 link_position_deg",
            )
            .seen(self.file, column, range, "rad")
        })
    }

    /// Returns the range of a channel in units of its smallest steps.
    fn span_in_steps(&self, i: usize) -> Option<f64> {
        let figures = self.summary.figures(i)?;
        let step = figures.steps().quantile(0.001);
        (step > 0.0).then(|| figures.extent().range() / step)
    }

    /// Reports a joint whose encoder counts so few steps that its velocity is mostly quantisation
    /// noise.
    fn hardly_moves(&self, name: &str, channel: &Channel, i: usize) -> Option<Finding> {
        if !matches!(
            channel.quantity,
            Quantity::LinkPosition | Quantity::MotorPosition
        ) {
            return None;
        }
        let range = self.summary.extent(i)?.range();
        let steps = self.span_in_steps(i)?;
        (steps < MIN_ENCODER_STEPS).then(|| {
            let unit = channel.quantity.unit(self.channels.turns[channel.joint]);
            Finding::new(
                Severity::Warning,
                "hardly-moves",
                format!(
                    "{name}: \"{}\" spans {range:.2e} {unit}, about {steps:.0} of its smallest steps: its \
                     velocity is mostly the encoder's noise",
                    channel.column
                ),
                "record a log in which the joint moves through its working range",
            )
            .seen(self.file, &channel.column, range, unit)
        })
    }
}

/// Returns the value of a constant column.
fn constant(value: f64) -> String {
    if value.abs() < 1e9 {
        format!("{value:.4}")
    } else {
        Shown(value).to_string()
    }
}
