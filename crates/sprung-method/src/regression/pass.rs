//! The stages between the blocks of a log and its regression: aligns, smooths and folds.

use std::sync::Arc;

use sprung_core::filter::FilterError;

use super::reading::Reading;
use super::reduction::Reduction;
use super::system::System;
use crate::log::{LogBlock, LogError};
use crate::model::Model;
use crate::numbers::Shown;
use crate::preprocess::{Aligner, Butterworth, FilterDesignError, RawBlock, SignalBlock, Smoother};
use crate::progress::Stopped;

/// Errors of a pass over logs.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PassError {
    /// The position filter does not fit the log.
    #[error(transparent)]
    FilterDesign(#[from] FilterDesignError),
    /// The filter pair is too fast for the log.
    #[error(
        "filter_cutoff_rad_per_s = {} is too fast for {rate:.6} samples per second; choose it \
         below the rate, 5 to 100 suits most robots{}",
        Shown(*cutoff),
        if *rate < 10.0 { ", or name the column under time_ms if it holds milliseconds" } else { "" }
    )]
    TooFast {
        /// λ, rad/s.
        cutoff: f64,
        /// Sampling rate, Hz.
        rate: f64,
    },
    /// The filter pair is invalid.
    #[error("{0}")]
    FilterPair(FilterError),
    /// The log cannot be read or is faulty.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The caller stopped the pass.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// Reason for a restart of the filters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Restart {
    /// A log begins.
    Begin,
    /// Samples are missing.
    Gap,
}

/// Callbacks of a pass; the default methods do nothing.
pub(crate) trait Observer: Send {
    /// Called when another log begins or a log continues after a gap.
    fn restart(&mut self, _why: Restart) {}

    /// Called with the samples before they are filtered.
    ///
    /// - `period`: T, s.
    fn raw(&mut self, _period: f64, _samples: &RawBlock) {}

    /// Returns an observer of one log alone, which may process its log in parallel to others;
    /// `None` if one observer needs the logs in sequence.
    fn of_one_log(&self) -> Option<Self>
    where
        Self: Sized,
    {
        None
    }

    /// Takes the result of an observer of the next log.
    fn join(&mut self, _next: Self)
    where
        Self: Sized,
    {
    }
}

impl Observer for () {
    fn of_one_log(&self) -> Option<Self> {
        Some(())
    }
}

impl<A: Observer, B: Observer> Observer for (A, B) {
    fn restart(&mut self, why: Restart) {
        self.0.restart(why);
        self.1.restart(why);
    }

    fn raw(&mut self, period: f64, samples: &RawBlock) {
        self.0.raw(period, samples);
        self.1.raw(period, samples);
    }

    fn of_one_log(&self) -> Option<Self> {
        Some((self.0.of_one_log()?, self.1.of_one_log()?))
    }

    fn join(&mut self, next: Self) {
        self.0.join(next.0);
        self.1.join(next.1);
    }
}

/// Smoothed signals of one block, ready for the regression.
#[derive(Clone, Debug, Default)]
pub(super) struct SmoothedBlock {
    // Whether this is the first block of a log or of a segment after a gap.
    begins: bool,
    // Change of the parameters by a known payload, \[p\].
    carried: Option<Arc<[f64]>>,
    period: f64,
    signals: SignalBlock,
}

/// Aligns and smooths the blocks of a log.
#[derive(Clone, Debug)]
pub(super) struct Preparation {
    reading: Reading,
    period: f64,
    filter: Butterworth,
    pub(super) needed: usize,
    aligner: Aligner,
    smoother: Smoother,
    raw: RawBlock,
    part: LogBlock,
    begins: bool,
    pub(super) carried: Option<Arc<[f64]>>,
    in_segment: u64,
    // Samples in segments that are too short for the filter.
    pub(super) lost: u64,
    pub(super) used: u64,
}

impl Preparation {
    /// - `period`: T of the log, s.
    /// - `later`: offset that is added to the log's time, s.
    pub(super) fn new(
        reading: &Reading,
        period: f64,
        [begin, later]: [f64; 2],
    ) -> Result<Self, PassError> {
        let settings = reading.settings();
        let filter = Butterworth::new(
            settings.position_filter_order,
            reading.position_cutoff_hz(),
            period,
        )?;
        if reading.filter_cutoff() * period > 1.0 {
            return Err(PassError::TooFast {
                cutoff: reading.filter_cutoff(),
                rate: 1.0 / period,
            });
        }
        let aligner = aligner(reading, period);
        Ok(Self {
            reading: reading.clone(),
            period,
            // The filter's padding, one sample beyond it, and two samples for the central
            // difference.
            needed: filter.padding() + aligner.lost() + 3,
            aligner,
            smoother: smoother(reading.model(), &filter, period),
            filter,
            raw: RawBlock {
                later,
                begin,
                ..RawBlock::new(reading.model().joint_count())
            },
            part: LogBlock::new(reading.channels().all.len()),
            begins: true,
            carried: None,
            in_segment: 0,
            lost: 0,
            used: 0,
        })
    }

    /// Processes the next block and appends its smoothed blocks to `out`.
    pub(super) fn push(
        &mut self,
        block: &LogBlock,
        observer: &mut impl Observer,
        out: &mut Vec<SmoothedBlock>,
    ) {
        let mut from = 0;
        for &gap in &block.gaps {
            self.feed(block, from..gap, observer, out);
            self.end(Restart::Gap, out);
            observer.restart(Restart::Gap);
            from = gap;
        }
        self.feed(block, from..block.len(), observer, out);
    }

    fn feed(
        &mut self,
        block: &LogBlock,
        part: std::ops::Range<usize>,
        observer: &mut impl Observer,
        out: &mut Vec<SmoothedBlock>,
    ) {
        if part.is_empty() {
            return;
        }
        self.in_segment += part.len() as u64;
        self.raw.clear();
        if part.len() == block.len() {
            self.aligner.push(block, &mut self.raw);
        } else {
            self.part.clear();
            self.part.extend(block, part);
            self.aligner.push(&self.part, &mut self.raw);
        }
        observer.raw(self.period, &self.raw);
        let mut smoothed = self.next_smoothed();
        self.smoother.push(&self.raw, &mut smoothed.signals);
        self.hand_on(smoothed, out);
    }

    /// Ends a segment; the filters restart with the next segment.
    pub(super) fn end(&mut self, next: Restart, out: &mut Vec<SmoothedBlock>) {
        let model = self.reading.model();
        let fresh = smoother(model, &self.filter, self.period).behind_gap();
        let mut smoothed = self.next_smoothed();
        let ended = std::mem::replace(&mut self.smoother, fresh);
        let finished = match next {
            Restart::Begin => ended.finish(&mut smoothed.signals),
            Restart::Gap => ended.finish_at_gap(&mut smoothed.signals),
        };
        if finished {
            self.hand_on(smoothed, out);
            self.used += self.in_segment;
        } else {
            self.lost += self.in_segment;
        }
        self.aligner = aligner(&self.reading, self.period);
        self.begins = true;
        self.in_segment = 0;
    }

    fn next_smoothed(&self) -> SmoothedBlock {
        SmoothedBlock {
            begins: self.begins,
            carried: self.carried.clone(),
            period: self.period,
            signals: SignalBlock::new(self.reading.model().joint_count()),
        }
    }

    fn hand_on(&mut self, smoothed: SmoothedBlock, out: &mut Vec<SmoothedBlock>) {
        if !smoothed.signals.is_empty() {
            self.begins = false;
            out.push(smoothed);
        }
    }
}

/// Returns the smallest number of samples between two gaps that the filters accept; `None` if the
/// position filter does not fit the log.
///
/// - `period`: T, s.
#[must_use]
pub(crate) fn shortest_segment(reading: &Reading, period: f64) -> Option<u64> {
    let order = reading.settings().position_filter_order;
    let filter = Butterworth::new(order, reading.position_cutoff_hz(), period).ok()?;
    let aligner = aligner(reading, period);
    // The filter's padding and one sample beyond it.
    Some((filter.padding() + aligner.lost() + 1) as u64)
}

fn aligner(reading: &Reading, period: f64) -> Aligner {
    let (channels, delays) = (reading.channels(), reading.delays());
    Aligner::new(channels, delays, reading.compliances(), period)
}

fn smoother(model: &Model, filter: &Butterworth, period: f64) -> Smoother {
    let flexible: Vec<bool> = (0..model.joint_count())
        .map(|joint| model.is_flexible(joint))
        .collect();
    Smoother::new(filter, &flexible, period)
}

/// Folds smoothed blocks into a reduction.
pub(super) fn reduce(
    reduction: &mut Reduction,
    reading: &Reading,
    blocks: &[SmoothedBlock],
) -> Result<(), PassError> {
    let discretization = reading.settings().discretization;
    for smoothed in blocks {
        if smoothed.begins {
            reduction.restart();
            reduction.carry(smoothed.carried.as_deref());
        }
        reduction
            .push(
                &smoothed.signals,
                reading.filter_cutoff(),
                smoothed.period,
                discretization,
            )
            .map_err(PassError::FilterPair)?;
    }
    Ok(())
}

/// Reduces signals in memory; returns `None` if there are no samples.
///
/// - `period`: of the signals, s; `segments`: as [`signals`] returns them.
/// - `empty`: reduces the wanted rows and probes.
///
/// # Errors
///
/// [`PassError`] if the filter pair does not fit the period.
pub(crate) fn reduce_signals(
    reading: &Reading,
    period: f64,
    segments: &[SignalBlock],
    empty: Reduction,
) -> Result<Option<System>, PassError> {
    let settings = reading.settings();
    let samples: u64 = segments.iter().map(|segment| segment.len() as u64).sum();
    let mut reduction = empty.weighted(reading.weights()).with_samples(samples);
    for segment in segments {
        reduction.restart();
        let cutoff = reading.filter_cutoff();
        (reduction.push(segment, cutoff, period, settings.discretization))
            .map_err(PassError::FilterPair)?;
    }
    Ok((samples > 0).then(|| reduction.finish()))
}

/// Returns the signals of blocks in memory, one block per segment that is long enough for the
/// filters.
///
/// - `period`: T, s.
///
/// # Errors
///
/// [`PassError`] if a filter does not fit the period.
pub fn signals(
    reading: &Reading,
    period: f64,
    blocks: &[LogBlock],
) -> Result<Vec<SignalBlock>, PassError> {
    observed_signals(reading, period, blocks, &mut ())
}

/// Returns the signals of blocks as [`signals`], and passes their samples to an observer before they are filtered.
///
/// # Errors
///
/// The errors of [`signals`].
pub(crate) fn observed_signals(
    reading: &Reading,
    period: f64,
    blocks: &[LogBlock],
    observer: &mut impl Observer,
) -> Result<Vec<SignalBlock>, PassError> {
    let begin = (blocks.first()).and_then(|block| block.time.first());
    let begin = begin.copied().unwrap_or_default();
    let mut preparation = Preparation::new(reading, period, [begin, 0.0])?;
    let mut all = Vec::new();
    for block in blocks {
        preparation.push(block, observer, &mut all);
    }
    preparation.end(Restart::Begin, &mut all);
    let samples: usize = all.iter().map(|smoothed| smoothed.signals.len()).sum();
    let is_whole = all.iter().skip(1).all(|smoothed| !smoothed.begins);
    let mut segments: Vec<SignalBlock> = Vec::new();
    for mut smoothed in all {
        if let Some(segment) = segments.last_mut().filter(|_| !smoothed.begins) {
            segment.append(smoothed.signals);
            continue;
        }
        if is_whole {
            smoothed.signals.reserve(samples - smoothed.signals.len());
        }
        segments.push(smoothed.signals);
    }
    Ok(segments)
}
