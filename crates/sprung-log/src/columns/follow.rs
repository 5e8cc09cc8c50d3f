//! Interpolates streams with their own clock at the times of the first stream.

use super::rows::{Rows, Tolerance};
use crate::block::BLOCK;
use crate::clock::resample::lagrange;
use crate::clock::timing::Count;
use crate::error::{LogError, Place};

/// A step of more than this number of usual steps is a gap without interpolation.
const GAP_PERIODS: f64 = 3.5;

/// Number of steps whose median is the usual step.
const LEARNING_SAMPLES: usize = 64;

/// Times that differ by less than this fraction of the usual step are equal.
const SAME_TIME_PART: f64 = 1e-6;

/// A stream with its own time, read together with the first stream.
pub(crate) struct Follower {
    rows: Rows,
    /// Indices of its channels among all.
    pub(crate) channels: Vec<usize>,
    // Samples around the requested times, on the time axis of the first stream.
    times: Vec<f64>,
    values: Vec<Vec<f64>>,
    shift: f64,
    usual: f64,
    ended: bool,
    // Error of the rows that follow, if the log has a window.
    fault: Option<LogError>,
    tolerance: Tolerance,
    name: String,
    /// Rows that repeat the time and the values of the preceding row.
    pub(crate) repeated: Count,
    /// Rows that were left out because they lack a value.
    pub(crate) lacking: Count,
}

impl Follower {
    /// Returns the place in the middle of which the stream ends, if it was cut off.
    pub(crate) fn cut(&self) -> Option<Place> {
        self.rows.cut()
    }

    /// - `name`: name of the stream for messages.
    /// - `channels`: indices of its channels among all.
    pub(crate) fn new(
        name: String,
        rows: Rows,
        channels: Vec<usize>,
        tolerance: Tolerance,
    ) -> Self {
        Self {
            fault: None,
            tolerance,
            values: vec![Vec::new(); channels.len()],
            rows,
            channels,
            times: Vec::new(),
            shift: 0.0,
            usual: 0.0,
            ended: false,
            name,
            repeated: Count::default(),
            lacking: Count::default(),
        }
    }

    /// Appends the values at `times` to `out`; NaN where the stream has no values.
    ///
    /// - `origin`: the time that was subtracted from `times`, ns.
    ///
    /// Between two samples, values come from the cubic through four samples, as for delays.
    ///
    /// # Errors
    ///
    /// [`LogError`] if the stream cannot be read or its time does not increase.
    pub(crate) fn at(
        &mut self,
        times: &[f64],
        origin: i128,
        out: &mut [Vec<f64>],
    ) -> Result<(), LogError> {
        let Some(&last) = times.last() else {
            return Ok(());
        };
        // The cubic needs two samples after the last time.
        let behind = |times: &[f64]| times.len() >= 2 && times[times.len() - 2] > last;
        while !self.ended && !behind(&self.times) {
            // Samples long before the first requested time are not kept.
            self.let_go(self.times.partition_point(|time| *time < times[0]));
            self.more(origin, times[0])?;
        }
        let mut k = 0;
        for &time in times {
            while k + 1 < self.times.len() && self.times[k + 1] <= time {
                k += 1;
            }
            for (values, channel) in self.values.iter().zip(&self.channels) {
                let value = interpolated(&self.times, values, k, time, self.usual);
                if value.is_nan()
                    && self.times.last().is_none_or(|last| time > *last)
                    && let Some(error) = self.fault.take()
                {
                    return Err(error);
                }
                out[*channel].push(value);
            }
        }
        self.let_go(k);
        Ok(())
    }

    /// Drops samples that no cubic at or after the `k`th sample needs.
    fn let_go(&mut self, k: usize) {
        let done = k.saturating_sub(2).min(self.times.len());
        self.times.drain(..done);
        for values in &mut self.values {
            values.drain(..done);
        }
    }

    /// - `wanted`: first time that is still requested, s.
    fn more(&mut self, origin: i128, wanted: f64) -> Result<(), LogError> {
        let count = self.rows.read(BLOCK)?;
        if count == 0 {
            self.ended = true;
            return Ok(());
        }
        if self.usual == 0.0 {
            self.shift = (self.rows.origin() - origin) as f64 * 1e-9;
            let mut steps: Vec<f64> = (self.rows.times.windows(2).take(LEARNING_SAMPLES))
                .map(|pair| pair[1] - pair[0])
                .collect();
            steps.sort_by(f64::total_cmp);
            self.usual = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
        }
        for i in 0..count {
            if self.rows.lacks(i) {
                self.lacking.add(1, self.rows.place(i));
                continue;
            }
            let time = self.rows.times[i] + self.shift;
            if self.tolerance == Tolerance::OfWindow {
                let is_before = time.is_nan() || time < wanted;
                match self.rows.check(i..i + 1) {
                    Err(_) if is_before => continue,
                    Err(error) => {
                        self.fault = Some(error);
                        self.ended = true;
                        return Ok(());
                    }
                    Ok(()) => {}
                }
                if is_before && self.times.last().is_some_and(|before| time < *before) {
                    self.let_go(self.times.len() + 2);
                }
            }
            if let Some(&before) = self.times.last()
                && time <= before
            {
                let place = self.rows.place(i);
                let pairs = self.values.iter().zip(&self.rows.values);
                let same = |(column, read): (&Vec<f64>, &Vec<f64>)| column.last() == read.get(i);
                if time.to_bits() == before.to_bits() && pairs.into_iter().all(same) {
                    self.repeated.add(1, place);
                    continue;
                }
                return Err(LogError::TimeNotIncreasing {
                    file: self.name.clone(),
                    place,
                    before: before - self.shift,
                    after: time - self.shift,
                    remedy: "",
                });
            }
            self.times.push(time);
            for (column, read) in self.values.iter_mut().zip(&self.rows.values) {
                column.push(read[i]);
            }
        }
        Ok(())
    }
}

/// Returns the value at `time`, which lies after the `k`th of `times`; NaN outside the stream and
/// in gaps.
fn interpolated(times: &[f64], values: &[f64], k: usize, time: f64, usual: f64) -> f64 {
    let Some(&here) = times.get(k) else {
        return f64::NAN;
    };
    let same = SAME_TIME_PART * usual;
    if (time - here).abs() <= same {
        return values[k];
    }
    let Some(&next) = times.get(k + 1) else {
        return f64::NAN;
    };
    if (next - time).abs() <= same {
        return values[k + 1];
    }
    let even = |a: f64, b: f64| b - a < GAP_PERIODS * usual;
    if time < here || !even(here, next) {
        return f64::NAN;
    }
    let begin = if k >= 1 && even(times[k - 1], here) {
        k - 1
    } else {
        k
    };
    let end = match times.get(k + 2) {
        Some(&after) if even(next, after) => k + 3,
        _ => k + 2,
    };
    let points = begin..end;
    let near = &times[points.clone()];
    points
        .enumerate()
        .map(|(i, point)| values[point] * lagrange(near, i, time))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_are_exact_and_gaps_give_nan() {
        let mut times: Vec<f64> = (0..20)
            .map(|k| 0.1 * f64::from(k) + 0.003 * f64::from(k % 3))
            .collect();
        let cubic = |t: f64| 1.0 - 2.0 * t + 3.0 * t * t - t * t * t;
        for time in &mut times[12..] {
            *time += 1.0;
        }
        let values: Vec<f64> = times.iter().map(|&t| cubic(t)).collect();
        let at = |k: usize, time: f64| interpolated(&times, &values, k, time, 0.1);
        for (k, time) in times.iter().enumerate().take(9).skip(1) {
            let time = time + 0.04;
            assert!((at(k, time) - cubic(time)).abs() < 1e-12, "{k}");
        }
        assert_eq!(at(5, times[5]).to_bits(), values[5].to_bits());
        assert!(at(11, times[11] + 0.5).is_nan());
        assert!(at(19, times[19] + 0.1).is_nan());
        assert!(at(0, times[0] - 0.1).is_nan());
    }
}
