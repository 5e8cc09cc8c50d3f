//! Puts samples with arbitrary time stamps on an even grid.

use super::cycle::{Cycle, GAP_PERIODS, JITTER_LIMIT, LOOK_AHEAD_SAMPLES, refined, usual_step};
use super::evidence::{EVEN_STEP_PART, weigh};
use super::resample::{Resampler, SAME_TIME_PART};
use super::timing::{Jitter, Sampling, Timing};
use super::watch::Watch;
use crate::block::LogBlock;
use crate::error::{LogError, Place};
use crate::numbers::Shown;

/// Number of samples from which the period is found.
const LEARNING_SAMPLES: usize = 257;

/// Number of samples from which the sampling times of uneven samples are decided.
const DECIDING_SAMPLES: usize = 4096;

/// Puts samples on a uniform grid.
pub(crate) struct Grid {
    file: String,
    asked: Option<Sampling>,
    // Channels that show motion: index within the stream, and index among all channels.
    telling: Vec<(usize, usize)>,
    stage: Stage,
    // Samples that wait until their place on the grid is known.
    waiting: Waiting,
    // Stamp of the last sample taken, of the first, and of the last sample placed.
    last: Option<f64>,
    first: f64,
    placed: Option<f64>,
    // Place of the last placed sample, in periods since the segment began.
    at: f64,
    watch: Watch,
    resampler: Resampler,
    timing: Timing,
    steps: (u64, f64),
    ready: LogBlock,
}

/// Knowledge about the clock.
#[derive(Clone, Copy, Debug)]
enum Stage {
    Learning,
    /// All steps so far were even.
    Plain,
    Deciding,
    /// Samples were taken at the times of their stamps.
    Stamped,
    /// Samples were taken at ticks of a clock, `per` ticks per period.
    Ticks {
        clock: Cycle,
        per: f64,
        // Whether the stamps are close enough to the ticks to be used as times.
        near: bool,
    },
}

#[derive(Clone, Debug)]
struct Waiting {
    times: Vec<f64>,
    places: Vec<Place>,
    values: Vec<Vec<f64>>,
}

impl Grid {
    /// - `asked`: when samples were taken, if the experiment declares it.
    /// - `smooth`: for each channel of the stream, whether it is a position.
    /// - `channels`: indices of these channels among all.
    pub(crate) fn new(
        file: &str,
        asked: Option<Sampling>,
        smooth: &[bool],
        channels: &[usize],
    ) -> Self {
        // If a stream has no positions, its torques are used.
        let all = !smooth.contains(&true);
        let telling = (channels.iter().copied().enumerate())
            .filter(|&(index, _)| all || smooth[index])
            .collect();
        Self {
            file: file.to_owned(),
            asked,
            telling,
            stage: Stage::Learning,
            waiting: Waiting::new(smooth.len()),
            last: None,
            first: 0.0,
            placed: None,
            at: 0.0,
            watch: Watch::new(smooth.to_vec()),
            resampler: Resampler::new(smooth.to_vec()),
            timing: Timing::default(),
            steps: (0, 0.0),
            ready: LogBlock::new(smooth.len()),
        }
    }

    /// Returns the sampling of the part that was read.
    pub(crate) fn timing(&self) -> Timing {
        let (steps, squares) = self.steps;
        Timing {
            start: self.first,
            duration: self.last.unwrap_or_default() - self.first,
            jitter: Jitter {
                rms: (squares / steps.max(1) as f64).sqrt(),
                ..self.timing.jitter
            },
            interpolated: self.resampler.interpolated,
            ..self.timing
        }
    }

    /// Returns the number of samples that are ready.
    pub(crate) fn ready(&self) -> usize {
        self.ready.len()
    }

    /// Moves at most `limit` ready samples to the end of `out`.
    ///
    /// - `channels`: indices of this grid's channels in `out`.
    pub(crate) fn hand_on(&mut self, limit: usize, channels: &[usize], out: &mut LogBlock) {
        let count = limit.min(self.ready.len());
        let begin = out.len();
        out.time.extend(self.ready.time.drain(..count));
        for (column, &channel) in self.ready.values.iter_mut().zip(channels) {
            out.values[channel].extend(column.drain(..count));
        }
        let gaps = std::mem::take(&mut self.ready.gaps);
        for gap in gaps {
            if gap < count {
                out.gaps.push(begin + gap);
            } else {
                self.ready.gaps.push(gap - count);
            }
        }
    }

    /// Leaves out a sample that lacks a value.
    pub(crate) fn leave_out(&mut self, place: Place) {
        self.timing.lacking.add(1, place);
    }

    /// Takes the next sample.
    ///
    /// - `values`: one value per channel.
    ///
    /// # Errors
    ///
    /// [`LogError::TimeNotIncreasing`], or [`LogError::Format`] if the declared period contradicts
    /// the log.
    pub(crate) fn take(
        &mut self,
        place: Place,
        time: f64,
        values: impl Iterator<Item = f64> + Clone,
    ) -> Result<(), LogError> {
        self.timing.recorded += 1;
        match self.last {
            None => self.first = time,
            Some(before) if time > before => {}
            Some(before) if time < before => return Err(self.not_increasing(place, before, time)),
            Some(before) => {
                if !self.may_repeat() {
                    if !self.watch.same(values) {
                        return Err(self.not_increasing(place, before, time));
                    }
                    self.timing.repeated.add(1, place);
                    return Ok(());
                }
            }
        }
        self.watch.take(place, values.clone(), &mut self.timing);
        self.last = Some(time);
        if matches!(self.stage, Stage::Plain) {
            if self.plain(place, time, values.clone()) {
                return Ok(());
            }
            self.stage = Stage::Deciding;
        }
        if matches!(self.stage, Stage::Stamped) {
            self.stamped(place, time, values);
            return Ok(());
        }
        self.waiting.times.push(time);
        self.waiting.places.push(place);
        for (column, value) in self.waiting.values.iter_mut().zip(values) {
            column.push(value);
        }
        let count = self.waiting.times.len();
        match self.stage {
            Stage::Learning if count == LEARNING_SAMPLES => self.learn()?,
            Stage::Deciding if count == DECIDING_SAMPLES => self.decide(),
            Stage::Ticks { .. } if count >= DECIDING_SAMPLES => self.tick(false),
            Stage::Learning
            | Stage::Plain
            | Stage::Deciding
            | Stage::Stamped
            | Stage::Ticks { .. } => {}
        }
        Ok(())
    }

    /// Ends the log.
    ///
    /// # Errors
    ///
    /// [`LogError::TooShort`] for fewer than two samples, and the errors of [`take`](Self::take).
    pub(crate) fn finish(&mut self) -> Result<(), LogError> {
        if self.timing.recorded < 2 {
            return Err(LogError::TooShort {
                file: self.file.clone(),
                found: self.timing.recorded,
                needed: 2,
                why: match self.timing.lacking.count {
                    0 => "a sampling period is the time between two samples".to_owned(),
                    count => format!(
                        "{count} more samples have no value in some column, and nan = \"gap\" leaves them out; \
                         put columns with a clock of their own into a file with their own time"
                    ),
                },
            });
        }
        if matches!(self.stage, Stage::Learning) {
            self.learn()?;
        }
        if matches!(self.stage, Stage::Deciding) {
            self.decide();
        }
        self.tick(true);
        self.resampler.end(&mut self.ready);
        Ok(())
    }

    /// Returns whether samples may share one time stamp, because the declared sampling does not
    /// rely on exact stamps.
    fn may_repeat(&self) -> bool {
        matches!(self.asked, Some(Sampling::Even | Sampling::OnCycle(_)))
    }

    fn not_increasing(&self, place: Place, before: f64, after: f64) -> LogError {
        LogError::TimeNotIncreasing {
            file: self.file.clone(),
            place,
            before,
            after,
            remedy: if after < before {
                ""
            } else {
                "; if the samples are one period apart and the stamps rounded or late, set \
                 sampling = \"even\" in [log]"
            },
        }
    }

    fn learn(&mut self) -> Result<(), LogError> {
        let times = &self.waiting.times;
        let step = usual_step(times);
        if let Some(place) = self.waiting.places.get(1)
            && !(step > 0.0 && step.is_finite())
        {
            let last = times[times.len() - 1];
            return Err(self.not_increasing(*place, times[0], last));
        }
        self.timing.period = step;
        self.timing.sampling = Some(Sampling::Even);
        if let Some(Sampling::OnCycle(cycle)) = self.asked {
            self.stage = Stage::Deciding;
            if step < 0.5 * cycle {
                return Err(LogError::format(
                    &self.file,
                    format!(
                        " has samples {:.4} ms apart, but period_s = {} is longer; samples must be \
                         whole multiples of period_s apart",
                        1e3 * step,
                        Shown(cycle)
                    ),
                ));
            }
            self.decide();
            return Ok(());
        }
        let plain = |pair: &[f64]| whole(pair[1] - pair[0], step, self.tolerance()).is_some();
        if times.windows(2).all(plain) {
            self.stage = Stage::Plain;
            self.flush();
            return Ok(());
        }
        self.stage = Stage::Deciding;
        Ok(())
    }

    /// Returns the deviation of a step from whole periods that is accepted without further
    /// analysis, as a fraction of the period.
    fn tolerance(&self) -> f64 {
        match self.asked {
            Some(Sampling::AsStamped) => SAME_TIME_PART,
            _ => EVEN_STEP_PART,
        }
    }

    fn decide(&mut self) {
        let (times, period) = (&self.waiting.times, self.timing.period);
        // Samples that were placed already used this period, so it stays.
        let fixed = self.placed.is_some();
        let (evidence, told) = if self.asked.is_some() {
            (None, None)
        } else {
            let channels: Vec<(usize, &[f64])> = (self.telling.iter())
                .map(|&(index, channel)| (channel, self.waiting.values[index].as_slice()))
                .collect();
            let (evidence, told) = weigh(times, period, GAP_PERIODS, &channels);
            (Some(evidence), told)
        };
        let off = |pair: &[f64]| {
            let step = (pair[1] - pair[0]) / period;
            step < GAP_PERIODS && (step - step.round().max(1.0)).abs() > JITTER_LIMIT
        };
        let near = !times.windows(2).any(off);
        let sampling = self.asked.or(told).unwrap_or(if near {
            Sampling::Even
        } else {
            Sampling::AsStamped
        });
        let ticks = |clock: f64, per: f64, near: bool| Stage::Ticks {
            clock: match self.placed {
                Some(last) => Cycle::after(clock, last, self.at * per, times),
                None => Cycle::new(clock, times),
            },
            per,
            near,
        };
        let (stage, period) = match sampling {
            Sampling::AsStamped => (Stage::Stamped, period),
            Sampling::Even if near || fixed => (ticks(period, 1.0, near), period),
            Sampling::Even => {
                let period = refined(period, times);
                (ticks(period, 1.0, false), period)
            }
            Sampling::OnCycle(cycle) => {
                let per = (period / cycle).round().max(1.0);
                let cycle = if fixed { period / per } else { cycle };
                (ticks(cycle, per, false), cycle * per)
            }
        };
        self.stage = stage;
        self.timing.period = period;
        self.timing.sampling = Some(sampling);
        self.timing.evidence = evidence;
        self.flush();
    }

    /// Places the waiting samples.
    fn flush(&mut self) {
        if matches!(self.stage, Stage::Ticks { .. }) {
            self.tick(false);
            return;
        }
        let waiting = self.waiting.clone();
        self.waiting.let_go(waiting.times.len());
        for (i, &time) in waiting.times.iter().enumerate() {
            let values = waiting.values.iter().map(|column| column[i]);
            if matches!(self.stage, Stage::Plain) {
                self.plain(waiting.places[i], time, values);
            } else {
                self.stamped(waiting.places[i], time, values);
            }
        }
    }

    /// Places a sample whose step is a whole number of periods. Returns false if the step is not.
    fn plain(&mut self, place: Place, time: f64, values: impl Iterator<Item = f64>) -> bool {
        let Some(before) = self.placed else {
            self.put(place, time, 0.0, time, values);
            return true;
        };
        let Some(steps) = whole(time - before, self.timing.period, self.tolerance()) else {
            return false;
        };
        self.put(place, time, self.at + steps, time, values);
        true
    }

    fn stamped(&mut self, place: Place, time: f64, values: impl Iterator<Item = f64>) {
        let step = self.placed.map_or(0.0, |before| time - before);
        let at = self.at + step / self.timing.period;
        // Rounding errors must not accumulate, because samples would then seem uneven.
        let near = (at - at.round()).abs() <= SAME_TIME_PART;
        self.put(
            place,
            time,
            if near { at.round() } else { at },
            time,
            values,
        );
    }

    /// Places the waiting samples whose later stamps are known.
    fn tick(&mut self, ended: bool) {
        let Stage::Ticks {
            mut clock,
            per,
            near,
        } = self.stage
        else {
            return;
        };
        let channels = self.waiting.values.len();
        let waiting = std::mem::replace(&mut self.waiting, Waiting::new(channels));
        let count = waiting.times.len();
        let until = if ended {
            count
        } else {
            count.saturating_sub(LOOK_AHEAD_SAMPLES - 1)
        };
        for i in 0..until {
            let ahead = &waiting.times[i..count.min(i + LOOK_AHEAD_SAMPLES)];
            let at = match self.placed {
                None => {
                    clock.begin(ahead);
                    0.0
                }
                Some(_) => clock.next(ahead) / per,
            };
            if at - self.at >= GAP_PERIODS {
                clock.restart(ahead);
            }
            let time = if near { waiting.times[i] } else { clock.time() };
            let values = waiting.values.iter().map(|column| column[i]);
            self.put(waiting.places[i], waiting.times[i], at, time, values);
        }
        self.stage = Stage::Ticks { clock, per, near };
        self.waiting = waiting;
        self.waiting.let_go(until);
    }

    /// Passes a sample to the resampler.
    ///
    /// - `at`: its place, in periods since the segment began. A step of at least [`GAP_PERIODS`]
    ///   begins a new segment.
    fn put(
        &mut self,
        place: Place,
        stamp: f64,
        at: f64,
        time: f64,
        values: impl Iterator<Item = f64>,
    ) {
        let mut at = at;
        if let Some(before) = self.placed {
            let moved = at - self.at;
            if moved >= GAP_PERIODS {
                self.timing.gaps.count += 1;
                self.timing.gaps.duration += stamp - before - self.timing.period;
                self.resampler.end(&mut self.ready);
                self.ready.gaps.push(self.ready.len());
                at = 0.0;
            } else {
                let missing = (moved + JITTER_LIMIT).floor() - 1.0;
                self.timing.dropped.add(missing.max(0.0) as u64, place);
                let step = (stamp - before) / self.timing.period;
                let off = (step - step.round().max(1.0)).abs();
                self.timing.jitter.largest = self.timing.jitter.largest.max(off);
                self.steps.0 += 1;
                self.steps.1 += off * off;
            }
        }
        self.placed = Some(stamp);
        self.at = at;
        self.resampler.push(at, time, values, &mut self.ready);
    }
}

impl Waiting {
    fn new(channels: usize) -> Self {
        Self {
            times: Vec::new(),
            places: Vec::new(),
            values: vec![Vec::new(); channels],
        }
    }

    fn let_go(&mut self, count: usize) {
        self.times.drain(..count);
        self.places.drain(..count);
        for values in &mut self.values {
            values.drain(..count);
        }
    }
}

/// Returns the number of periods of a step, or `None` if the step is uneven. The number of a gap is
/// not rounded.
fn whole(step: f64, period: f64, tolerance: f64) -> Option<f64> {
    let periods = step / period;
    if periods >= GAP_PERIODS {
        return Some(periods);
    }
    let whole = periods.round().max(1.0);
    ((periods - whole).abs() <= tolerance).then_some(whole)
}
