//! Findings about effects that the model lacks.

use super::effects::{Effect, Wave};
use super::refined::Refined;
use super::undeclared::{Cause, LEAST_TORQUE_SHARE, Undeclared};
use crate::estimate::laws::Tested;
use crate::estimate::statistics::CERTAIN_SIGMAS;
use crate::finding::{Finding, Severity};
use crate::log::{Channel, Channels};
use crate::model::{Model, short};
use crate::numbers::{in_ms, in_percent};
use crate::regression::Reading;
use crate::unknowns::{AddedLaw, Kind, UnknownResult, UnknownStatus};

/// Reports the relevant effects, in the order of their gains.
pub(super) fn about_undeclared(
    reading: &Reading,
    refined: &Refined,
    undeclared: &[Undeclared],
) -> Vec<Finding> {
    let about = About::new(reading, refined);
    (undeclared.iter())
        .filter(|one| is_relevant(one, refined))
        .filter_map(|undeclared| about.finding(undeclared))
        .collect()
}

/// Returns the relevant effects for the list of what the logs show.
pub(super) fn listed_unknowns(
    reading: &Reading,
    refined: &Refined,
    undeclared: &[Undeclared],
) -> Vec<UnknownResult> {
    let about = About::new(reading, refined);
    let relevant = undeclared.iter().filter(|one| is_relevant(one, refined));
    relevant.map(|one| about.unknown(one)).collect()
}

fn is_relevant(undeclared: &Undeclared, refined: &Refined) -> bool {
    undeclared.significance() > CERTAIN_SIGMAS && undeclared.matters(refined)
}

struct About<'a> {
    model: &'a Model,
    channels: &'a Channels,
    /// Delay of each channel that the refinement has used, s.
    delays: &'a [f64],
    refined: &'a Refined,
}

impl<'a> About<'a> {
    fn new(reading: &'a Reading, refined: &'a Refined) -> Self {
        Self {
            model: reading.model(),
            channels: reading.channels(),
            delays: reading.delays(),
            refined,
        }
    }

    fn unknown(&self, undeclared: &Undeclared) -> UnknownResult {
        let squares = self.refined.search.cost * self.refined.read.measurements as f64;
        let unknown = UnknownResult {
            id: String::new(),
            kind: String::new(),
            place: String::new(),
            value: undeclared.value,
            standard_error: undeclared.standard_error,
            unit: undeclared.unit.to_owned(),
            begins_s: None,
            law: None,
            status: UnknownStatus::Found,
            competing: Vec::new(),
            effect: 2.0 * undeclared.gain / squares,
        };
        match &undeclared.cause {
            Cause::Law(tested) => {
                let joint = self.model.joints()[tested.joint].clone();
                UnknownResult {
                    id: format!("law {joint}.{}.{}", tested.of, tested.law),
                    kind: Kind::Law.name().to_owned(),
                    place: joint,
                    law: Some(AddedLaw {
                        of: tested.of.to_owned(),
                        law: tested.law.to_owned(),
                        ..AddedLaw::default()
                    }),
                    ..unknown
                }
            }
            Cause::Effect(channel, effect) => {
                let before = if effect.is_delay() {
                    self.delays[*channel]
                } else {
                    0.0
                };
                UnknownResult {
                    value: before + undeclared.value,
                    ..self.named(unknown, &self.channels.all[*channel], *effect)
                }
            }
        }
    }

    /// Returns an unknown with id, kind and place of an effect.
    fn named(&self, unknown: UnknownResult, channel: &Channel, effect: Effect) -> UnknownResult {
        let (column, joint) = (&channel.column, &self.model.joints()[channel.joint]);
        let named = |id: String, kind: &str, place: &str| UnknownResult {
            id,
            kind: kind.to_owned(),
            place: place.to_owned(),
            ..unknown
        };
        let of_wave = |name: &str, wave: Wave| {
            let id = format!("{} {joint} {}", name.replace('-', " "), wave.per_turn);
            (id, name.to_owned())
        };
        match effect {
            Effect::SensorDelay(_) | Effect::TorqueDelay(_) => {
                named(format!("delay {column}"), Kind::Delay.name(), column)
            }
            Effect::TorquesDelay => {
                let id = "timing of the torques".to_owned();
                named(id, Kind::Timing.name(), column)
            }
            Effect::Saturation { .. } => named(
                format!("saturation {joint}"),
                Kind::Saturation.name(),
                column,
            ),
            Effect::Eccentricity { .. } => named(
                format!("eccentricity {column}"),
                Kind::Eccentricity.name(),
                column,
            ),
            Effect::Ripple { wave, .. } => {
                let (id, kind) = of_wave("torque-ripple", wave);
                named(id, &kind, joint)
            }
            Effect::TransmissionError { wave, .. } => {
                let (id, kind) = of_wave("transmission-error", wave);
                named(id, &kind, joint)
            }
            Effect::Drift { .. } => named(
                format!("friction drift {joint}"),
                Kind::Friction.name(),
                joint,
            ),
        }
    }

    fn finding(&self, undeclared: &Undeclared) -> Option<Finding> {
        let (index, moved) = undeclared.largest_move(self.refined)?;
        let severity = if moved > CERTAIN_SIGMAS {
            Severity::Warning
        } else {
            Severity::Info
        };
        let name = &self.model.parameters()[index].name;
        let moves = format!(
            "With it {} would move by {moved:.1} of its standard errors",
            short(name)
        );
        let finding = match &undeclared.cause {
            Cause::Law(law) => self.law(undeclared, law, severity, &moves),
            Cause::Effect(channel, effect) => {
                self.effect(undeclared, (*channel, *effect), severity, &moves)
            }
        };
        Some(finding.about([name.clone()]))
    }

    fn law(
        &self,
        undeclared: &Undeclared,
        law: &Tested,
        severity: Severity,
        moves: &str,
    ) -> Finding {
        let (joint, of, word) = (&self.model.joints()[law.joint], law.of, law.law);
        Finding::new(
            severity,
            "law-by-likelihood",
            format!(
                "{joint}: the likelihood asks for {of} \"{word}\", which the model lacks ({:.1} \
                 standard errors from zero, {}). {moves}",
                undeclared.significance(),
                of_torque(undeclared.size),
            ),
            "add the law to the joint; the parameters of this joint contain the effect",
        )
    }

    fn effect(
        &self,
        undeclared: &Undeclared,
        (channel, effect): (usize, Effect),
        severity: Severity,
        moves: &str,
    ) -> Finding {
        let column = &self.channels.all[channel].column;
        let joint = &self.model.joints()[self.channels.all[channel].joint];
        let (percent, error) = (
            in_percent(undeclared.value),
            in_percent(undeclared.standard_error),
        );
        let (code, text, remedy) = match effect {
            Effect::SensorDelay(_) | Effect::TorqueDelay(_) | Effect::TorquesDelay => {
                return self.late(undeclared, (channel, effect), severity, moves);
            }
            Effect::Saturation { .. } => (
                "torque-saturates",
                format!(
                    "the acting torque grows {} than \"{column}\": at the standard deviation of the torque the \
                     difference is {:.2} ± {error:.2} %, and it grows with the third power of the torque",
                    if percent > 0.0 { "less" } else { "more" },
                    percent.abs(),
                ),
                "measure the torque constant at several currents, or record a motion with smaller torques",
            ),
            Effect::Eccentricity { .. } => (
                "eccentric-encoder",
                format!(
                    "\"{column}\" deviates from the angle of the link by {:.3} ± {:.3} mrad once a turn, as an encoder \
                     does whose disc is not centred",
                    in_ms(undeclared.value),
                    in_ms(undeclared.standard_error),
                ),
                "calibrate the encoder over a turn and correct its readings, or use two reading heads",
            ),
            Effect::Ripple { wave, .. } => (
                "torque-ripple",
                format!(
                    "{joint}: the motor torque has a ripple of {percent:.2} ± {error:.2} % of its standard deviation, {}",
                    times(wave)
                ),
                "nothing in the log; compensate the ripple in the drive, or move faster, so that the spring does not \
                 follow it",
            ),
            Effect::TransmissionError { wave, .. } => (
                "transmission-error",
                format!(
                    "{joint}: the gear has a transmission error of {:.4} ± {:.4} mrad, {}",
                    in_ms(undeclared.value),
                    in_ms(undeclared.standard_error),
                    times(wave)
                ),
                "nothing in the log; measure the error of the gear at rest, and correct the motor positions by it",
            ),
            Effect::Drift { .. } => (
                "friction-drifts",
                format!(
                    "{joint}: the viscous friction of the motor changes by {percent:+.1} ± {error:.1} % from the beginning \
                     to the end of the logs, as it does when a gear warms up"
                ),
                "run the robot warm before the log, or log the temperature and name it in [log] as a covariate",
            ),
        };
        let text = format!("by likelihood, {text}. {moves}");
        Finding::new(severity, code, text, remedy).seen(
            "",
            column,
            undeclared.value,
            undeclared.unit,
        )
    }

    /// The hold-out that follows completes the name of the log.
    fn late(
        &self,
        undeclared: &Undeclared,
        (channel, effect): (usize, Effect),
        severity: Severity,
        moves: &str,
    ) -> Finding {
        let column = &self.channels.all[channel].column;
        let (before, after) = (
            self.delays[channel],
            self.delays[channel] + undeclared.value,
        );
        let what = match effect {
            Effect::TorquesDelay => "every motor torque".to_owned(),
            _ => format!("\"{column}\""),
        };
        Finding::new(
            severity,
            "late-channel",
            format!(
                "by likelihood, {what} was recorded {} instead of {} (standard error {:.5} s, log-likelihood of blocks \
                 that the estimate has not seen +{:.0}). {moves}",
                when(after),
                when(before),
                undeclared.standard_error,
                undeclared.gain
            ),
            &format!("set delay_s = {{ \"{column}\" = \"estimate\" }} in [log]"),
        )
        .seen("", column, after, "s")
    }
}

/// Returns the size of an effect relative to the torque, in words.
fn of_torque(size: f64) -> String {
    format!(
        "{:.1} % of the torque",
        in_percent(size * LEAST_TORQUE_SHARE)
    )
}

fn times(wave: Wave) -> String {
    match wave.per_turn {
        1 => "once per turn of the motor".to_owned(),
        many => format!("{many} times per turn of the motor"),
    }
}

/// Returns the delay in words.
fn when(delay: f64) -> String {
    match delay {
        d if d > 0.0 => format!("{d:.5} s late"),
        d if d < 0.0 => format!("{:.5} s early", -d),
        _ => "on time".to_owned(),
    }
}
