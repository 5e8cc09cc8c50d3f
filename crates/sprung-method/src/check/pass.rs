//! Reads logs once without filters and gathers their figures.

use crate::log::{LogBlock, LogSource, Summary};
use crate::prepare::PrepareError;
use crate::progress::{Listener, Phase};
use crate::regression::{LogFigures, Reading, shortest_segment};

/// Reads all logs, one after the other.
pub(super) fn read_all(
    reading: &Reading,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<Vec<LogFigures>, PrepareError> {
    let mut figures: Vec<LogFigures> = Vec::new();
    let count = sources.len();
    for (source, number) in sources.iter_mut().zip(1..) {
        let before = figures.iter().map(|log| log.summary.samples()).sum();
        figures.push(read(reading, source, (before, count - number), progress)?);
    }
    Ok(figures)
}

/// Reads one log.
///
/// - `before`, `later`: number of samples in the previous logs, and number of later logs.
fn read(
    reading: &Reading,
    source: &mut LogSource<'_>,
    (before, later): (u64, usize),
    progress: &mut dyn Listener,
) -> Result<LogFigures, PrepareError> {
    let channels = reading.channels();
    let mut log = source.open(channels)?;
    let mut block = LogBlock::new(channels.all.len());
    let mut summary = Summary::new(channels);
    let mut more = log.read(&mut block)?;
    let mut segments = Segments::new(shortest_segment(reading, log.timing().period));
    while more {
        summary.take(&block);
        segments.take(&block);
        let done = before + log.timing().recorded;
        // Later logs are assumed to be as long as this one.
        let expected = log
            .expected()
            .map(|samples| before + samples * (1 + later as u64));
        progress.tell(Phase::Reading, done, expected)?;
        more = log.read(&mut block)?;
    }
    Ok(LogFigures {
        timing: log.timing(),
        lost: segments.lost(),
        names: log.names().to_vec(),
        mended: log.mended().to_vec(),
        summary,
    })
}

/// Counts samples in segments that are too short for the filters.
struct Segments {
    // Smallest number of samples for the filters; `None` if no filter fits the log.
    shortest: Option<u64>,
    current: u64,
    lost: u64,
}

impl Segments {
    fn new(shortest: Option<u64>) -> Self {
        Self {
            shortest,
            current: 0,
            lost: 0,
        }
    }

    fn take(&mut self, block: &LogBlock) {
        let mut from = 0;
        for &gap in &block.gaps {
            self.current += (gap - from) as u64;
            self.end();
            from = gap;
        }
        self.current += (block.len() - from) as u64;
    }

    fn end(&mut self) {
        let samples = std::mem::take(&mut self.current);
        if self.shortest.is_some_and(|shortest| samples < shortest) {
            self.lost += samples;
        }
    }

    /// Returns the samples in segments that are too short for the filters.
    fn lost(mut self) -> u64 {
        self.end();
        self.lost
    }
}
