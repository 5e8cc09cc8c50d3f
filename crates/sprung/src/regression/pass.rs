//! One pass over logs: reads their blocks and returns a reduced system.

use std::sync::Arc;

use sprung_core::filter::FilterError;

use super::reading::Reading;
use super::reduction::Reduction;
use super::system::System;
use crate::description::{Cutoff, Identify};
use crate::finding::Severity;
use crate::log::{LogBlock, LogError, LogReader, LogSource, Summary, Timing, rounded, time_unit};
use crate::model::Model;
use crate::numbers::Shown;
use crate::preprocess::{Aligner, Butterworth, FilterDesignError, RawBlock, SignalBlock, Smoother};
use crate::progress::{Listener, Phase, Stopped};

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
}

impl Observer for () {}

impl<A: Observer, B: Observer> Observer for (A, B) {
    fn restart(&mut self, why: Restart) {
        self.0.restart(why);
        self.1.restart(why);
    }

    fn raw(&mut self, period: f64, samples: &RawBlock) {
        self.0.raw(period, samples);
        self.1.raw(period, samples);
    }
}

/// Smoothed signals of one block, ready for the regression.
#[derive(Clone, Debug, Default)]
struct Piece {
    // Whether this is the first piece of a log or of a segment behind a gap.
    begins: bool,
    // Change of the parameters by a known payload, \[p\].
    carried: Option<Arc<[f64]>>,
    period: f64,
    signals: SignalBlock,
}

/// Aligns and smooths the blocks of a log.
#[derive(Clone, Debug)]
struct Preparation {
    reading: Reading,
    period: f64,
    filter: Butterworth,
    needed: usize,
    aligner: Aligner,
    smoother: Smoother,
    raw: RawBlock,
    part: LogBlock,
    begins: bool,
    carried: Option<Arc<[f64]>>,
    in_segment: u64,
    // Samples in segments that are too short for the filter.
    lost: u64,
    used: u64,
}

impl Preparation {
    /// - `period`: T of the log, s.
    /// - `later`: offset that is added to the log's time, s.
    fn new(reading: &Reading, period: f64, [begin, later]: [f64; 2]) -> Result<Self, PassError> {
        let settings = reading.settings();
        let filter = Butterworth::new(
            settings.position_filter_order,
            reading.position_cutoff_hz(),
            period,
        )?;
        if settings.filter_cutoff_rad_per_s * period > 1.0 {
            return Err(PassError::TooFast {
                cutoff: settings.filter_cutoff_rad_per_s,
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

    /// Processes the next block and appends its finished pieces to `out`.
    fn push(&mut self, block: &LogBlock, observer: &mut impl Observer, out: &mut Vec<Piece>) {
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
        out: &mut Vec<Piece>,
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
        let mut piece = self.piece();
        self.smoother.push(&self.raw, &mut piece.signals);
        self.hand_on(piece, out);
    }

    /// Ends a segment; the filters restart with the next segment.
    fn end(&mut self, next: Restart, out: &mut Vec<Piece>) {
        let model = self.reading.model();
        let fresh = smoother(model, &self.filter, self.period).behind_gap();
        let mut piece = self.piece();
        let ended = std::mem::replace(&mut self.smoother, fresh);
        let finished = match next {
            Restart::Begin => ended.finish(&mut piece.signals),
            Restart::Gap => ended.finish_at_gap(&mut piece.signals),
        };
        if finished {
            self.hand_on(piece, out);
            self.used += self.in_segment;
        } else {
            self.lost += self.in_segment;
        }
        self.aligner = aligner(&self.reading, self.period);
        self.begins = true;
        self.in_segment = 0;
    }

    fn piece(&self) -> Piece {
        Piece {
            begins: self.begins,
            carried: self.carried.clone(),
            period: self.period,
            signals: SignalBlock::new(self.reading.model().joint_count()),
        }
    }

    fn hand_on(&mut self, piece: Piece, out: &mut Vec<Piece>) {
        if !piece.signals.is_empty() {
            self.begins = false;
            out.push(piece);
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

/// Folds pieces into a reduction.
fn reduce(
    reduction: &mut Reduction,
    settings: &Identify,
    pieces: &[Piece],
) -> Result<(), PassError> {
    for piece in pieces {
        if piece.begins {
            reduction.restart();
            reduction.carry(piece.carried.as_deref());
        }
        reduction
            .push(
                &piece.signals,
                settings.filter_cutoff_rad_per_s,
                piece.period,
                settings.discretization,
            )
            .map_err(PassError::FilterPair)?;
    }
    Ok(())
}

/// Reduces signals in memory; returns `None` if there are no samples.
///
/// - `period`: of the signals, s; `stretches`: as [`signals`] returns them.
/// - `empty`: reduces the wanted rows and probes.
///
/// # Errors
///
/// [`PassError`] if the filter pair does not fit the period.
pub(crate) fn reduce_signals(
    reading: &Reading,
    period: f64,
    stretches: &[SignalBlock],
    empty: Reduction,
) -> Result<Option<System>, PassError> {
    let settings = reading.settings();
    let samples: u64 = stretches.iter().map(|own| own.len() as u64).sum();
    let mut reduction = empty
        .weighted(reading.weights())
        .with_start(settings.initial_momentum)
        .with_samples(samples);
    for stretch in stretches {
        reduction.restart();
        let cutoff = settings.filter_cutoff_rad_per_s;
        (reduction.push(stretch, cutoff, period, settings.discretization))
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

/// Returns the signals of blocks as [`signals`], and hands their samples to an observer before they are
/// filtered.
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
    let mut pieces = Vec::new();
    for block in blocks {
        preparation.push(block, observer, &mut pieces);
    }
    preparation.end(Restart::Begin, &mut pieces);
    let mut stretches: Vec<SignalBlock> = Vec::new();
    for piece in pieces {
        match stretches.last_mut().filter(|_| !piece.begins) {
            Some(stretch) => stretch.append(piece.signals),
            None => stretches.push(piece.signals),
        }
    }
    Ok(stretches)
}

fn longest_delay(delays: &[f64]) -> f64 {
    let spread = |pick: fn(f64, f64) -> f64| delays.iter().copied().fold(0.0, pick);
    spread(f64::max) - spread(f64::min)
}

/// Result of a pass over logs.
#[derive(Clone, Debug)]
pub(crate) struct Passed {
    /// The reduced system of all logs.
    pub system: System,
    /// Figures of each log.
    pub logs: Vec<LogFigures>,
    /// First and last time of each log on their common time axis, s.
    pub spans: Vec<[f64; 2]>,
}

/// Figures of one log.
#[derive(Clone, Debug)]
pub struct LogFigures {
    /// Figures of the columns.
    pub summary: Summary,
    /// Figures of the time stamps and gaps.
    pub timing: Timing,
    /// Samples in segments that are too short for the filters.
    pub lost: u64,
    /// Name in the file of the column of each channel, \[channels\].
    pub names: Vec<String>,
}

/// Reads the logs of one robot once, block by block, and reduces them together.
///
/// The system has one time axis, on which the logs follow one another.
///
/// If a thread is free, it reads and smooths the next block while the last one is reduced.
///
/// - `progress`: receives the number of samples read so far, as part of `phase`.
///
/// # Errors
///
/// [`PassError`] if a log is faulty or too short, or if it does not fit the filters.
pub(crate) fn read_through(
    reading: &Reading,
    sources: &mut [LogSource<'_>],
    observer: &mut impl Observer,
    phase: Phase,
    progress: &mut dyn Listener,
) -> Result<Passed, PassError> {
    let mut reduction = Reduction::new(reading.model())
        .weighted(reading.weights())
        .with_start(reading.settings().initial_momentum);
    let mut logs = Vec::new();
    let mut spans = Vec::new();
    let mut before = 0;
    let mut ready: Vec<Piece> = Vec::new();
    let mut ended: Option<f64> = None;
    let count = sources.len();
    for (source, number) in sources.iter_mut().zip(1..) {
        let later_logs = count - number;
        let mut log = source.open(reading.channels())?;
        let mut block = LogBlock::new(reading.channels().all.len());
        let mut begin = || log.read(&mut block);
        let mut fold = || reduce(&mut reduction, reading.settings(), &ready);
        let (begun, folded) = rayon::join(&mut begin, &mut fold);
        folded?;
        begun?;
        ready.clear();
        let period = log.timing().period;
        // Each log continues at the end of the previous log, independent of its own time stamps.
        let first = block.time.first().copied().unwrap_or_default();
        let later = ended.map_or(0.0, |end| end + period - first);
        let mut preparation = Preparation::new(reading, period, [first, later])?;
        preparation.carried = (source.payload())
            .and_then(|payload| reading.model().change_by_payload(payload))
            .map(Into::into);
        let mut summary = Summary::new(reading.channels());
        observer.restart(Restart::Begin);
        while !block.is_empty() {
            let mut next = Vec::new();
            let mut prepare = || -> Result<(), PassError> {
                summary.take(&block);
                preparation.push(&block, observer, &mut next);
                let done = before + log.timing().recorded;
                progress.tell(phase, done, log.expected_of_all(before, later_logs))?;
                log.read(&mut block)?;
                Ok(())
            };
            let mut fold = || reduce(&mut reduction, reading.settings(), &ready);
            let (prepared, folded) = rayon::join(&mut prepare, &mut fold);
            folded?;
            prepared?;
            ready = next;
        }
        preparation.end(Restart::Begin, &mut ready);
        if preparation.used == 0 {
            return Err(too_short(source, reading, &preparation, &log).into());
        }
        before += log.timing().recorded;
        let span = [first + later, first + later + log.timing().duration];
        ended = Some(span[1]);
        logs.push(LogFigures {
            summary,
            timing: log.timing(),
            lost: preparation.lost,
            names: log.names().to_vec(),
        });
        spans.push(span);
    }
    reduce(&mut reduction, reading.settings(), &ready)?;
    Ok(Passed {
        system: reduction.finish(),
        logs,
        spans,
    })
}

fn too_short(
    source: &LogSource<'_>,
    reading: &Reading,
    preparation: &Preparation,
    log: &LogReader,
) -> LogError {
    let gaps = match log.timing().gaps.count {
        0 => "",
        _ => ", between two gaps",
    };
    let label = source.label();
    // If the unit of the time is wrong, the filters seem to need billions of samples.
    let unit = time_unit(&label, reading.channels(), log.timing().period);
    if let Some(finding) = unit.filter(|finding| finding.severity == Severity::Error) {
        let line = finding.setting.unwrap_or(finding.remedy);
        return LogError::Implausible {
            message: format!(
                "{} ({}); in the experiment file: {line}",
                finding.text, finding.code
            ),
        };
    }
    let delay = longest_delay(reading.delays());
    let delays = if delay > 0.0 {
        format!(", and delays take {} s", rounded(delay))
    } else {
        String::new()
    };
    let chosen = match reading.settings().position_cutoff_hz {
        Cutoff::Fixed(_) => "",
        Cutoff::Auto => {
            ". sprung chose this cut-off from these samples and may choose another for a longer log; record \
             several periods of the motion"
        }
    };
    LogError::TooShort {
        file: label,
        found: log.timing().recorded,
        needed: preparation.needed as u64,
        why: format!(
            "three periods of position_cutoff_hz = {} pad each end of the zero-phase filter{delays}{gaps}{chosen}",
            rounded(reading.position_cutoff_hz()),
        ),
    }
}
