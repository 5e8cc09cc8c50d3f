//! Keeps the samples of one segment of the logs for spectra.

use crate::preprocess::RawBlock;
use crate::regression::{Observer, Restart};

/// Lowest sampling rate of the record, Hz. Faster logs are averaged over several samples.
const LEAST_RATE_HZ: f64 = 400.0;

/// Samples of the record times joints: two minutes at 500 Hz for up to three joints.
const SAMPLES_TIMES_JOINTS: usize = 180_000;

/// The longest segment of the logs without a gap, up to a limit.
#[derive(Clone, Debug)]
pub(crate) struct Record {
    joints: usize,
    limit: usize,
    longest: Segment,
    current: Segment,
}

/// Samples without a gap, each the mean of some samples of the log.
///
/// The same mean of torques and positions changes no frequency response.
#[derive(Clone, Debug, Default)]
pub(super) struct Segment {
    /// Sampling period of the log, s.
    pub(super) log_period: f64,
    /// Number of samples of the log in each sample.
    pub(super) every: usize,
    /// Motor torques and motor positions of each joint, \[2n\] vectors.
    pub(super) columns: Vec<Vec<f64>>,
    // Sums of the sample that is not complete, and their number.
    sums: Vec<f64>,
    summed: usize,
}

impl Record {
    /// Returns an empty record of a robot.
    #[must_use]
    pub(crate) fn new(joints: usize) -> Self {
        Self {
            joints,
            limit: SAMPLES_TIMES_JOINTS / joints.max(3),
            longest: Segment::default(),
            current: Segment::default(),
        }
    }

    /// Returns the segment.
    pub(super) fn longest(&self) -> &Segment {
        if self.current.duration() > self.longest.duration() {
            &self.current
        } else {
            &self.longest
        }
    }
}

impl Segment {
    fn new(joints: usize, period: f64) -> Self {
        Self {
            log_period: period,
            every: ((1.0 / (LEAST_RATE_HZ * period)) as usize).max(1),
            columns: vec![Vec::new(); 2 * joints],
            sums: vec![0.0; 2 * joints],
            summed: 0,
        }
    }

    /// Returns the number of samples.
    pub(super) fn len(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// Returns the sampling period, s.
    pub(super) fn period(&self) -> f64 {
        self.log_period * self.every as f64
    }

    /// Returns the number of joints.
    pub(super) fn joints(&self) -> usize {
        self.columns.len() / 2
    }

    /// Returns the motor positions of a joint, rad (m).
    pub(super) fn motor(&self, joint: usize) -> &[f64] {
        &self.columns[self.joints() + joint]
    }

    /// Returns the samples of both halves.
    pub(super) fn halves(&self) -> [Self; 2] {
        let middle = self.len() / 2;
        let part = |range: std::ops::Range<usize>| Self {
            columns: (self.columns.iter())
                .map(|column| column[range.clone()].to_vec())
                .collect(),
            sums: Vec::new(),
            ..*self
        };
        [part(0..middle), part(middle..self.len())]
    }

    fn duration(&self) -> f64 {
        self.len() as f64 * self.period()
    }

    fn push(&mut self, samples: &RawBlock, limit: usize) {
        for k in 0..samples.len() {
            if self.len() >= limit {
                return;
            }
            let all = samples.tau.iter().chain(&samples.phi);
            for (sum, column) in self.sums.iter_mut().zip(all) {
                *sum += column[k];
            }
            self.summed += 1;
            if self.summed == self.every {
                let scale = 1.0 / self.every as f64;
                for (column, sum) in self.columns.iter_mut().zip(&mut self.sums) {
                    column.push(*sum * scale);
                    *sum = 0.0;
                }
                self.summed = 0;
            }
        }
    }
}

impl Observer for Record {
    fn restart(&mut self, _: Restart) {
        let ended = std::mem::take(&mut self.current);
        if ended.duration() > self.longest.duration() {
            self.longest = ended;
        }
    }

    fn raw(&mut self, period: f64, samples: &RawBlock) {
        if self.current.columns.is_empty() {
            self.current = Segment::new(self.joints, period);
        }
        self.current.push(samples, self.limit);
    }

    fn of_one_log(&self) -> Option<Self> {
        Some(Self::new(self.joints))
    }

    fn join(&mut self, mut next: Self) {
        self.restart(Restart::Begin);
        next.restart(Restart::Begin);
        if next.longest.duration() > self.longest.duration() {
            self.longest = next.longest;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(count: usize) -> RawBlock {
        let mut block = RawBlock::new(1);
        for k in 0..count {
            block.time.push(1e-3 * k as f64);
            block.tau[0].push(k as f64);
            block.phi[0].push(2.0 * k as f64);
        }
        block
    }

    #[test]
    fn the_longest_segment_is_kept_and_averaged() {
        let mut record = Record::new(1);
        record.restart(Restart::Begin);
        record.raw(1e-3, &block(1001));
        record.restart(Restart::Gap);
        record.raw(1e-3, &block(300));
        let kept = record.longest();
        assert_eq!((kept.every, kept.len()), (2, 500));
        assert!((kept.period() - 2e-3).abs() < 1e-15);
        assert!((kept.columns[0][1] - 2.5).abs() < 1e-12);
        assert!((kept.motor(0)[1] - 5.0).abs() < 1e-12);
    }

    #[test]
    fn the_memory_is_bounded() {
        let mut record = Record::new(1);
        for _ in 0..200 {
            record.raw(1e-3, &block(2048));
        }
        assert_eq!(record.longest().len(), SAMPLES_TIMES_JOINTS / 3);
    }
}
