//! The beginning of the logs, in memory.

use crate::log::{Channels, LogBlock, LogError, LogSource};

/// Consecutive samples of one log: one vector per channel, in SI units.
#[derive(Clone, Debug)]
pub(in super::super) struct RawSegment {
    pub(super) log: usize,
    pub(super) period: f64,
    pub(super) values: Vec<Vec<f64>>,
}

/// Maximum work of the filter: samples times rows times rows. More samples would take minutes and
/// add little information.
const MAX_FILTER_WORK: usize = 2_400_000;

/// Returns the maximum number of samples that the filter processes.
pub(in super::super) fn max_samples(rows: usize) -> usize {
    MAX_FILTER_WORK / (rows * rows).max(1)
}

/// Reads the beginning of the logs and splits it at gaps.
///
/// - `limit`: maximum number of samples of all logs together.
///
/// Returns the segments, and whether the logs contain more samples.
///
/// # Errors
///
/// [`LogError`] if a log cannot be read.
pub(in super::super) fn read(
    channels: &Channels,
    sources: &mut [LogSource<'_>],
    limit: usize,
) -> Result<(Vec<RawSegment>, bool), LogError> {
    let mut segments = Vec::new();
    let mut more = false;
    let share = limit / sources.len().max(1);
    for (log, source) in sources.iter_mut().enumerate() {
        more |= read_log(channels, (log, source), share, &mut segments)?;
    }
    Ok((segments, more))
}

/// Reads the beginning of one log. Returns whether it contains more than `limit` samples.
fn read_log(
    channels: &Channels,
    (log_index, source): (usize, &mut LogSource<'_>),
    limit: usize,
    segments: &mut Vec<RawSegment>,
) -> Result<bool, LogError> {
    let count = channels.all.len();
    let mut log = source.open(channels)?;
    let mut block = LogBlock::new(count);
    let mut values = vec![Vec::new(); count];
    let mut taken = 0;
    let mut more = false;
    let mut going = log.read(&mut block)?;
    let period = log.timing().period;
    let segment = |values| RawSegment {
        log: log_index,
        period,
        values,
    };
    while going {
        let left = (limit - taken).min(block.len());
        more |= left < block.len();
        for k in 0..left {
            if block.gaps.contains(&k) {
                segments.push(segment(std::mem::replace(
                    &mut values,
                    vec![Vec::new(); count],
                )));
            }
            for (own, column) in values.iter_mut().zip(&block.values) {
                own.push(column[k]);
            }
        }
        taken += left;
        going = log.read(&mut block)?;
        if taken == limit {
            more |= going && !block.is_empty();
            break;
        }
    }
    segments.push(segment(values));
    Ok(more)
}
