//! Findings about other meanings of the columns of a joint: link and motor exchanged, columns of two
//! joints swapped, signs reversed, another scale.

use sprung_core::parameters::JointParameter;

use super::context::{CheckContext, SIGNIFICANT_SIGMAS};
use super::rivals::{BETTER_RESIDUAL_SHARE, Meaning, Winner};
use super::scale::USUAL_RATIOS;
use super::trial::Group;
use crate::finding::{Finding, Severity};
use crate::log::{Quantity, Signal, rounded, slope_remedy};
use crate::numbers::with_error;
use crate::prepare::{Excerpt, MotorRowFit, OfRow, RowFit, fit_rows};
use crate::regression::Reading;
use crate::unknowns::{Found, Kind, Place, settle};

/// Scales of a motor position in the scan about the ratio of standard deviations: number on each side,
/// and ratio of neighbours, of a coarse and of a fine scan.
const COARSE_SCAN: (i32, f64) = (12, 1.1);
const FINE_SCAN: (i32, f64) = (4, 1.02);

/// Smallest scale error that is reported.
const MIN_SCALE: f64 = 1.25;

/// Degrees per radian.
const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// A usual ratio is taken if it differs from the best one by less than this fraction, and its residual
/// is at most this many times that of the best.
const NEAR_RATIO: f64 = 0.06;
const NEAR_RESIDUAL: f64 = 1.1;

/// Ratio above which two encoders of a joint have different units.
const OTHER_UNIT: f64 = DEGREES / 3.0;

impl CheckContext<'_> {
    /// Returns the fits with which the trials of other meanings are compared: those of few samples, as in the trials,
    /// or the given ones without trials.
    pub(super) fn compared(&self, fits: &[RowFit], weak: &[usize]) -> Vec<RowFit> {
        let all: Vec<usize> = (0..fits.len()).collect();
        let few = (!weak.is_empty()).then(|| fit_rows(&self.few, self.reading, &all));
        few.flatten().unwrap_or_else(|| fits.to_vec())
    }

    /// Finding: another meaning of the columns explains the torque.
    ///
    /// - `before`: fits with the columns as described.
    pub(super) fn other_meaning(&self, won: &Winner, before: &[RowFit]) -> Option<Finding> {
        let joint = *won.best.joints.first()?;
        let fit = won.best.fits.first()?;
        let mut finding = match won.best.meaning {
            Meaning::Exchanged if !self.is_exchanged(joint) => return None,
            Meaning::Exchanged => self.exchange(joint, fit),
            Meaning::LinkSign => self.opposite(joint, self.link(joint), fit, &before[joint]),
            Meaning::MotorSign => {
                let motor = self.column(&[Quantity::MotorPosition], joint);
                self.opposite(joint, motor, fit, &before[joint])
            }
            Meaning::MotorScale(ratio) => self.other_scale(joint, ratio, fit, &before[joint])?,
            Meaning::Swapped(quantity) => {
                let two = *won.best.joints.get(1)?;
                self.swap(quantity, [joint, two], before, &won.best.fits)?
            }
        };
        if !won.equal.is_empty() {
            let others: Vec<String> = (won.equal.iter())
                .map(|&meaning| self.words(meaning, joint))
                .collect();
            finding.text = format!(
                "{}. The motor row is explained equally well by {}",
                finding.text,
                others.join(", or by ")
            );
        }
        Some(finding)
    }

    /// Returns another meaning of the columns of a joint in words.
    fn words(&self, meaning: Meaning, joint: usize) -> String {
        let motor = self.column(&[Quantity::MotorPosition], joint);
        match meaning {
            Meaning::Exchanged => "exchanged link and motor position".to_owned(),
            Meaning::LinkSign => format!("sign = {{ \"{}\" = -1 }}", self.link(joint)),
            Meaning::MotorSign => format!("sign = {{ \"{motor}\" = -1 }}"),
            Meaning::MotorScale(ratio) => {
                format!("\"{motor}\" divided by {}", rounded(ratio))
            }
            Meaning::Swapped(quantity) => format!("the other order of {}", group(quantity).words()),
        }
    }

    /// Returns whether link and motor position of a joint are exchanged although sizes of unknowns may explain its torque.
    /// An exchange only turns the deflection around, as a gain of a position does.
    fn is_exchanged(&self, joint: usize) -> bool {
        let left = |reading: &Reading| {
            settle(self.experiment, reading, self.excerpt).map(|settled| settled.unexplained)
        };
        let exchanged = self.reading.channels().exchanged(joint);
        let now = exchanged.and_then(|now| left(&self.reading.with_channels(now)));
        let (Some(now), Some(before)) = (now, left(self.reading)) else {
            return true;
        };
        now < BETTER_RESIDUAL_SHARE * before
    }

    fn exchange(&self, joint: usize, fit: &MotorRowFit) -> Finding {
        let (link, motor) = (
            self.link(joint),
            self.column(&[Quantity::MotorPosition], joint),
        );
        let lines = (self.reading.channels().exchanged(joint))
            .map_or_else(String::new, |now| self.column_lines(&now));
        Finding::new(
            Severity::Error,
            "exchanged-columns",
            format!(
                "{}: with link and motor position exchanged the motor row explains {:.0} % of the torque and \
                 every parameter is positive (stiffness {:.4} N·m/rad): the columns look swapped",
                self.name(joint),
                100.0 * (1.0 - fit.relative_residual.powi(2)),
                fit.stiffness.unwrap_or_default()
            ),
            &format!(
                "exchange \"{link}\" and \"{motor}\" under link_position_rad and motor_position_rad"
            ),
        )
        .about(self.about_stiffness(joint))
        .seen(self.file, link, fit.relative_residual, "")
        .mended_by("[log]", &lines)
    }

    /// - `after`: fits of both joints with the columns swapped.
    fn swap(
        &self,
        quantity: Quantity,
        [one, two]: [usize; 2],
        before: &[RowFit],
        after: &[MotorRowFit],
    ) -> Option<Finding> {
        let swapped = self.reading.channels().swapped(quantity, one, two)?;
        let percent = |residual: f64| 100.0 * (1.0 - residual.powi(2)).max(0.0);
        let [first, second] = after else {
            return None;
        };
        let finding = Finding::new(
            Severity::Error,
            "swapped-joints",
            format!(
                "{} of {} and {} are swapped: with them exchanged, the motor rows explain {:.0} % and {:.0} % of \
                 their torque instead of {:.0} % and {:.0} %, and every parameter is positive",
                group(quantity).words(),
                self.name(one),
                self.name(two),
                percent(first.relative_residual),
                percent(second.relative_residual),
                percent(before[one].relative_residual()),
                percent(before[two].relative_residual()),
            ),
            "give the columns in the order of the [[robot.joint]] blocks",
        );
        Some(
            finding
                .seen(
                    self.file,
                    self.column(&[quantity], one),
                    first.relative_residual,
                    "",
                )
                .mended_by("[log]", &self.column_lines(&swapped)),
        )
    }

    /// Finding: the torque brakes where it should drive.
    pub(super) fn reversed(&self, joint: usize, fit: &RowFit) -> Option<Finding> {
        let all = fit.of_joints(self.reading.model(), self.independent);
        let signed: Vec<OfRow> = (all.into_iter())
            .filter(|of| of.kind.is_friction() || of.kind == JointParameter::Stiffness)
            .collect();
        let negative = |of: &OfRow| of.value < -2.0 * of.error;
        let any_clear = (signed.iter()).any(|of| of.value < -SIGNIFICANT_SIGMAS * of.error);
        if signed.len() < 2 || !signed.iter().all(negative) || !any_clear {
            return None;
        }
        let torque = self.column(&[Quantity::MotorTorque], joint);
        Some(reversed_torque(self.name(joint), torque).seen(self.file, torque, signed[0].value, ""))
    }

    /// Finding: by the equations, link and motor position have opposite directions.
    ///
    /// - `wrong`: the reversed column.
    fn opposite(&self, joint: usize, wrong: &str, now: &MotorRowFit, before: &RowFit) -> Finding {
        let motor = self.column(&[Quantity::MotorPosition], joint);
        let line = format!("sign = {{ \"{wrong}\" = -1 }}");
        Finding::new(
            Severity::Error,
            "opposite-signs",
            format!(
                "{}: \"{motor}\" and \"{}\" have opposite directions: with the sign of \"{wrong}\" reversed \
                 the motor row leaves {:.1} % of the torque unexplained instead of {:.1} %, and every parameter \
                 is positive",
                self.name(joint),
                self.link(joint),
                100.0 * now.relative_residual,
                100.0 * before.relative_residual()
            ),
            &format!("set {line} in [log]"),
        )
        .seen(self.file, wrong, now.relative_residual, "")
        .mended_by("[log]", &line)
    }

    /// Finding: a position has the wrong sign and is late, and sizes of unknowns alone explain the torques worse.
    pub(super) fn opposite_and_late(&self, joint: usize) -> Option<Finding> {
        let channels = self.reading.channels();
        let of = |signal: Signal| channels.telling(signal, joint);
        let (link, motor, torque) = (of(Signal::Link)?, of(Signal::Motor)?, of(Signal::Torque)?);
        if [link, motor, torque].map(|i| channels.all[i].delay) != [None; 3] {
            return None;
        }
        let settled = |excerpt: &Excerpt| settle(self.experiment, self.reading, excerpt);
        let before = settled(self.excerpt)?.unexplained;
        let turned = [link, motor].into_iter().filter_map(|channel| {
            let settled = settled(&self.excerpt.scaled(channel, -1.0))?;
            let is_late =
                |one: &Found| one.kind == Kind::Delay && one.place == Place::Channel(channel);
            let delay = settled.found.into_iter().find(is_late)?;
            (settled.unexplained < BETTER_RESIDUAL_SHARE * before).then_some((
                channel,
                delay,
                settled.unexplained,
            ))
        });
        let (channel, delay, left) = turned.min_by(|a, b| a.2.total_cmp(&b.2))?;
        let column = &channels.all[channel].column;
        let lines =
            format!("sign = {{ \"{column}\" = -1 }}\ndelay_s = {{ \"{column}\" = \"estimate\" }}");
        let [late, error] = with_error(delay.value, delay.standard_error);
        let text = format!(
            "{}: \"{column}\" has the wrong direction and was recorded {late} s late (standard error {error} s): with both the \
             equations leave {:.1} % of the torques unexplained instead of {:.1} %, and no parameter is negative",
            self.name(joint),
            100.0 * left,
            100.0 * before
        );
        let remedy = format!("set in [log] {}", lines.replace('\n', " and "));
        let finding = Finding::new(Severity::Error, "opposite-signs", text, &remedy);
        Some((finding.seen(self.file, column, left, "")).mended_by("[log]", &lines))
    }

    /// Returns the ratio by which the motor position of a joint is too large by the motor row, with the fit on the
    /// link's scale; `None` if its scale is right or no scale explains the torque.
    pub(super) fn motor_scale(&self, joint: usize, fit: &RowFit) -> Option<(f64, MotorRowFit)> {
        let channels = self.reading.channels();
        let motor = channels.index(Quantity::MotorPosition, joint)?;
        let link = channels.index(Quantity::LinkPosition, joint)?;
        let about = self.excerpt.deviation(motor) / self.excerpt.deviation(link);
        if !(about.is_finite() && about > 0.0) {
            return None;
        }
        let fitted = |ratio: f64| {
            let now = self.scaled(&[Quantity::MotorPosition], joint, ratio.recip())?;
            now.plausible.then_some((ratio, now))
        };
        let least = |a: &(f64, MotorRowFit), b: &(f64, MotorRowFit)| {
            a.1.relative_residual.total_cmp(&b.1.relative_residual)
        };
        let channel = &channels.all[motor];
        let given = channel.gear_ratio.map(f64::abs);
        // Readings before the gearbox are already divided by the given ratio.
        let divided = if channel.before_gear {
            given.unwrap_or(1.0)
        } else {
            1.0
        };
        let coarse = scan(about, COARSE_SCAN).filter_map(fitted).min_by(least)?;
        let fine = scan(coarse.0, FINE_SCAN).filter_map(fitted).min_by(least)?;
        let (ratio, now) = (given.into_iter().chain(USUAL_RATIOS).chain([DEGREES]))
            .map(|usual| usual / divided)
            .filter(|usual| (usual / fine.0).ln().abs() < NEAR_RATIO)
            .filter_map(fitted)
            .min_by(least)
            .filter(|(_, now)| now.relative_residual < NEAR_RESIDUAL * fine.1.relative_residual)
            .unwrap_or(fine);
        let is_better = now.relative_residual < BETTER_RESIDUAL_SHARE * fit.relative_residual();
        (is_better && ratio.ln().abs() > MIN_SCALE.ln()).then_some((ratio, now))
    }

    /// Finding: by the equations, the motor position has another scale than the link position.
    pub(super) fn other_scale(
        &self,
        joint: usize,
        ratio: f64,
        now: &MotorRowFit,
        before: &RowFit,
    ) -> Option<Finding> {
        let channels = self.reading.channels();
        let motor = channels.index(Quantity::MotorPosition, joint)?;
        let link = channels.index(Quantity::LinkPosition, joint)?;
        let column = &channels.all[motor].column;
        let is_degrees = channels.all[motor].is_in_radians() && (ratio / DEGREES).ln().abs() < 1e-9;
        let (table, line, words, cause) = if is_degrees {
            let line = format!("gain = {{ \"{column}\" = {} }}", rounded(DEGREES.recip()));
            let words = format!("give \"{column}\" as motor_position_deg, or set {line} in [log]");
            ("[log]", line, words, "it holds degrees")
        } else {
            let remedy = slope_remedy(&channels.all[motor], &channels.all[link], ratio);
            let cause = if ratio > OTHER_UNIT {
                "it was recorded on the motor side of the gearbox"
            } else {
                "a gear ratio, a number of counts per turn or a unit is wrong"
            };
            (remedy.table, remedy.line, remedy.words, cause)
        };
        let code = if ratio > OTHER_UNIT {
            "units-disagree"
        } else {
            "slope-not-one"
        };
        let others = self.equal_ratios(joint, ratio, now);
        let words = match &others[..] {
            [] => words,
            _ => format!(
                "{words}; {} explain the torque as well, so the data sheet decides",
                others.join(" and ")
            ),
        };
        let finding =
            Finding::new(
                Severity::Error,
                code,
                format!(
                    "{}: \"{column}\" moves about {ratio:.3} times as far as \"{}\": on the link's scale the \
                     motor row leaves {:.1} % of the torque unexplained instead of {:.1} %; {cause}",
                    self.name(joint),
                    self.link(joint),
                    100.0 * now.relative_residual,
                    100.0 * before.relative_residual()
                ),
                &words,
            )
            .seen(self.file, column, ratio, "rad/rad");
        Some(if others.is_empty() {
            finding.mended_by(table, &line)
        } else {
            finding
        })
    }

    /// Returns the other usual gear ratios that explain the torque of a joint about as well, unless the file gives the
    /// ratio.
    fn equal_ratios(&self, joint: usize, ratio: f64, now: &MotorRowFit) -> Vec<String> {
        let channels = self.reading.channels();
        let motor = channels.index(Quantity::MotorPosition, joint);
        let channel = motor.map(|motor| &channels.all[motor]);
        if channel.is_none_or(|channel| channel.before_gear || channel.gear_ratio.is_some()) {
            return Vec::new();
        }
        USUAL_RATIOS
            .into_iter()
            .filter(|usual| {
                let far = (usual / ratio).ln().abs();
                far > 1e-9 && far < NEAR_RATIO
            })
            .filter(|usual| {
                let fit = self.scaled(&[Quantity::MotorPosition], joint, usual.recip());
                fit.is_some_and(|fit| {
                    fit.plausible && fit.relative_residual < NEAR_RESIDUAL * now.relative_residual
                })
            })
            .map(rounded)
            .collect()
    }
}

/// Returns the scales of a scan.
fn scan(about: f64, (each_side, step): (i32, f64)) -> impl Iterator<Item = f64> {
    (-each_side..=each_side).map(move |k| about * step.powi(k))
}

/// Returns the group of columns to which a quantity belongs.
fn group(quantity: Quantity) -> Group {
    [Group::Links, Group::Motors]
        .into_iter()
        .find(|group| group.contains(quantity))
        .unwrap_or(Group::Torques)
}

/// Returns the finding about a reversed torque: stiffness and all friction are negative.
#[must_use]
pub fn reversed_torque(name: &str, torque: &str) -> Finding {
    Finding::new(
        Severity::Error,
        "reversed-torque",
        format!(
            "{name}: in the motor row stiffness and both frictions are negative: the sign of the torque \
             is reversed relative to the motor position"
        ),
        &format!("set sign = {{ \"{torque}\" = -1 }} in [log], or reverse the signs of both positions"),
    )
    .mended_by("[log]", &format!("sign = {{ \"{torque}\" = -1 }}"))
}
