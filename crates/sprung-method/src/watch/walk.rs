//! Aligned samples of a log, block by block, as an observer on line receives them.

use crate::log::LogBlock;
use crate::preprocess::{Aligner, RawBlock};
use crate::regression::Reading;

/// What comes next in a log.
pub(super) enum Next<'r> {
    /// The log begins, or continues behind a gap.
    Restart,
    Samples(&'r RawBlock),
}

/// Aligns the channels of a log.
pub(super) struct Walk<'a> {
    reading: &'a Reading,
    period: f64,
    aligner: Aligner,
    raw: RawBlock,
    part: LogBlock,
    has_begun: bool,
}

impl<'a> Walk<'a> {
    /// - `period`: T, s.
    pub(super) fn new(reading: &'a Reading, period: f64) -> Self {
        Self {
            aligner: aligner(reading, period),
            raw: RawBlock::new(reading.model().joint_count()),
            part: LogBlock::new(reading.channels().all.len()),
            has_begun: false,
            reading,
            period,
        }
    }

    /// Takes the next block of the log.
    pub(super) fn push(&mut self, block: &LogBlock, take: &mut dyn FnMut(Next<'_>)) {
        if !std::mem::replace(&mut self.has_begun, true) {
            self.raw.begin = block.time.first().copied().unwrap_or_default();
            take(Next::Restart);
        }
        let mut from = 0;
        for &gap in &block.gaps {
            self.feed(block, from..gap, take);
            self.aligner = aligner(self.reading, self.period);
            take(Next::Restart);
            from = gap;
        }
        self.feed(block, from..block.len(), take);
    }

    fn feed(
        &mut self,
        block: &LogBlock,
        part: std::ops::Range<usize>,
        take: &mut dyn FnMut(Next<'_>),
    ) {
        self.part.clear();
        self.part.extend(block, part);
        self.raw.clear();
        self.aligner.push(&self.part, &mut self.raw);
        if !self.raw.is_empty() {
            take(Next::Samples(&self.raw));
        }
    }
}

fn aligner(reading: &Reading, period: f64) -> Aligner {
    let (channels, delays) = (reading.channels(), reading.delays());
    Aligner::new(channels, delays, reading.compliances(), period)
}
