//! Findings about the samples of one channel, made from its statistics.

use std::f64::consts::TAU;

use super::channel::{Event, Figures};
use crate::columns::channel::Channel;
use crate::description::Quantity;
use crate::finding::{Finding, Severity};
use crate::mend::Mended;

/// A torque is saturated if more than this fraction of the samples lies at an extreme, and if the
/// longest run of samples there reaches both this multiple of the mean run length and this number
/// of samples.
const SATURATED_PART: f64 = 0.002;
const SATURATED_RUN_RATIO: f64 = 8.0;
const MIN_SATURATED_SAMPLES: u64 = 5;

/// A spike is farther from the mean of its neighbours than this multiple of the 99th percentile.
const SPIKE_RATIO: f64 = 6.0;

/// A jump of a position exceeds this multiple of the 95th percentile of its steps; a jump after a
/// standstill exceeds this multiple of the 99th percentile.
const JUMP_RATIO: f64 = 10.0;
const STALL_JUMP_RATIO: f64 = 2.5;

/// A step above this fraction of the range means that the counter wraps around.
const WRAP_PART: f64 = 0.95;

/// Largest deviation of a jump from the usual range of a counter.
const NEAR_USUAL_RANGE: f64 = 0.03;

/// A channel in which more than this fraction of the samples changes is not quantised.
const FINE_ENCODER_PART: f64 = 0.9;

/// Minimum number of consecutive equal samples that count as a fault in a channel that is not
/// quantised.
const MIN_HELD_SAMPLES: u64 = 6;

/// Code of the finding about single wrong samples.
pub const SPIKES: &str = "spikes";

/// Code of the finding about samples in which a column stood still.
pub const STUCK_SAMPLES: &str = "stuck-samples";

/// Part of a log that is left out on the side of its longer part where it is cut.
const CUT_MARGIN: f64 = 0.005;

/// Returns the line that reads the longer part of a log, before or after a time.
///
/// - `span`: times of the first and the last sample, s.
#[must_use]
pub fn longer_part(file: &str, time: f64, [begin, end]: [f64; 2]) -> String {
    let margin = CUT_MARGIN * (end - begin);
    let part = if time - begin > end - time {
        format!("to_s = {:.3}", time - margin)
    } else {
        format!("from_s = {:.3}", time + margin)
    };
    format!("file = [{{ path = \"{file}\", {part} }}]")
}

/// Returns findings about the samples of a channel.
///
/// - `(file, joint)`: names for messages.
/// - `mended`: corrected samples, which `figures` do not contain.
pub(crate) fn faults(
    (file, joint): (&str, &str),
    channel: &Channel,
    figures: &Figures,
    mended: &Mended,
) -> Vec<Finding> {
    if figures.extent().is_constant() {
        return Vec::new();
    }
    let samples = SampleCheck {
        file,
        joint,
        channel,
        figures,
    };
    let jumps = samples.jumps();
    let wraps = (jumps.as_ref()).is_some_and(|finding| finding.severity == Severity::Error);
    // A stall ends with a jump, so only one of the two is reported.
    let stays = if wraps {
        jumps
    } else {
        samples.stalled().or(jumps)
    };
    (samples.saturated().into_iter())
        .chain(stays)
        .chain(samples.spikes())
        .chain(samples.interpolated(mended))
        .chain(samples.left_out(mended))
        .collect()
}

struct SampleCheck<'a> {
    file: &'a str,
    joint: &'a str,
    channel: &'a Channel,
    figures: &'a Figures,
}

impl SampleCheck<'_> {
    fn unit(&self) -> &'static str {
        if self.channel.quantity.is_position() {
            "rad (m)"
        } else {
            "N·m (N)"
        }
    }

    fn finding(&self, severity: Severity, code: &str, text: &str, remedy: &str) -> Finding {
        let text = format!("{}: \"{}\" {text}", self.joint, self.channel.column);
        Finding::new(severity, code, text, remedy)
    }

    /// Reports a torque that lies repeatedly at its largest or smallest value.
    fn saturated(&self) -> Option<Finding> {
        if self.channel.quantity.is_position() {
            return None;
        }
        let figures = self.figures;
        let extent = figures.extent();
        let most = extent.min.abs().max(extent.max.abs());
        let usual = 1.0 / figures.changing().max(1e-9);
        let flat = figures.extremes().into_iter().filter(|extreme| {
            extreme.value.abs() > 0.5 * most
                && extreme.longest.samples
                    >= MIN_SATURATED_SAMPLES.max((SATURATED_RUN_RATIO * usual) as u64)
                && extreme.samples as f64 > SATURATED_PART * figures.samples() as f64
        });
        let worst = flat.max_by_key(|extreme| extreme.samples)?;
        let part = 100.0 * worst.samples as f64 / figures.samples() as f64;
        let finding = self.finding(
            Severity::Warning,
            "torque-saturated",
            &format!(
                "lies at its extreme, {:.4} N·m (N), in {part:.2} % of the samples, up to {} in a \
                 row: the amplifier or the sensor is saturated",
                worst.value, worst.longest.samples
            ),
            match self.channel.quantity {
                Quantity::JointTorque => {
                    "move with less acceleration, so that the torque stays below the range of the \
                     sensor, or leave these parts out by windows"
                }
                Quantity::LinkPosition
                | Quantity::LinkDeflection
                | Quantity::MotorPosition
                | Quantity::MotorTorque
                | Quantity::MotorTarget
                | Quantity::DriveOn
                | Quantity::Inertial(..)
                | Quantity::Covariate(_) => {
                    "log the torque that acted instead of the commanded torque, or move with less \
                     acceleration, so that the torque stays below the limit"
                }
            },
        );
        Some(
            (finding.seen(self.file, &self.channel.column, worst.value, "N·m"))
                .at(worst.longest.time),
        )
    }

    /// Reports a run of samples in which the column repeats one value although the joint moves.
    fn stalled(&self) -> Option<Finding> {
        let figures = self.figures;
        let stall = if self.channel.quantity.is_position() {
            let step = figures.steps().quantile(0.99);
            // A change larger than the joint could have made meanwhile is a jump, not a stall.
            *(figures.stalls().iter()).find(|stall| {
                let jump = stall.jump.abs();
                jump > STALL_JUMP_RATIO * step && jump < 2.0 * step * stall.samples as f64
            })?
        } else {
            // Before the motion begins, the torque at rest may be constant.
            let begins = figures.overview().time.first().copied();
            let usual = figures.steps().quantile(0.5);
            let stuck = figures.stalls().iter().filter(|stall| {
                let extreme = (figures.extremes().iter())
                    .any(|extreme| extreme.value.to_bits() == stall.value.to_bits());
                !extreme
                    && stall.value != 0.0
                    && stall.samples >= MIN_HELD_SAMPLES
                    && stall.jump.abs() > usual
                    && begins.is_some_and(|begins| stall.time > begins)
            });
            let longest = stuck.max_by_key(|stall| stall.samples);
            *longest.filter(|_| figures.changing() > FINE_ENCODER_PART)?
        };
        let finding = self.finding(
            Severity::Warning,
            STUCK_SAMPLES,
            &format!(
                "repeats {:.6} {} in {} samples from {:.3} s on and then changes by {:.2e}: the \
                 recorder or the sensor froze while the joint moved",
                stall.value,
                self.unit(),
                stall.samples,
                stall.time,
                stall.jump.abs()
            ),
            "remove these samples from the log: sprung handles the resulting gap; check that the \
             recorder is fast enough",
        );
        Some(
            (finding.seen(
                self.file,
                &self.channel.column,
                stall.samples as f64,
                "samples",
            ))
            .at(stall.time),
        )
    }

    /// Reports a position that steps farther than the joint moves within one sample.
    fn jumps(&self) -> Option<Finding> {
        if !self.channel.quantity.is_position() {
            return None;
        }
        let figures = self.figures;
        let limit = JUMP_RATIO * figures.steps().quantile(0.95);
        let range = figures.extent().range();
        let mut all: Vec<&Event> = (figures.jumps().iter())
            .filter(|jump| jump.size.abs() > limit)
            .collect();
        let largest = *all.first()?;
        all.sort_by(|a, b| a.time.total_cmp(&b.time));
        let first = *all.first()?;
        let size = largest.size.abs();
        let column = &self.channel.column;
        if size > WRAP_PART * range {
            let raw = size / self.channel.factor.abs();
            let finding = self.finding(
                Severity::Error,
                "wraps-around",
                &format!(
                    "jumps by {size:.4} {} of its range of {range:.4} at {:.3} s and {} more times: \
                     the counter wraps around",
                    self.unit(),
                    first.time,
                    all.len() - 1
                ),
                "give the number of units of the column after which the counter wraps around",
            );
            let setting = format!(
                "{} = {{ column = \"{column}\", wrap = {} }}",
                self.channel.quantity.key(),
                counter_range(raw)
            );
            return Some(
                (finding.seen(self.file, column, largest.size, "rad"))
                    .at(first.time)
                    .mended_by("[log]", &setting),
            );
        }
        let finding = self.finding(
            Severity::Warning,
            "position-jumps",
            &format!(
                "jumps by {:.3e} {} at {:.3} s, {:.0} times the 95th percentile of its steps, and then \
                 stays at the new position: counts were lost, or the sensor was reset",
                largest.size,
                self.unit(),
                largest.time,
                size / figures.steps().quantile(0.95)
            ),
            "use the log up to this time, or after it: the zero of the encoder is another one in each part",
        );
        let part = longer_part(self.file, largest.time, figures.span());
        Some(
            (finding.seen(self.file, column, largest.size, "rad"))
                .at(largest.time)
                .mended_by("[log]", &part),
        )
    }

    /// Reports single samples that were interpolated.
    fn interpolated(&self, mended: &Mended) -> Option<Finding> {
        let (time, size) = mended.largest;
        (mended.spikes > 0).then(|| {
            let finding = self.finding(
                Severity::Info,
                SPIKES,
                &format!(
                    "has single samples far from their neighbours ({}), which were interpolated; the largest, at \
                     {time:.4} s, is off by {size:.3e} {}",
                    mended.spikes,
                    self.unit(),
                ),
                "look for a loose connector or a flipping bit; wrong_samples = \"keep\" in [log] uses the samples",
            );
            (finding.seen(self.file, &self.channel.column, size, "rad")).at(time)
        })
    }

    /// Reports samples that were left out because the column stood still.
    fn left_out(&self, mended: &Mended) -> Option<Finding> {
        let (time, longest) = mended.longest;
        (mended.stalls > 0).then(|| {
            let finding = self.finding(
                Severity::Info,
                STUCK_SAMPLES,
                &format!(
                    "stands still although the joint moves, in {} samples ({}, the longest at {time:.3} s with \
                     {longest} samples), which were left out: the recorder or the sensor froze",
                    mended.stalled,
                    match mended.stalls {
                        1 => "1 time".to_owned(),
                        count => format!("{count} times"),
                    },
                ),
                "check that the recorder is fast enough; wrong_samples = \"keep\" in [log] uses the samples",
            );
            let samples = mended.stalled as f64;
            (finding.seen(self.file, &self.channel.column, samples, "samples")).at(time)
        })
    }

    /// Reports single samples far from two neighbours that agree.
    fn spikes(&self) -> Option<Finding> {
        let figures = self.figures;
        let limit = SPIKE_RATIO * figures.bends().quantile(0.99);
        let largest = *figures.spikes().first()?;
        if limit <= 0.0 || largest.size.abs() <= limit {
            return None;
        }
        let count = figures.lone().above(limit).max(1);
        let finding = self.finding(
            Severity::Warning,
            SPIKES,
            &format!(
                "has single samples far from their neighbours ({count}); the largest, at {:.4} s, is \
                 off by {:.3e} {}, {:.0} times the 99th percentile of all samples",
                largest.time,
                largest.size,
                self.unit(),
                largest.size.abs() / figures.bends().quantile(0.99)
            ),
            "replace these samples by the mean of their neighbours, or remove their rows; look for a \
             loose connector or a flipping bit",
        );
        Some((finding.seen(self.file, &self.channel.column, largest.size, "rad")).at(largest.time))
    }
}

/// Returns a size rounded to a whole number or full turn within 2 %, otherwise with four decimals.
fn rounded(raw: f64) -> String {
    let near = |value: f64| (raw / value - 1.0).abs() < 0.02;
    let powers = (4..=32).map(|bits| 2_f64.powi(bits));
    let whole = [360.0, 400.0, 1000.0, 4000.0, 10000.0];
    if near(std::f64::consts::TAU) {
        return "6.283185307179586".to_owned();
    }
    match powers.chain(whole).find(|value| near(*value)) {
        Some(value) => format!("{value}"),
        None => format!("{raw:.4}"),
    }
}
/// Returns the range of a counter as text: the usual one nearest to a jump, which lacks a step, or the jump.
fn counter_range(jump: f64) -> String {
    let turns = [TAU, 360.0]
        .into_iter()
        .flat_map(|turn| [turn / 2.0, turn, 2.0 * turn]);
    let usual = turns.chain((0..=32).map(|bits| f64::from(bits).exp2()));
    let far = |range: &f64| (range / jump).ln().abs();
    let nearest = usual.min_by(|a, b| far(a).total_cmp(&far(b)));
    match nearest.filter(|range| far(range) < NEAR_USUAL_RANGE) {
        Some(range) => range.to_string(),
        None => rounded(jump),
    }
}
