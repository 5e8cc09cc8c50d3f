//! The refinements of a search for late channels: on one segment of the first log, as long as their
//! work allows.

use sprung_core::friction::Law;
use sprung_core::parameters::JointParameter;

use super::refined::Refined;
use crate::description::Delay;
use crate::estimate::errors::IdentifyError;
use crate::estimate::estimators::prediction_error::{
    Before, DelaySearch, Refinements, Timing, prediction_error,
};
use crate::fit::{Fitted, fit};
use crate::log::{LogSource, Signal};
use crate::model::Model;
use crate::prepare::{DelayGain, Excerpt, Prepared, estimate_delays};
use crate::progress::{Answer, Listener, Progress};
use crate::regression::{PassError, Reading};

/// Maximum work of a refinement: samples times rows times rows. It allows the 10 s of the demo, and
/// 0.8 s of seven flexible joints at 1 kHz.
const MAX_WORK: usize = 160_000;

/// Maximum number of runs of the filter in a refinement. More are needed only where no rung of the
/// ladder follows the log, because another channel is late.
const MAX_RUNS: u64 = 40;

/// A delay by the torque row of a joint.
pub(super) struct RowDelay {
    pub(super) channel: usize,
    /// Delay, s.
    pub(super) delay: f64,
    /// Residual of the torque with the delay over that without.
    pub(super) left: f64,
}

/// A listener that ends a refinement after [`MAX_RUNS`].
struct Limited<'a> {
    listener: &'a mut dyn Listener,
    runs: u64,
}

impl Listener for Limited<'_> {
    fn hear(&mut self, progress: Progress) -> Answer {
        self.runs += 1;
        match self.listener.hear(progress) {
            Answer::GoOn if self.is_over() => Answer::Stop,
            answer @ (Answer::GoOn | Answer::Stop) => answer,
        }
    }
}

impl Limited<'_> {
    fn is_over(&self) -> bool {
        self.runs > MAX_RUNS
    }
}

/// The segment of the first log on which the search refines, with the delays that are known.
pub(super) struct SearchedSegment<'a, 's> {
    prepared: &'a Prepared,
    /// Settings with the known delays.
    reading: Reading,
    source: LogSource<'s>,
    samples: Excerpt,
}

impl<'a, 's> SearchedSegment<'a, 's> {
    /// Returns the segment in which the joints jerk most; `None` if gaps leave none.
    pub(super) fn new(prepared: &'a Prepared, source: &'s mut LogSource<'_>) -> Option<Self> {
        let (reading, excerpt) = (prepared.reading(), prepared.excerpt());
        let limit = MAX_WORK / reading.model().coordinates().pow(2);
        let samples = excerpt.busiest(reading.channels(), limit)?;
        let of = |excerpt: &Excerpt| -> Option<[f64; 2]> {
            let mut blocks = excerpt.blocks().iter().filter(|block| !block.is_empty());
            let first = blocks.clone().next()?.time.first().copied()?;
            Some([first, blocks.next_back()?.time.last().copied()?])
        };
        let ([begin, _], [first, last]) = (of(excerpt)?, of(&samples)?);
        // A window must not change the beginning of a log that it does not cut.
        let from = (begin < first).then_some(first);
        Some(Self {
            reading: reading.clone(),
            source: source.narrowed(from, last + 0.5 * samples.period()),
            samples,
            prepared,
        })
    }

    pub(super) fn reading(&self) -> &Reading {
        &self.reading
    }

    /// Returns the sampling period, s.
    pub(super) fn period(&self) -> f64 {
        self.samples.period()
    }

    /// Takes a delay as known from now on.
    pub(super) fn set_delay(&mut self, channel: usize, delay: f64) {
        self.reading = self.delayed(channel, delay, Delay::Known(delay));
    }

    fn delayed(&self, channel: usize, delay: f64, known: Delay) -> Reading {
        let mut channels = self.reading.channels().clone();
        channels.all[channel].delay = Some(known);
        let mut delays = self.reading.delays().to_vec();
        delays[channel] = delay;
        self.reading.with_channels(channels).with_delays(&delays)
    }

    /// Returns whether a delay does not raise the held-out error of the motor torques. An error of
    /// the model may fit better with a delay.
    pub(super) fn predicts(&self, channel: usize, delay: f64) -> bool {
        let reading = self.reading.without_weights();
        let gain = DelayGain::of(self.prepared.excerpt(), &reading, channel, delay);
        gain.is_none_or(|gain| !gain.is_higher())
    }

    /// Returns the delays of the channels of some joints by the torque rows, one channel at a time,
    /// as far as these rows determine them.
    pub(super) fn by_torque_rows(&self, joints: &[usize]) -> Vec<RowDelay> {
        let reading = self.reading.without_weights();
        let (channels, excerpt) = (reading.channels(), self.prepared.excerpt());
        let of_signal = |signal| {
            let telling = joints
                .iter()
                .filter_map(|&joint| channels.telling(signal, joint));
            estimate_delays(excerpt, &reading, &telling.collect::<Vec<_>>()).unwrap_or_default()
        };
        [Signal::Link, Signal::Motor, Signal::Torque]
            .into_iter()
            .flat_map(of_signal)
            .filter(|estimate| estimate.found)
            .map(|estimate| RowDelay {
                channel: estimate.channel,
                delay: estimate.delay,
                left: estimate.with.relative_residual / estimate.without.relative_residual,
            })
            .collect()
    }

    /// Refines with the known delays, and estimates the delay of at most one more channel.
    ///
    /// - `start`: the channel, and the delay from which the search starts, s.
    /// - `rungs`: number of rungs of the ladder to try.
    ///
    /// Returns a failed refinement if the segment is too short, or if the runs of the filter have
    /// reached their limit.
    pub(super) fn refined(
        &mut self,
        start: Option<(usize, f64)>,
        rungs: usize,
        progress: &mut dyn Listener,
    ) -> Result<Refined, IdentifyError> {
        let reading = match start {
            Some((channel, delay)) => self.delayed(channel, delay, Delay::Estimate),
            None => self.reading.clone(),
        };
        let (model, excerpt) = (reading.model(), self.prepared.excerpt());
        let fitted = (excerpt.reduce(&reading))
            .and_then(|system| fit(model, &system, reading.memory()))
            .filter(|fitted| fitted.theta.iter().all(|value| value.is_finite()));
        let (Some(mut fitted), Some(system)) = (fitted, self.samples.reduce(&reading)) else {
            return Ok(Refined::failed());
        };
        if self.samples.samples() < excerpt.samples() {
            hold_others(model, &mut fitted);
        }
        let before = Before {
            experiment: self.prepared.experiment(),
            excerpt,
            system: &system,
            search: Some(DelaySearch {
                samples: &self.samples,
                rungs,
            }),
            fitted: &fitted,
            possible: None,
            nominal: None,
            timing: Timing::Kept,
            about_logs: &[],
        };
        let sources = std::slice::from_mut(&mut self.source);
        let mut limited = Limited {
            listener: progress,
            runs: 0,
        };
        let found = match prediction_error(&reading, sources, before, &mut limited) {
            Err(PassError::Stopped(_)) if limited.is_over() => return Ok(Refined::failed()),
            found => found?,
        };
        let Refinements::Found(found) = found else {
            return Ok(Refined::failed());
        };
        let refinement = found.numbers.criterion.refinement();
        Ok(refinement.map_or_else(Refined::failed, |refinement| {
            Refined::of(refinement, excerpt.period())
        }))
    }
}

/// Lets the refinement of a short segment estimate only parameters that a delay changes. Bodies and
/// Coulomb friction keep their values of the whole excerpt, because a short motion does not
/// determine them.
fn hold_others(model: &Model, fitted: &mut Fitted) {
    for (parameter, free) in model.parameters().iter().zip(&mut fitted.identifiable) {
        *free &= (parameter.joint).is_some_and(|(kind, _)| {
            kind.is_vital() || matches!(kind, JointParameter::Friction(_, Law::Viscous))
        });
    }
}
