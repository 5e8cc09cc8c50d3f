//! One pass over the logs of a robot: reads their blocks and returns a reduced system.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::joined::Joined;
use super::pass::{Observer, PassError, Preparation, Restart, SmoothedBlock, reduce};
use super::reading::Reading;
use super::reduction::Reduction;
use super::system::System;
use crate::description::Cutoff;
use crate::finding::Severity;
use crate::log::{
    LogBlock, LogError, LogReader, LogSource, Mended, Summary, Timing, rounded, time_unit,
};
use crate::progress::{Listener, Phase, Stopped};

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
pub(crate) struct LogFigures {
    /// Figures of the columns.
    pub summary: Summary,
    /// Figures of the time stamps and gaps.
    pub timing: Timing,
    /// Samples in segments that are too short for the filters.
    pub lost: u64,
    /// Name in the file of the column of each channel, \[channels\].
    pub names: Vec<String>,
    /// Corrected samples of each channel, \[channels\].
    pub mended: Vec<Mended>,
}

/// One log that was read.
struct ReadLog {
    system: System,
    figures: LogFigures,
    /// First and last time, s.
    span: [f64; 2],
}

/// Progress of a pass whose logs are read at the same time.
struct Shared<'a> {
    phase: Phase,
    heard: Mutex<Heard<'a>>,
    /// Index of the first log that failed so far.
    failed: AtomicUsize,
}

struct Heard<'a> {
    listener: &'a mut dyn Listener,
    /// Samples that were read from each log, and their expected number.
    logs: Vec<(u64, Option<u64>)>,
    stopped: bool,
}

impl Shared<'_> {
    /// Reports the read part of a log to the listener. Ends the log if an earlier log failed.
    fn tell(&self, index: usize, log: &LogReader) -> Result<(), Stopped> {
        if self.failed.load(Ordering::Relaxed) < index {
            return Err(Stopped);
        }
        let Ok(mut heard) = self.heard.lock() else {
            return Err(Stopped);
        };
        if heard.stopped {
            return Err(Stopped);
        }
        heard.logs[index] = (log.timing().recorded, log.expected());
        let done = heard.logs.iter().map(|(done, _)| done).sum();
        let begun = || heard.logs.iter().filter(|(done, _)| *done > 0);
        let expected: Option<u64> = begun().map(|(_, expected)| *expected).sum();
        // Later logs are assumed to be as long as these.
        let (all, count) = (heard.logs.len() as u64, begun().count().max(1) as u64);
        let total = expected.map(|begun| begun * all / count);
        let answer = heard.listener.tell(self.phase, done, total);
        heard.stopped = answer.is_err();
        answer
    }
}

/// Reads the logs of one robot once, block by block, and reduces them together.
///
/// The system has one time axis, on which the logs follow one another.
///
/// As many logs as there are threads are read and reduced at the same time, unless the observer needs them in sequence.
/// Each log has its own filters and its own factors, which are joined in the order of the logs, so the result does not
/// depend on the number of threads. If a thread is free, it reads and smooths the next block of a log while the last
/// one is reduced.
///
/// - `progress`: receives the number of samples read so far, as part of `phase`.
///
/// # Errors
///
/// [`PassError`] of the first log that is faulty or too short, or that does not fit the filters.
pub(crate) fn read_through<O: Observer>(
    reading: &Reading,
    sources: &mut [LogSource<'_>],
    observer: &mut O,
    phase: Phase,
    progress: &mut dyn Listener,
) -> Result<Passed, PassError> {
    let count = sources.len();
    let shared = Shared {
        phase,
        heard: Mutex::new(Heard {
            listener: progress,
            logs: vec![(0, None); count],
            stopped: false,
        }),
        failed: AtomicUsize::new(usize::MAX),
    };
    let mut read = AllRead::default();
    let at_once = match observer.of_one_log() {
        Some(_) if count > 1 => rayon::current_num_threads(),
        _ => 1,
    };
    for (sources, first) in sources.chunks_mut(at_once).zip((0..).step_by(at_once)) {
        let observers: Option<Vec<O>> = (sources.iter())
            .map(|_| observer.of_one_log().filter(|_| count > 1))
            .collect();
        let Some(observers) = observers else {
            let numbered = (first, &mut sources[0]);
            let end = read.end();
            let log = read_log(reading, numbered, (count, end), observer, &shared)?;
            read.add(log, end.is_some());
            continue;
        };
        let logs: Vec<(Result<ReadLog, PassError>, O)> = (sources.par_iter_mut())
            .zip(observers)
            .enumerate()
            .with_max_len(1)
            .map(|(at, (source, mut observer))| {
                let numbered = (first + at, source);
                let read = read_log(reading, numbered, (count, None), &mut observer, &shared);
                if read.is_err() {
                    shared.failed.fetch_min(first + at, Ordering::Relaxed);
                }
                (read, observer)
            })
            .collect();
        for (log, observed) in logs {
            read.add(log?, false);
            observer.join(observed);
        }
    }
    Ok(read.passed(reading))
}

/// The logs that were read so far.
#[derive(Default)]
struct AllRead {
    joined: Option<Joined>,
    figures: Vec<LogFigures>,
}

impl AllRead {
    /// Returns the end of the last log, s.
    fn end(&self) -> Option<f64> {
        Some(self.joined.as_ref()?.spans.last()?[1])
    }

    /// Appends the next log.
    ///
    /// - `follows`: whether its times follow those of the log before.
    fn add(&mut self, log: ReadLog, follows: bool) {
        let ReadLog {
            system,
            span,
            figures,
        } = log;
        match &mut self.joined {
            None => self.joined = Some(Joined::new(system, span)),
            Some(joined) if follows => joined.append_following(system, span),
            Some(joined) => joined.append(system, span, figures.timing.period),
        }
        self.figures.push(figures);
    }

    fn passed(self, reading: &Reading) -> Passed {
        let empty = || (Reduction::new(reading.model()).finish(), Vec::new());
        let (system, spans) = (self.joined).map_or_else(empty, |all| (all.system, all.spans));
        Passed {
            system,
            logs: self.figures,
            spans,
        }
    }
}

/// Reads one log and reduces it.
///
/// - `(index, source)`: its index and its source.
/// - `(count, end)`: the number of logs, and the end of the log before, s, which it follows; `None` to
///   keep the times of the log.
fn read_log(
    reading: &Reading,
    (index, source): (usize, &mut LogSource<'_>),
    (count, end): (usize, Option<f64>),
    observer: &mut impl Observer,
    shared: &Shared<'_>,
) -> Result<ReadLog, PassError> {
    let mut reduction = Reduction::new(reading.model())
        .among(count)
        .weighted(reading.weights());
    let mut log = source.open(reading.channels())?;
    let mut block = LogBlock::new(reading.channels().all.len());
    log.read(&mut block)?;
    let period = log.timing().period;
    let first = block.time.first().copied().unwrap_or_default();
    let later = end.map_or(0.0, |end| end + period - first);
    let mut preparation = Preparation::new(reading, period, [first, later])?;
    preparation.carried = (source.payload())
        .and_then(|payload| reading.model().change_by_payload(payload))
        .map(Into::into);
    let mut summary = Summary::new(reading.channels());
    let mut ready: Vec<SmoothedBlock> = Vec::new();
    observer.restart(Restart::Begin);
    while !block.is_empty() {
        let mut next = Vec::new();
        let mut prepare = || -> Result<(), PassError> {
            summary.take(&block);
            preparation.push(&block, observer, &mut next);
            shared.tell(index, &log)?;
            log.read(&mut block)?;
            Ok(())
        };
        let mut fold = || reduce(&mut reduction, reading, &ready);
        let (prepared, folded) = rayon::join(&mut prepare, &mut fold);
        folded?;
        prepared?;
        ready = next;
    }
    preparation.end(Restart::Begin, &mut ready);
    if preparation.used == 0 {
        return Err(too_short(source, reading, &preparation, &log).into());
    }
    reduce(&mut reduction, reading, &ready)?;
    Ok(ReadLog {
        system: reduction.finish(),
        span: [first + later, first + later + log.timing().duration],
        figures: LogFigures {
            summary,
            timing: log.timing(),
            lost: preparation.lost,
            names: log.names().to_vec(),
            mended: log.mended().to_vec(),
        },
    })
}

fn longest_delay(delays: &[f64]) -> f64 {
    let spread = |pick: fn(f64, f64) -> f64| delays.iter().copied().fold(0.0, pick);
    spread(f64::max) - spread(f64::min)
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
    // If the unit of the time is wrong, the filters need billions of samples.
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
