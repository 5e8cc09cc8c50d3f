//! The timing of the torques and the sharpness of Coulomb friction, where the likelihood differs from the preparation.

use super::channel_updates::ChannelUpdate;
use super::effects::TorquesTiming;
use super::refine::{End, Refinery};
use super::refined::Refined;
use super::rung::Rung;
use crate::description::{Delay, Experiment, Laws};
use crate::estimate::result::Refinement;
use crate::estimate::statistics::{CERTAIN_SIGMAS, MIN_DELAY_SAMPLES};
use crate::finding::{Finding, Severity};
use crate::log::{Channel, Quantity};
use crate::model::Model;
use crate::numbers::in_ms;
use crate::prepare::{DelayGain, Excerpt};
use crate::regression::{PassError, Reading};
use crate::unknowns::{Kind, LEAST_CHANGE_OF_SHARPNESS};
use sprung_core::friction::Scale;

/// Longest common delay of all torques by controller and recorder, in samples. A longer one is that of a faulty
/// channel.
const LONGEST_SAMPLES: f64 = 2.0;

/// Rise of the held-out error of the equations that contradicts a delay of at most so many samples, by which smearing by the
/// filter of the positions moves the delay where this error is least. Any rise contradicts a longer delay.
const OBJECTION: f64 = 0.1;
const SMEARED_SAMPLES: f64 = 1.0 / 3.0;

/// Change of an estimated delay, in samples, from which the regression is repeated with it.
const LEAST_MOVE_SAMPLES: f64 = 0.02;

/// Treatment of the timing of torques and of the sharpness of Coulomb friction.
#[derive(Clone, Copy)]
pub(in crate::estimate) enum Timing<'a> {
    /// The refinement may find another one.
    Open,
    /// A first refinement has found it.
    Found(&'a Retiming),
}

/// Timing for the regression and a second refinement.
pub(in crate::estimate) struct Retiming {
    /// Common delay of all torques, s, with its standard error and the gain of the equations by it; `None` if it stays.
    pub(in crate::estimate) torques: Option<TorquesDelay>,
    /// Delays of all channels, s, if those that are estimated have moved.
    delays: Option<Vec<f64>>,
    /// Sharpness of Coulomb friction, s/rad (s/m), by joint.
    pub(in crate::estimate) sharpness: Vec<(usize, f64)>,
    /// End of the first refinement, from which the second one starts; `None` after another model.
    pub(super) end: Option<End>,
}

/// The timing that a refinement finds.
pub(super) struct Wanted {
    torques: Option<TorquesDelay>,
    delays: Option<Vec<f64>>,
    sharpness: Vec<(usize, f64)>,
}

impl Wanted {
    /// - `end`: of the refinement; `reading`: of the logs, with the timing before.
    pub(super) fn with(self, end: End, reading: &Reading) -> Retiming {
        let mut retiming = Retiming {
            end: None,
            torques: self.torques,
            delays: self.delays,
            sharpness: self.sharpness,
        };
        retiming.end = Some(End {
            delays: retiming.delays(reading),
            ..end
        });
        retiming
    }
}

/// A delay that all torques have together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::estimate) struct TorquesDelay {
    /// Beyond the delay that the preparation has used, s.
    by: f64,
    /// The whole delay, s.
    delay: f64,
    standard_error: f64,
    /// Held-out errors of the equations without and with it.
    pub(in crate::estimate) gain: DelayGain,
}

impl Retiming {
    /// Returns the delay of all torques and its standard error, s; `None` if it stays.
    ///
    /// - `refined`: the refinement with this timing.
    pub(in crate::estimate) fn torques_delay(
        &self,
        refined: Option<&Refinement>,
    ) -> Option<(f64, f64)> {
        let torques = self.torques?;
        let refined = refined.and_then(|refinement| refinement.torques_delay_s);
        Some(refined.unwrap_or((torques.delay, torques.standard_error)))
    }

    /// Returns the settings for reading the logs with the new timing.
    pub(in crate::estimate) fn applied(&self, reading: &Reading) -> Reading {
        let model = sharpened(reading.model(), &self.sharpness);
        (reading.with_delays(&self.delays(reading))).with_model(model)
    }

    /// Returns the delays of all channels, s.
    fn delays(&self, reading: &Reading) -> Vec<f64> {
        let by = self.torques.map_or(0.0, |torques| torques.by);
        match &self.delays {
            Some(delays) => delayed(&reading.with_delays(delays), by),
            None => delayed(reading, by),
        }
    }
}

/// Returns the treatment of the delay of all torques. It is estimated if the log has shown it already. A sharpness that the
/// description gives is tested with the meaning of the torques.
pub(super) fn timing_of(reading: &Reading) -> TorquesTiming {
    let channels = reading.channels();
    let all = channels.all.iter().zip(reading.delays());
    let is_found = |(channel, delay): (&Channel, &f64)| {
        channel.quantity == Quantity::MotorTorque && channel.delay.is_none() && *delay != 0.0
    };
    if all.clone().any(is_found) {
        return TorquesTiming::Estimated;
    }
    let mut torques =
        (channels.all.iter()).filter(|channel| channel.quantity == Quantity::MotorTorque);
    let is_declared = channels.torque_hold.is_some();
    let is_given = torques.any(|channel| match channel.delay {
        Some(Delay::Known(_)) => !is_declared,
        Some(Delay::Estimate) => true,
        None => false,
    });
    if is_given {
        TorquesTiming::Given
    } else {
        TorquesTiming::Tested
    }
}

impl Refinery<'_> {
    /// Returns the timing of greatest likelihood at the end of a rung, that no other effect explains better and that
    /// hold-out does not contradict.
    ///
    /// # Errors
    ///
    /// [`PassError`] if the filter of positions does not fit a log.
    pub(super) fn retiming(
        &self,
        (rung, end): (Rung, &End),
        experiment: &Experiment,
    ) -> Result<Option<Wanted>, PassError> {
        if !end.refined.converged() {
            return Ok(None);
        }
        let delays = self.moved_delays(end);
        let is_auto = self.reading.settings().laws == Laws::Auto;
        let sharpness = if is_auto {
            sharpness(self.reading.model(), end)
        } else {
            Vec::new()
        };
        let torques = self.torques_delay(end, &sharpness);
        let mut torques = torques.filter(|_| is_auto);
        if torques.is_some() {
            let undeclared = self.undeclared(rung, end, experiment)?;
            torques = torques.filter(|_| {
                (undeclared.iter()).any(|undeclared| undeclared.found.kind == Kind::Timing)
            });
        }
        let wanted = torques.is_some() || delays.is_some() || !sharpness.is_empty();
        Ok(wanted.then_some(Wanted {
            torques,
            delays,
            sharpness,
        }))
    }

    /// Returns the delays of all channels if one that is estimated differs clearly from that of the regression and the equations do
    /// not contradict it. The search finds a late link less what viscous friction of the motor resembles.
    fn moved_delays(&self, end: &End) -> Option<Vec<f64>> {
        let period = self.excerpt.period();
        let delays = end.refined.channels.delays.iter();
        let has_moved = delays.filter(|delay| delay.estimated).any(|delay| {
            let by = (delay.assumed - self.reading.delays()[delay.channel]).abs();
            by > CERTAIN_SIGMAS * delay.standard_error && by > LEAST_MOVE_SAMPLES * period
        });
        has_moved.then_some(())?;
        let gain = DelayGain::between(self.excerpt, self.reading, &end.delays)?;
        (gain.with < (1.0 + OBJECTION) * gain.without).then(|| end.delays.clone())
    }

    /// - `sharpness`: of Coulomb friction by joint, with which hold-out compares.
    fn torques_delay(&self, end: &End, sharpness: &[(usize, f64)]) -> Option<TorquesDelay> {
        let delay = end.refined.channels.torques_delay.as_ref()?;
        let period = self.excerpt.period();
        let is_open = self.start.torques == TorquesTiming::Tested
            && self.reading.channels().torque_hold.is_none();
        let is_likely =
            is_certain(delay, period) && delay.correction.abs() < LONGEST_SAMPLES * period;
        if !(is_open && is_likely) {
            return None;
        }
        let reading = self
            .reading
            .with_model(sharpened(self.reading.model(), sharpness));
        let by = delay.correction;
        let gain = DelayGain::between(self.excerpt, &reading, &delayed(&reading, by))?;
        let allowed = if by.abs() < SMEARED_SAMPLES * period {
            OBJECTION
        } else {
            0.0
        };
        (gain.with < (1.0 + allowed) * gain.without).then_some(TorquesDelay {
            by,
            delay: delay.value(),
            standard_error: delay.standard_error,
            gain,
        })
    }
}

/// Returns whether a correction of the delay of all torques is significant.
fn is_certain(update: &ChannelUpdate, period: f64) -> bool {
    update.significance() > CERTAIN_SIGMAS && update.correction.abs() > MIN_DELAY_SAMPLES * period
}

/// Reports that the torques of a log act at another time than the description states.
pub(super) fn contradicted(
    reading: &Reading,
    excerpt: &Excerpt,
    refined: &Refined,
) -> Option<Finding> {
    let hold = reading.channels().torque_hold?;
    let period = excerpt.period();
    let delay = (refined.channels.torques_delay.as_ref())
        .filter(|delay| !delay.estimated && is_certain(delay, period))?;
    let acts = 0.5 * period - hold.delay(period) - delay.assumed;
    let gain = DelayGain::between(excerpt, reading, &delayed(reading, delay.correction));
    let held_out = gain.map_or_else(String::new, |gain| {
        format!(
            "; the held-out error of the filtered torque goes {}",
            gain.words()
        )
    });
    let likelihood = -refined.search.loss;
    let text = format!(
        "[log] says that the motor torques act on average {} their time stamps ({}); by likelihood they act {} them \
         (standard error {:.3} ms). The log-likelihood is {likelihood:.0} as declared and {:.0} with this timing{held_out}",
        when(acts),
        hold.words(),
        when(acts - delay.correction),
        in_ms(delay.standard_error),
        likelihood + 0.5 * delay.significance().powi(2),
    );
    let remedy = "correct torque and controller_period_s in [log]; if the log has a torque one period of the controller late, \
                  give this period as delay_s of each torque; or remove both, then sprung finds the timing";
    Some(Finding::new(
        Severity::Warning,
        "torque-timing-contradicted",
        text,
        remedy,
    ))
}

/// Returns a time relative to a time stamp as words: `0.500 ms after`.
fn when(seconds: f64) -> String {
    let side = if seconds < 0.0 { "before" } else { "after" };
    format!("{:.3} ms {side}", in_ms(seconds.abs()))
}

/// Returns a model with another sharpness of Coulomb friction of some joints.
fn sharpened(model: &Model, sharpness: &[(usize, f64)]) -> Model {
    let mut changed = model.clone();
    for &(joint, value) in sharpness {
        changed.set_scale(joint, Scale::Sharpness, value);
    }
    changed
}

/// Returns the delays of all channels with a further one of all torques, s.
fn delayed(reading: &Reading, by: f64) -> Vec<f64> {
    let channels = &reading.channels().all;
    (channels.iter().zip(reading.delays()))
        .map(|(channel, delay)| match channel.quantity {
            Quantity::MotorTorque => delay + by,
            _ => *delay,
        })
        .collect()
}

/// Returns the sharpness of the joints in which it differs clearly from that of the model.
fn sharpness(model: &Model, end: &End) -> Vec<(usize, f64)> {
    let differs = |joint: usize, value: f64, error: f64| {
        let change = (value / model.sharpness(joint)).ln().abs();
        change > LEAST_CHANGE_OF_SHARPNESS && change > CERTAIN_SIGMAS * error / value
    };
    (end.refined.scales.iter())
        .filter(|scale| scale.scale == Scale::Sharpness)
        .filter(|scale| differs(scale.joint, scale.value, scale.standard_error))
        .map(|scale| (scale.joint, scale.value))
        .collect()
}
