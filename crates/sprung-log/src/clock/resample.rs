//! Resamples uneven samples onto an even grid.
//!
//! Positions are interpolated by the cubic through two samples before and two after. The cubic has
//! no phase and reproduces constant acceleration and jerk exactly, so velocities keep their mean.
//! Torques are held from sample to sample, so their mean over a shifted period is the linear
//! interpolation of two samples.

use crate::block::LogBlock;

/// Times that differ by less than this fraction of a period are equal.
pub(crate) const SAME_TIME_PART: f64 = 1e-9;

/// Minimum distance of the outer samples of a cubic from the inner ones, as a fraction of the
/// larger of inner step and period. Samples that almost coincide would amplify their noise.
const MIN_STEP_PART: f64 = 0.5;

/// Number of samples searched for an outer sample.
const REACH_SAMPLES: usize = 8;

/// Number of samples above which old samples are dropped.
const KEPT_SAMPLES: usize = 256;

/// Samples before resampling, and the state of the resampling.
#[derive(Clone, Debug)]
pub(crate) struct Resampler {
    // For each channel, whether it is a position (and not a torque).
    smooth: Vec<bool>,
    // Places of the samples, in periods since the segment began.
    at: Vec<f64>,
    time: Vec<f64>,
    values: Vec<Vec<f64>>,
    // Place of the next even sample, and index of the last sample at or before it.
    next: f64,
    last: usize,
    pub(crate) interpolated: u64,
}

impl Resampler {
    /// - `smooth`: for each channel, whether it is a position.
    pub(crate) fn new(smooth: Vec<bool>) -> Self {
        Self {
            at: Vec::new(),
            time: Vec::new(),
            values: vec![Vec::new(); smooth.len()],
            smooth,
            next: 0.0,
            last: 0,
            interpolated: 0,
        }
    }

    /// Takes the next sample and appends even samples to `out`.
    ///
    /// - `at`: place of the sample, in periods since the segment began; `time`: in s.
    pub(crate) fn push(
        &mut self,
        at: f64,
        time: f64,
        values: impl Iterator<Item = f64>,
        out: &mut LogBlock,
    ) {
        self.at.push(at);
        self.time.push(time);
        for (column, value) in self.values.iter_mut().zip(values) {
            column.push(value);
        }
        self.advance(false, out);
        if self.at.len() > KEPT_SAMPLES {
            let done = self.last.saturating_sub(REACH_SAMPLES);
            self.at.drain(..done);
            self.time.drain(..done);
            for values in &mut self.values {
                values.drain(..done);
            }
            self.last -= done;
        }
    }

    /// Ends a segment. Later samples are not interpolated with earlier ones.
    pub(crate) fn end(&mut self, out: &mut LogBlock) {
        self.advance(true, out);
        self.at.clear();
        self.time.clear();
        self.values.iter_mut().for_each(Vec::clear);
        self.next = 0.0;
        self.last = 0;
    }

    fn advance(&mut self, ended: bool, out: &mut LogBlock) {
        loop {
            while self
                .at
                .get(self.last + 1)
                .is_some_and(|at| *at <= self.next + SAME_TIME_PART)
            {
                self.last += 1;
            }
            let k = self.last;
            let Some(&here) = self.at.get(k) else { return };
            if (here - self.next).abs() <= SAME_TIME_PART {
                out.time.push(self.time[k]);
                for (out, values) in out.values.iter_mut().zip(&self.values) {
                    out.push(values[k]);
                }
            } else if !self.between(k, ended, out) {
                return;
            }
            self.next += 1.0;
        }
    }

    /// Appends the next even sample, which lies after the `k`th sample. Returns false if the
    /// samples needed for it have not arrived.
    fn between(&mut self, k: usize, ended: bool, out: &mut LogBlock) -> bool {
        let Some(&ahead) = self.at.get(k + 1) else {
            return false;
        };
        let apart = MIN_STEP_PART * (ahead - self.at[k]).max(1.0);
        let behind = (k + 2..self.at.len().min(k + 2 + REACH_SAMPLES))
            .find(|&i| self.at[i] - ahead >= apart);
        if behind.is_none() && !ended && self.at.len() < k + 2 + REACH_SAMPLES {
            return false;
        }
        let before = (k.saturating_sub(REACH_SAMPLES)..k)
            .rev()
            .find(|&i| self.at[k] - self.at[i] >= apart);
        let nodes: Vec<usize> = (before.into_iter().chain([k, k + 1]).chain(behind)).collect();
        let weights = |nodes: &[usize]| -> Vec<f64> {
            let times: Vec<f64> = nodes.iter().map(|&i| self.at[i]).collect();
            (0..nodes.len())
                .map(|i| lagrange(&times, i, self.next))
                .collect()
        };
        let (cubic, line) = (weights(&nodes), weights(&[k, k + 1]));
        let sum = |values: &[f64], nodes: &[usize], weights: &[f64]| -> f64 {
            nodes
                .iter()
                .zip(weights)
                .map(|(&i, weight)| weight * values[i])
                .sum()
        };
        out.time.push(sum(&self.time, &[k, k + 1], &line));
        for ((out, values), smooth) in out.values.iter_mut().zip(&self.values).zip(&self.smooth) {
            out.push(if *smooth {
                sum(values, &nodes, &cubic)
            } else {
                sum(values, &[k, k + 1], &line)
            });
        }
        self.interpolated += 1;
        true
    }
}

/// Returns the Lagrange weight of the `i`th value in the polynomial through all values.
pub(crate) fn lagrange(times: &[f64], i: usize, time: f64) -> f64 {
    (times.iter().enumerate())
        .filter(|&(j, _)| j != i)
        .map(|(_, other)| (time - other) / (times[i] - other))
        .product()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resampled(at: &[f64], value: impl Fn(f64) -> f64) -> (LogBlock, u64) {
        let mut resampler = Resampler::new(vec![true, false]);
        let mut out = LogBlock::new(2);
        for &at in at {
            resampler.push(
                at,
                2.0 + 1e-3 * at,
                [value(at), value(at)].into_iter(),
                &mut out,
            );
        }
        resampler.end(&mut out);
        (out, resampler.interpolated)
    }

    #[test]
    fn cubics_are_reproduced_and_even_samples_stay() {
        // The jitter is 40 %, two samples almost coincide, and three samples are missing.
        let mut at: Vec<f64> = (0..900)
            .filter(|k| !(500..503).contains(k))
            .map(|k| f64::from(k) + if k % 7 == 3 { 0.4 } else { 0.0 })
            .collect();
        at.insert(101, at[100] + 0.05);
        let cubic = |t: f64| 1.0 + t * (0.3 + t * (2e-3 - 1e-5 * t));
        let (out, interpolated) = resampled(&at, cubic);
        assert_eq!(out.len(), 900);
        // After the last even sample, the cubic lacks its outer sample.
        for (k, value) in out.values[0].iter().enumerate().take(899) {
            let error = (value - cubic(k as f64)).abs() / cubic(k as f64).abs().max(1.0);
            assert!(error < 1e-9, "{k}: {error}");
            assert!((out.time[k] - 2.0 - 1e-3 * k as f64).abs() < 1e-12);
        }
        // Every seventh sample is late. One of the three missing samples would also have been late.
        assert_eq!(interpolated, 129 + 2);
        assert_eq!(out.values[1][2].to_bits(), cubic(2.0).to_bits());
    }

    #[test]
    fn noise_is_not_amplified() {
        // Many random steps, some of them almost 0, give the largest weights.
        let mut state = 1_u64;
        let mut at = vec![0.0];
        for _ in 0..5000 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            let part = (state >> 40) as f64 / f64::from(1 << 24);
            at.push(at[at.len() - 1] + 0.01 + 3.0 * part * part);
        }
        let (out, interpolated) = resampled(&at, |t| {
            if ((1e3 * t) as u64).is_multiple_of(2) {
                1.0
            } else {
                -1.0
            }
        });
        // The steps are random, so hardly a sample is on the grid.
        assert!(2 * interpolated > out.len() as u64, "{interpolated}");
        let worst = out.values[0]
            .iter()
            .fold(0.0_f64, |worst, x| worst.max(x.abs()));
        // The absolute weights of a cubic whose outer samples are at least half an inner step away sum to 5/3 or less.
        // They have the largest sum in the middle of the inner step.
        assert!(worst < 5.0 / 3.0 + 1e-12, "{worst}");
    }
}
