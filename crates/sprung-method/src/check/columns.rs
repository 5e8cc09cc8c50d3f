//! Other meanings of the columns that would explain a joint better: link and motor exchanged,
//! joints swapped, signs reversed, another scale.

use sprung_core::parameters::JointParameter;

use super::context::{CheckContext, SIGNIFICANT_SIGMAS};
use crate::finding::{Finding, Severity};
use crate::log::{Channels, Quantity, Signal, slope_remedy};
use crate::prepare::{DelayEstimate, Excerpt, MotorRowFit, RowFit, estimate_delays, fit_rows};

/// Another meaning of the columns is reported if it reduces the residual below this fraction.
const BETTER_RESIDUAL_SHARE: f64 = 0.9;

/// Scales of a motor position in the scan about the ratio of standard deviations: their number on
/// each side, and the ratio of neighbours.
const SCALES_EACH_SIDE: i32 = 6;
const SCALE_RATIO: f64 = 1.1;

/// Smallest scale error that is reported.
const MIN_SCALE: f64 = 1.25;

impl CheckContext<'_> {
    /// Returns the fits with which the trials of this file are compared: those of few samples, as in
    /// the trials, or the given ones if there is nothing to try.
    pub(super) fn compared(&self, fits: &[RowFit], weak: &[usize]) -> Vec<RowFit> {
        let all: Vec<usize> = (0..fits.len()).collect();
        let few = (!weak.is_empty()).then(|| fit_rows(&self.few, self.reading, &all));
        few.flatten().unwrap_or_else(|| fits.to_vec())
    }

    /// Fits the torque rows of some joints with other meanings of the columns.
    fn with(&self, channels: &Channels, joints: &[usize]) -> Option<Vec<MotorRowFit>> {
        let reading = self.reading.with_channels(channels.clone());
        let fits = fit_rows(&self.few, &reading, joints)?;
        Some(fits.iter().map(|fit| fit.short(reading.model())).collect())
    }

    /// Returns joints with apparently exchanged link and motor columns, and adds findings about
    /// them.
    pub(super) fn exchanged(
        &self,
        fits: &[RowFit],
        weak: &[usize],
        findings: &mut Vec<Finding>,
    ) -> Vec<usize> {
        let channels = self.reading.channels();
        let mut reported = Vec::new();
        let exchanged = weak.iter().fold(channels.clone(), |channels, &joint| {
            channels.exchanged(joint).unwrap_or(channels)
        });
        if exchanged == *channels {
            return reported;
        }
        let now = self.with(&exchanged, weak).unwrap_or_default();
        for (&joint, fit) in weak.iter().zip(&now) {
            let better = fit.plausible
                && fit.relative_residual < BETTER_RESIDUAL_SHARE * fits[joint].relative_residual()
                && channels.exchanged(joint).is_some();
            if !better {
                continue;
            }
            reported.push(joint);
            let (link, motor) = (
                self.link(joint),
                self.column(&[Quantity::MotorPosition], joint),
            );
            let lines = channels
                .exchanged(joint)
                .map_or_else(String::new, |now| self.column_lines(&now));
            findings.push(
                Finding::new(
                    Severity::Error,
                    "exchanged-columns",
                    format!(
                        "{}: with link and motor position exchanged the motor row explains {:.0} % \
                         of the torque and every parameter is positive (stiffness {:.4} N·m/rad): \
                         the columns look swapped",
                        self.name(joint),
                        100.0 * (1.0 - fit.relative_residual.powi(2)),
                        fit.stiffness.unwrap_or_default()
                    ),
                    &format!(
                        "exchange \"{link}\" and \"{motor}\" under link_position_rad and \
                         motor_position_rad"
                    ),
                )
                .about(self.about_stiffness(joint))
                .seen(self.file, link, fit.relative_residual, "")
                .mended_by("[log]", &lines),
            );
        }
        reported
    }

    /// Adds findings about pairs of joints with apparently swapped columns of one quantity.
    pub(super) fn swapped(
        &self,
        fits: &[RowFit],
        weak: &[usize],
        reported: &mut Vec<usize>,
        findings: &mut Vec<Finding>,
    ) {
        let channels = self.reading.channels();
        for (k, &one) in weak.iter().enumerate() {
            for &two in &weak[k + 1..] {
                for quantity in Quantity::all() {
                    if reported.contains(&one) || reported.contains(&two) {
                        continue;
                    }
                    let Some(swapped) = channels.swapped(quantity, one, two) else {
                        continue;
                    };
                    let Some(now) = self.with(&swapped, &[one, two]) else {
                        continue;
                    };
                    let better = |(fit, &joint): (&MotorRowFit, &usize)| {
                        let before = fits[joint].relative_residual();
                        fit.plausible && fit.relative_residual < BETTER_RESIDUAL_SHARE * before
                    };
                    if now.iter().zip(&[one, two]).all(better) {
                        reported.extend([one, two]);
                        let line = self.column_lines(&swapped);
                        let finding = self.swap(quantity, one, two, fits, &now);
                        findings.push(finding.mended_by("[log]", &line));
                    }
                }
            }
        }
    }

    /// - `after`: fits of both joints with the columns swapped.
    fn swap(
        &self,
        quantity: Quantity,
        one: usize,
        two: usize,
        before: &[RowFit],
        after: &[MotorRowFit],
    ) -> Finding {
        let (a, b) = (self.column(&[quantity], one), self.column(&[quantity], two));
        let percent = |residual: f64| 100.0 * (1.0 - residual.powi(2)).max(0.0);
        Finding::new(
            Severity::Error,
            "swapped-joints",
            format!(
                "{} and {}: with \"{a}\" and \"{b}\" swapped the motor rows explain {:.0} % and {:.0} \
                 % of their torque instead of {:.0} % and {:.0} %, and every parameter is positive: \
                 the columns belong to the other joint",
                self.name(one),
                self.name(two),
                percent(after[0].relative_residual),
                percent(after[1].relative_residual),
                percent(before[one].relative_residual()),
                percent(before[two].relative_residual()),
            ),
            "give the columns in the order of the joints",
        )
        .seen(self.file, a, after[0].relative_residual, "")
    }

    /// Finding: the torque brakes where it should drive.
    pub(super) fn reversed(&self, joint: usize, fit: &RowFit) -> Option<Finding> {
        let signed: Vec<(JointParameter, f64, f64)> = (fit
            .of_joints(self.reading.model(), self.independent))
        .into_iter()
        .filter(|(kind, ..)| kind.is_friction() || *kind == JointParameter::Stiffness)
        .collect();
        let negative = |&(_, value, error): &(JointParameter, f64, f64)| value < -2.0 * error;
        let any_clear = signed
            .iter()
            .any(|(_, value, error)| value < &(-SIGNIFICANT_SIGMAS * error));
        if signed.len() < 2 || !signed.iter().all(negative) || !any_clear {
            return None;
        }
        let torque = self.column(&[Quantity::MotorTorque], joint);
        Some(reversed_torque(self.name(joint), torque).seen(self.file, torque, signed[0].1, ""))
    }

    /// Fits the torque row of a joint with one column multiplied by `by`.
    fn scaled(&self, quantities: &[Quantity], joint: usize, by: f64) -> Option<MotorRowFit> {
        let channel = (quantities.iter())
            .find_map(|&quantity| self.reading.channels().index(quantity, joint))?;
        let excerpt = self.few.scaled(channel, by);
        let fits = fit_rows(&excerpt, self.reading, &[joint])?;
        Some(fits.first()?.short(self.reading.model()))
    }

    /// Finding: by the equations, link and motor position have opposite directions.
    pub(super) fn opposite(&self, joint: usize, fit: &RowFit) -> Option<Finding> {
        let before = fit.relative_residual();
        let (link, motor) = (
            self.link(joint),
            self.column(&[Quantity::MotorPosition], joint),
        );
        if link.is_empty() {
            return None;
        }
        // The fit of the torque shows which of the two columns is reversed.
        let (wrong, turned) = [
            (
                link,
                &[Quantity::LinkPosition, Quantity::LinkDeflection][..],
            ),
            (motor, &[Quantity::MotorPosition][..]),
        ]
        .into_iter()
        .filter_map(|(column, quantities)| Some((column, self.scaled(quantities, joint, -1.0)?)))
        .filter(|(_, fit)| fit.plausible && fit.relative_residual < BETTER_RESIDUAL_SHARE * before)
        .min_by(|(_, a), (_, b)| a.relative_residual.total_cmp(&b.relative_residual))?;
        Some(
            Finding::new(
                Severity::Error,
                "opposite-signs",
                format!(
                    "{}: \"{motor}\" and \"{link}\" have opposite directions: with the sign of \
                     \"{wrong}\" reversed the motor row leaves {:.1} % of the torque unexplained instead \
                     of {:.1} %, and every parameter is positive",
                    self.name(joint),
                    100.0 * turned.relative_residual,
                    100.0 * before
                ),
                &format!(
                    "set sign = {{ \"{wrong}\" = -1 }} in [log]"
                ),
            )
            .seen(self.file, wrong, turned.relative_residual, "")
            .mended_by("[log]", &format!("sign = {{ \"{wrong}\" = -1 }}")),
        )
    }

    /// Finding: a position has the wrong sign and is late, and either of both alone explains the torque worse.
    pub(super) fn opposite_and_late(&self, joint: usize, fit: &RowFit) -> Option<Finding> {
        let channels = self.reading.channels();
        let of = |signal: Signal| channels.telling(signal, joint);
        let (link, motor, torque) = (of(Signal::Link)?, of(Signal::Motor)?, of(Signal::Torque)?);
        if [link, motor, torque].map(|i| channels.all[i].delay) != [None; 3] {
            return None;
        }
        let late = |excerpt: &Excerpt, channel: usize| {
            let found = estimate_delays(excerpt, self.reading, &[channel])?.pop()?;
            (found.found && found.with.plausible).then_some(found)
        };
        let residual = |own: &DelayEstimate| own.with.relative_residual;
        let by_delay = [link, motor, torque]
            .into_iter()
            .filter_map(|i| late(self.excerpt, i));
        let before = fit.relative_residual();
        let least = by_delay.map(|own| residual(&own)).fold(before, f64::min);
        let turned = [link, motor]
            .into_iter()
            .filter_map(|i| late(&self.excerpt.scaled(i, -1.0), i));
        let own = (turned.filter(|own| residual(own) < BETTER_RESIDUAL_SHARE * least))
            .min_by(|a, b| residual(a).total_cmp(&residual(b)))?;
        let (column, delay) = (&channels.all[own.channel].column, own.delay);
        let lines =
            format!("sign = {{ \"{column}\" = -1 }}\ndelay_s = {{ \"{column}\" = \"estimate\" }}");
        let text = format!(
            "{}: \"{column}\" has the wrong direction and was recorded {delay:.3} s late (standard error {:.3} s): with both \
             the motor row leaves {:.1} % of the torque unexplained instead of {:.1} %, and every parameter is positive",
            self.name(joint),
            own.standard_error,
            100.0 * residual(&own),
            100.0 * before
        );
        let remedy = format!("set in [log] {}", lines.replace('\n', " and "));
        let finding = Finding::new(Severity::Error, "opposite-signs", text, &remedy);
        Some((finding.seen(self.file, column, residual(&own), "")).mended_by("[log]", &lines))
    }

    /// Finding: by the equations, the motor position has another scale than the link position.
    pub(super) fn other_scale(&self, joint: usize, fit: &RowFit) -> Option<Finding> {
        let channels = self.reading.channels();
        let motor = channels.index(Quantity::MotorPosition, joint)?;
        let link = channels.index(Quantity::LinkPosition, joint)?;
        let deviation = |channel: usize| {
            let (mut n, mut sum, mut squares) = (0.0, 0.0, 0.0);
            let first = self.excerpt.channel(channel).next().unwrap_or(0.0);
            for value in self.excerpt.channel(channel) {
                n += 1.0;
                sum += value - first;
                squares += (value - first).powi(2);
            }
            (squares / n - (sum / n).powi(2)).max(0.0).sqrt()
        };
        let about = deviation(motor) / deviation(link);
        if !(about.is_finite() && about > 0.0) {
            return None;
        }
        let mut best: Option<(f64, MotorRowFit)> = None;
        for k in -SCALES_EACH_SIDE..=SCALES_EACH_SIDE {
            let ratio = about * SCALE_RATIO.powi(k);
            let Some(now) = self.scaled(&[Quantity::MotorPosition], joint, 1.0 / ratio) else {
                continue;
            };
            let better =
                best.is_none_or(|(_, before)| now.relative_residual < before.relative_residual);
            if now.plausible && better {
                best = Some((ratio, now));
            }
        }
        let (ratio, now) = best?;
        let before = fit.relative_residual();
        if now.relative_residual > BETTER_RESIDUAL_SHARE * before
            || ratio.ln().abs() < MIN_SCALE.ln()
        {
            return None;
        }
        let remedy = slope_remedy(&channels.all[motor], &channels.all[link], ratio);
        let column = &channels.all[motor].column;
        Some(
            Finding::new(
                Severity::Error,
                "slope-not-one",
                format!(
                    "{}: \"{column}\" moves about {ratio:.3} times as far as \"{}\": on the link's scale \
                     the motor row leaves {:.1} % of the torque unexplained instead of {:.1} %; a gear \
                     ratio, a number of counts per turn or a unit is wrong",
                    self.name(joint),
                    self.link(joint),
                    100.0 * now.relative_residual,
                    100.0 * before
                ),
                &remedy.words,
            )
            .seen(self.file, column, ratio, "rad/rad")
            .mended_by(remedy.table, &remedy.line),
        )
    }
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
