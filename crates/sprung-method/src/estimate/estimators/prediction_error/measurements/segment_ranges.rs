//! Division of a segment into shorter segments that the filter processes in parallel.

/// Shortest segment whose measurements count, s.
const MIN_SEGMENT_S: f64 = 3.5;

/// Samples before a segment that bring the filter to its state, s. They are five times the time
/// constant of disturbances with the expected corner of 1.5 Hz, the slowest states of the filter.
const BURN_IN_S: f64 = 0.5;

/// A part of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SegmentRange {
    /// First sample, and the sample after the last one.
    pub(super) from: usize,
    pub(super) to: usize,
    /// Number of samples at the beginning that do not count.
    pub(super) burn_in: usize,
}

/// Returns segments of nearly equal length, an even number so that two threads have the same work.
/// They depend only on the log, not on the number of threads.
pub(super) fn segment_ranges(samples: usize, period: f64) -> Vec<SegmentRange> {
    let duration = samples as f64 * period;
    let most = ((duration / MIN_SEGMENT_S) as usize).clamp(1, samples.max(1));
    let count = most - if most > 1 { most % 2 } else { 0 };
    let burn_in = (BURN_IN_S / period).ceil() as usize;
    (0..count)
        .map(|i| {
            let begin = i * samples / count;
            let burn_in = burn_in.min(begin);
            SegmentRange {
                from: begin - burn_in,
                to: (i + 1) * samples / count,
                burn_in,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_sample_counts_once() {
        for (samples, period, count) in [
            (10_000, 1e-3, 2),
            (3, 1e-3, 1),
            (11_000, 1e-3, 2),
            (900, 0.1, 24),
        ] {
            let found = segment_ranges(samples, period);
            assert_eq!(found.len(), count);
            let mut next = 0;
            for within in &found {
                assert_eq!(within.from + within.burn_in, next);
                next = within.to;
            }
            assert_eq!(next, samples);
            assert!(found[1..].iter().all(|within| within.burn_in > 0));
        }
    }
}
