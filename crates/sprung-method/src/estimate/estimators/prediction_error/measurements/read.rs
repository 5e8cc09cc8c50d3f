//! Samples of the logs, in memory.

use crate::estimate::estimators::prediction_error::state_layout::state_count;
use std::mem::size_of;

use super::measurement::Measurement;
use crate::description::Payload;
use crate::estimate::estimators::prediction_error::vector::Short;
use crate::log::{Channels, LogBlock, LogError, LogSource, Quantity};
use crate::model::Model;

/// Consecutive samples of one log: one vector per channel, in SI units.
#[derive(Clone, Debug)]
pub(in super::super) struct RawSegment {
    pub(super) log: usize,
    pub(super) period: f64,
    /// Time of the first sample since the beginning of the log, s.
    pub(super) begin: f64,
    /// What the robot carried.
    pub(super) payload: Option<Payload>,
    pub(super) values: Vec<Vec<f64>>,
}

/// Which samples of the logs are read.
#[derive(Clone, Copy, Debug)]
pub(in super::super) enum Extent {
    /// The beginning of each log, about this number of samples of all logs together.
    Beginning(usize),
    /// At most this number of samples, spread evenly over the logs.
    Spread(usize),
}

/// Work of the filter that takes less than a minute, so that a search may be repeated without a message about its
/// duration: samples times rows times rows.
pub(in crate::estimate::estimators::prediction_error) const MAX_SEARCH_WORK: usize = 2_400_000;

/// Maximum memory of the linearizations about which levels are searched, and of the segments in
/// work, bytes.
const LINEARIZATIONS: usize = 80 << 20;

/// Length of a short segment, s: a segment of the filter.
const SHORT_SEGMENT_S: f64 = 5.0;

/// Returns the maximum number of samples that the filter processes in a search that is repeated.
pub(in super::super) fn max_samples(rows: usize) -> usize {
    MAX_SEARCH_WORK / (rows * rows).max(1)
}

/// Returns the maximum number of samples that a refinement keeps in some memory.
///
/// - `mib`: the memory, MiB.
pub(in super::super) fn samples_in(mib: usize, model: &Model, channels: &Channels) -> usize {
    let rows = model.coordinates();
    let all = channels.all.len();
    let sensors = (channels.all.iter())
        .filter(|channel| channel.quantity != Quantity::MotorTorque)
        .count();
    // Gains, the measurements, and their whitening.
    let of_sensor =
        state_count(rows) * size_of::<Short>() + size_of::<Measurement>() + size_of::<f64>();
    // Torques and their rates.
    let of_row = 2 * size_of::<f64>();
    let of_sample = sensors * of_sensor + rows * of_row + all * size_of::<f64>();
    (mib << 20).saturating_sub(LINEARIZATIONS) / of_sample
}

/// Consecutive samples of one log, as long as a segment of the filter.
struct ShortSegment {
    /// Index among all segments of all logs.
    index: usize,
    log: usize,
    period: f64,
    /// Time of the first sample since the beginning of the log, s.
    begin: f64,
    payload: Option<Payload>,
    /// Whether it continues the segment before.
    continues: bool,
    values: Vec<Vec<f64>>,
}

/// The segments of the logs that are kept: every one, every second, every fourth and so on, as many as
/// the limit allows.
struct Kept {
    segments: Vec<ShortSegment>,
    /// Distance between the indices of kept segments.
    stride: usize,
    samples: usize,
    limit: usize,
    /// Number of segments read.
    read: usize,
}

impl Kept {
    /// - `limit`: maximum number of samples.
    fn new(limit: usize) -> Self {
        Self {
            segments: Vec::new(),
            stride: 1,
            samples: 0,
            limit,
            read: 0,
        }
    }

    /// Adds the next segment of the logs.
    fn push(&mut self, segment: ShortSegment) {
        self.read = segment.index + 1;
        if !segment.index.is_multiple_of(self.stride) {
            return;
        }
        self.samples += length(&segment);
        self.segments.push(segment);
        while self.samples > self.limit && self.segments.len() > 1 {
            self.stride *= 2;
            self.segments
                .retain(|segment| segment.index.is_multiple_of(self.stride));
            self.samples = self.segments.iter().map(length).sum();
        }
    }

    /// Joins the segments without a gap between them.
    fn segments(mut self) -> Vec<RawSegment> {
        let mut segments = Vec::new();
        let mut rest = self.segments.as_mut_slice();
        while let Some(first) = rest.first() {
            let (log, period, begin) = (first.log, first.period, first.begin);
            let further = rest[1..].iter().take_while(|segment| segment.continues);
            let count = 1 + if self.stride == 1 { further.count() } else { 0 };
            let (joined, next) = rest.split_at_mut(count);
            rest = next;
            let samples = joined.iter().map(length).sum();
            let payload = joined[0].payload.take();
            let channels = joined[0].values.len();
            // One channel after the other, to limit memory.
            let values = (0..channels).map(|channel| {
                let mut all = Vec::with_capacity(samples);
                for segment in joined.iter_mut() {
                    all.extend(std::mem::take(&mut segment.values[channel]));
                }
                all
            });
            segments.push(RawSegment {
                log,
                period,
                begin,
                payload,
                values: values.collect(),
            });
        }
        segments
    }
}

fn length(segment: &ShortSegment) -> usize {
    segment.values.first().map_or(0, Vec::len)
}

/// Reads the logs and splits them at gaps.
///
/// Returns the segments, and whether the logs contain more samples.
///
/// # Errors
///
/// [`LogError`] if a log cannot be read.
pub(in super::super) fn read(
    channels: &Channels,
    sources: &mut [LogSource<'_>],
    extent: Extent,
) -> Result<(Vec<RawSegment>, bool), LogError> {
    let (limit, stop) = match extent {
        Extent::Beginning(samples) => (usize::MAX, samples / sources.len().max(1)),
        Extent::Spread(samples) => (samples, usize::MAX),
    };
    let mut more = false;
    let mut kept = Kept::new(limit);
    for (log, source) in sources.iter_mut().enumerate() {
        more |= read_log(channels, (log, source), stop, &mut kept)?;
    }
    more |= kept.stride > 1;
    Ok((kept.segments(), more))
}

/// Reads the segments of one log, until the block with the sample `stop`. Returns whether the log has
/// more blocks.
fn read_log(
    channels: &Channels,
    (log_index, source): (usize, &mut LogSource<'_>),
    stop: usize,
    kept: &mut Kept,
) -> Result<bool, LogError> {
    let count = channels.all.len();
    let payload = source.payload().cloned();
    let mut log = source.open(channels)?;
    let mut block = LogBlock::new(count);
    let mut going = log.read(&mut block)?;
    let period = log.timing().period;
    let samples = ((SHORT_SEGMENT_S / period).ceil() as usize).clamp(1, kept.limit.max(1));
    let origin = block.time.first().copied().unwrap_or_default();
    let new = |index: usize, time: f64, continues: bool| ShortSegment {
        index,
        log: log_index,
        period,
        begin: time - origin,
        payload: payload.clone(),
        continues,
        values: vec![Vec::new(); count],
    };
    let mut segment = new(kept.read, origin, false);
    let mut taken = 0;
    while going && taken < stop {
        for k in 0..block.len() {
            let is_gap = block.gaps.contains(&k);
            if is_gap || length(&segment) == samples {
                let next = new(segment.index + 1, block.time[k], !is_gap);
                kept.push(std::mem::replace(&mut segment, next));
            }
            for (series, column) in segment.values.iter_mut().zip(&block.values) {
                series.push(column[k]);
            }
        }
        taken += block.len();
        going = log.read(&mut block)?;
    }
    kept.push(segment);
    Ok(going && !block.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Short segments of ten samples with the given flags, and their numbers as values.
    fn kept(limit: usize, continues: &[bool]) -> Kept {
        let mut kept = Kept::new(limit);
        for (index, &continues) in continues.iter().enumerate() {
            kept.push(ShortSegment {
                index,
                log: 0,
                period: 1e-3,
                begin: 0.0,
                payload: None,
                continues,
                values: vec![vec![index as f64; 10]],
            });
        }
        kept
    }

    #[test]
    fn short_logs_are_used_up_to_their_gaps() {
        let segments = kept(50, &[false, true, true, false, true]).segments();
        let lengths: Vec<usize> = segments
            .iter()
            .map(|segment| segment.values[0].len())
            .collect();
        assert_eq!(lengths, [30, 20]);
    }

    #[test]
    fn short_segments_of_long_logs_are_spread_evenly() {
        for (count, stride) in [(5, 1), (6, 2), (10, 2), (11, 4), (40, 8)] {
            let kept = kept(50, &vec![true; count]);
            assert_eq!(kept.stride, stride, "{count} segments");
            assert!(kept.samples <= 50);
            let segments = kept.segments();
            let first: Vec<f64> = segments
                .iter()
                .map(|segment| segment.values[0][0])
                .collect();
            let joined = if stride == 1 {
                1
            } else {
                count.div_ceil(stride)
            };
            let expected: Vec<f64> = (0..joined).map(|i| (i * stride) as f64).collect();
            assert_eq!(first, expected);
        }
    }
}
