//! The beginning of a log, kept in memory for searches that read it several times.

use std::sync::Arc;

use super::deviation::deviation;
use super::smoothed::Smoothed;
use crate::log::{Channel, Channels, LogBlock, LogError, LogSource};
use crate::regression::{Reading, Reduction, System, signals};

/// Samples in an excerpt times joints, rounded up to a whole block: half a minute at 1 kHz for two
/// joints.
const EXCERPT_SAMPLES: usize = 60_000;

/// The beginning of a log, kept in memory.
#[derive(Clone, Debug)]
pub struct Excerpt {
    // Copies share them.
    blocks: Arc<Vec<LogBlock>>,
    samples: usize,
    limit: usize,
    period: f64,
    // Period of the log, s; shorter than that of an excerpt with fewer samples.
    of_log: f64,
}

impl Excerpt {
    /// Returns an empty excerpt of a log with period T, s, for a number of joints.
    #[must_use]
    pub fn new(period: f64, joints: usize) -> Self {
        Self {
            blocks: Arc::default(),
            samples: 0,
            limit: EXCERPT_SAMPLES / joints.max(2),
            period,
            of_log: period,
        }
    }

    /// Returns an empty excerpt that accepts samples of some time, s.
    #[must_use]
    pub(crate) fn lasting(period: f64, time: f64) -> Self {
        Self {
            limit: (time / period) as usize,
            ..Self::new(period, 0)
        }
    }

    /// Returns the standard deviation of a channel, rad (m) or N·m (N).
    #[must_use]
    pub(crate) fn deviation(&self, channel: usize) -> f64 {
        deviation(self.channel(channel))
    }

    /// Appends the next block; returns whether the excerpt accepts another block.
    pub fn push(&mut self, block: &LogBlock) -> bool {
        if self.samples < self.limit {
            self.samples += block.len();
            Arc::make_mut(&mut self.blocks).push(block.clone());
        }
        self.samples < self.limit
    }

    /// Returns the blocks of the excerpt.
    #[must_use]
    pub fn blocks(&self) -> &[LogBlock] {
        &self.blocks
    }

    /// Returns the first blocks, with at least `samples` samples if the excerpt has as many.
    #[must_use]
    pub fn first(&self, samples: usize) -> Self {
        let mut first = Self {
            blocks: Arc::default(),
            samples: 0,
            limit: samples,
            ..*self
        };
        for block in self.blocks() {
            first.push(block);
        }
        first
    }

    /// Returns an excerpt without samples for as much time, with a period that is longer by a factor.
    #[must_use]
    pub(super) fn emptied(&self, factor: usize) -> Self {
        Self {
            blocks: Arc::default(),
            samples: 0,
            limit: self.limit.div_ceil(factor),
            period: self.period * factor as f64,
            of_log: self.of_log,
        }
    }

    /// Returns T, s.
    #[must_use]
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Returns a copy with one channel multiplied by a number.
    #[must_use]
    pub fn scaled(&self, channel: usize, by: f64) -> Self {
        let mut scaled = self.clone();
        for block in Arc::make_mut(&mut scaled.blocks) {
            for value in &mut block.values[channel] {
                *value *= by;
            }
        }
        scaled
    }

    /// Returns the excerpt with the channels of another description that has no further ones.
    #[must_use]
    pub(super) fn with_channels(&self, channels: &Channels, wanted: &Channels) -> Self {
        if channels.all.len() == wanted.all.len() {
            return self.clone();
        }
        let place = |channel: &Channel| {
            let same = |other: &&Channel| {
                (other.quantity, other.joint, &other.column)
                    == (channel.quantity, channel.joint, &channel.column)
            };
            channels.all.iter().position(|other| same(&other))
        };
        let places: Vec<usize> = wanted.all.iter().filter_map(place).collect();
        let mut fewer = self.clone();
        for block in Arc::make_mut(&mut fewer.blocks) {
            let values = &block.values;
            block.values = places.iter().map(|&at| values[at].clone()).collect();
        }
        fewer
    }

    /// Returns the same samples in one block for each segment without gap.
    #[must_use]
    pub(crate) fn in_segments(&self) -> Self {
        let count = self.blocks.first().map_or(0, |block| block.values.len());
        let mut segments: Vec<LogBlock> = Vec::new();
        for block in self.blocks() {
            let mut from = 0;
            let ends = block.gaps.iter().copied().chain([block.len()]);
            for (k, to) in ends.enumerate() {
                if segments.is_empty() || k > 0 {
                    let mut segment = LogBlock::new(count);
                    if !segments.is_empty() {
                        segment.gaps.push(0);
                    }
                    segments.push(segment);
                }
                if let Some(segment) = segments.last_mut() {
                    segment.extend(block, from..to);
                }
                from = to;
            }
        }
        segments.retain(|segment| !segment.is_empty());
        self.replaced(segments)
    }

    /// Returns an excerpt of the same log with other blocks of as many samples.
    #[must_use]
    pub(crate) fn replaced(&self, blocks: Vec<LogBlock>) -> Self {
        Self {
            blocks: Arc::new(blocks),
            ..*self
        }
    }

    /// Returns the number of samples.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Returns the duration, s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.samples as f64 * self.period
    }

    /// Returns the times of the first and the last sample, s.
    pub(crate) fn span(&self) -> [f64; 2] {
        let mut times = self.blocks.iter().flat_map(|block| &block.time).copied();
        let first = times.next().unwrap_or_default();
        [first, times.next_back().unwrap_or(first)]
    }

    /// Returns the values of a channel.
    pub fn channel(&self, channel: usize) -> impl Iterator<Item = f64> + '_ {
        (self.blocks.iter()).flat_map(move |block| block.values[channel].iter().copied())
    }

    /// Returns the signals of the excerpt; `None` if it is too short for the filters or the filters
    /// do not fit its period.
    #[must_use]
    pub(crate) fn smoothed(&self, reading: &Reading) -> Option<Smoothed> {
        let reading = &reading.thinned(self.of_log, self.period);
        let segments = signals(reading, self.period, &self.blocks).ok()?;
        Some(Smoothed::new(self.period, segments))
    }

    /// Returns the regression of the excerpt; `None` as for [`Excerpt::smoothed`].
    #[must_use]
    pub fn reduce(&self, reading: &Reading) -> Option<System> {
        self.smoothed(reading)?.reduce(reading)
    }

    /// Returns the regression of the excerpt with fewer samples, for choices; `None` as for
    /// [`Excerpt::smoothed`].
    #[must_use]
    pub(crate) fn reduce_thinned(&self, reading: &Reading) -> Option<System> {
        self.smoothed(reading)?.thinned(reading).reduce(reading)
    }

    /// Returns the regression of some rows of the excerpt; `None` as for [`Excerpt::smoothed`].
    #[must_use]
    pub fn reduce_rows(&self, reading: &Reading, rows: &[usize]) -> Option<System> {
        let empty = Reduction::of_rows(reading.model(), rows);
        self.smoothed(reading)?.reduce_by(empty, reading)
    }
}

/// Reads the beginning of a log.
///
/// # Errors
///
/// [`LogError`] if it cannot be read.
pub fn excerpt(channels: &Channels, source: &mut LogSource<'_>) -> Result<Excerpt, LogError> {
    let mut log = source.open(channels)?;
    let mut block = LogBlock::new(channels.all.len());
    let mut more = log.read(&mut block)?;
    let mut excerpt = Excerpt::new(log.timing().period, channels.instruments.joint_count());
    while more {
        let accepts = excerpt.push(&block);
        more = accepts && log.read(&mut block)?;
        if accepts && !more {
            source.keep(channels, log, Arc::clone(&excerpt.blocks));
            break;
        }
    }
    Ok(excerpt)
}
