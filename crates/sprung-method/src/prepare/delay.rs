//! Estimates delays of channels from the motor rows.

use super::excerpt::Excerpt;
use super::row::{MotorRowFit, fit_rows};
use crate::regression::Reading;

/// Range of delays in the search, s. Sensors with their own filters are late by their lag; some
/// channels are recorded slightly early.
const EARLIEST_S: f64 = -0.05;
const LATEST_S: f64 = 0.5;

/// Distance of neighbouring delays in the first scan, s, and samples in it.
const COARSE_STEP_S: f64 = 0.01;
const SAMPLES_PER_COARSE_STEP: f64 = 2.5;

/// Turns of the channels of a joint. A delay of one channel changes the estimate of another by a part of the delay.
const TURNS: usize = 3;

/// An estimate of a delay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DelayEstimate {
    /// Index of the channel in [`Channels::all`](crate::log::Channels::all).
    pub channel: usize,
    /// Delay, s.
    pub delay: f64,
    /// Standard error, s; it accounts for the correlation of the filtered residuals.
    pub standard_error: f64,
    /// Whether the log determines the delay: the minimum lies inside the range and explains at
    /// least as much torque as zero delay.
    pub found: bool,
    /// Fit of the motor row without the delay.
    pub without: MotorRowFit,
    /// Fit of the motor row with the delay.
    pub with: MotorRowFit,
}

/// Estimates the delays of any channels by the smallest residual of the motor torque. The delays of one joint are
/// searched in turn, each with the last estimates of the others.
///
/// - `wanted`: indices of channels.
///
/// Returns `None` if the excerpt is too short.
#[must_use]
pub(crate) fn estimate_delays(
    excerpt: &Excerpt,
    reading: &Reading,
    wanted: &[usize],
) -> Option<Vec<DelayEstimate>> {
    let joint = |i: usize| reading.channels().all[i].joint;
    let mut turns: Vec<Vec<usize>> = Vec::new();
    for &channel in wanted {
        let turn = (turns.iter_mut())
            .find(|turn| turn.iter().all(|&other| joint(other) != joint(channel)));
        match turn {
            Some(turn) => turn.push(channel),
            None => turns.push(vec![channel]),
        }
    }
    let rounds = if turns.len() > 1 { TURNS } else { 1 };
    let mut reading = reading.clone();
    let mut found = Vec::new();
    for _ in 0..rounds {
        found.clear();
        for turn in &turns {
            let estimates = estimate_in_turn(excerpt, &reading, turn)?;
            let mut delays = reading.delays().to_vec();
            for estimate in &estimates {
                delays[estimate.channel] = if estimate.found { estimate.delay } else { 0.0 };
            }
            reading = reading.with_delays(&delays);
            found.extend(estimates);
        }
    }
    found.sort_by_key(|estimate| estimate.channel);
    Some(found)
}

/// Estimates the delays of some channels by the smallest residual of the motor torque.
///
/// - `wanted`: indices of channels, at most one per joint.
///
/// The motor row of a joint contains the spring torque of that joint alone, so joints do not affect
/// each other. It has a right-hand side, so a wrong delay cannot shrink the solution instead of
/// fitting it. The search covers -0.05 s to 0.5 s, at most an eighth of the excerpt either way:
/// first in steps of 10 ms with few samples, then in steps of a sample, then by a parabola. Delays
/// with a negative stiffness are rejected.
///
/// Returns `None` if the excerpt is too short.
#[must_use]
fn estimate_in_turn(
    excerpt: &Excerpt,
    reading: &Reading,
    wanted: &[usize],
) -> Option<Vec<DelayEstimate>> {
    let joints = (wanted.iter())
        .map(|&channel| reading.channels().all[channel].joint)
        .collect();
    let search = Search {
        excerpt,
        reading,
        wanted,
        joints,
    };
    let without = search.attempt(&vec![0.0; wanted.len()])?;
    let range = search.range();
    let coarse = COARSE_STEP_S.max(excerpt.period());
    let few = excerpt.thinned_for(reading, coarse / SAMPLES_PER_COARSE_STEP);
    let (mut best, mut step) = search.with_excerpt(&few).scan(range, coarse);
    while step > excerpt.period() {
        let centres: Vec<f64> = best.iter().map(|&(delay, _)| delay).collect();
        let finer = excerpt.period() * (step / excerpt.period() / 10.0).max(1.0).floor();
        // Costs of fewer samples cannot be compared.
        best = centres
            .iter()
            .map(|&centre| (centre, f64::INFINITY))
            .collect();
        search.improve(&centres, (-step, step), finer, &mut best);
        step = finer;
    }
    let refined = search.refine(&best)?;
    let at: Vec<f64> = refined.iter().map(|&(delay, _)| delay).collect();
    let with = search.attempt(&at)?;
    let estimate = |i: usize| {
        let (delay, standard_error) = refined[i];
        let inside = delay > range.0 + 0.5 * coarse && delay < range.1 - 0.5 * coarse;
        let better = with[i].relative_residual <= without[i].relative_residual;
        DelayEstimate {
            channel: wanted[i],
            delay,
            standard_error,
            found: inside && better && best[i].1.is_finite() && standard_error.is_finite(),
            without: without[i],
            with: with[i],
        }
    };
    Some((0..wanted.len()).map(estimate).collect())
}

/// Data of a search for delays.
struct Search<'a> {
    excerpt: &'a Excerpt,
    reading: &'a Reading,
    wanted: &'a [usize],
    // Joint of each channel in `wanted`.
    joints: Vec<usize>,
}

impl Search<'_> {
    fn with_excerpt<'a>(&'a self, excerpt: &'a Excerpt) -> Search<'a> {
        Search {
            excerpt,
            joints: self.joints.clone(),
            ..*self
        }
    }

    /// Tries delays in steps of `coarse`, then in steps of a sample about the best. Returns the best
    /// delay of each channel with its cost, and the last step.
    fn scan(&self, range: (f64, f64), coarse: f64) -> (Vec<(f64, f64)>, f64) {
        let zero = vec![0.0; self.wanted.len()];
        let mut best = vec![(0.0, f64::INFINITY); self.wanted.len()];
        self.improve(&zero, range, coarse, &mut best);
        let period = self.excerpt.period();
        if period >= coarse {
            return (best, coarse);
        }
        let centres: Vec<f64> = best.iter().map(|&(delay, _)| delay).collect();
        self.improve(&centres, (-coarse, coarse), period, &mut best);
        (best, period)
    }

    fn duration(&self) -> f64 {
        self.excerpt.duration()
    }

    fn range(&self) -> (f64, f64) {
        let eighth = self.duration() / 8.0;
        (EARLIEST_S.max(-eighth), LATEST_S.min(eighth))
    }

    /// Returns the fits of the channels' motor rows at given delays.
    fn attempt(&self, at: &[f64]) -> Option<Vec<MotorRowFit>> {
        let mut delays = self.reading.delays().to_vec();
        for (&channel, &delay) in self.wanted.iter().zip(at) {
            delays[channel] = delay;
        }
        let reading = self.reading.with_delays(&delays);
        let fits = fit_rows(self.excerpt, &reading, &self.joints)?;
        Some(fits.iter().map(|fit| fit.short(reading.model())).collect())
    }

    /// Tries delays about the centres and keeps the best delay of each channel.
    fn improve(&self, centres: &[f64], range: (f64, f64), step: f64, best: &mut [(f64, f64)]) {
        let count = ((range.1 - range.0) / step).round() as u32;
        for k in 0..=count {
            let offset = range.0 + f64::from(k) * step;
            let at: Vec<f64> = centres.iter().map(|centre| centre + offset).collect();
            // With a long delay a short log can have too few samples; such a delay is skipped.
            let Some(fits) = self.attempt(&at) else {
                continue;
            };
            for (i, best) in best.iter_mut().enumerate() {
                let fit = &fits[i];
                let cost = fit.relative_residual.powi(2);
                // The stiffness is positive, so minima without it are echoes of a periodic motion.
                if fit.stiffness.is_none_or(|k| k > 0.0) && cost < best.1 {
                    *best = (at[i], cost);
                }
            }
        }
    }

    /// Fits a parabola through the best delay and its neighbours; returns delay and standard error
    /// of each channel, s.
    fn refine(&self, best: &[(f64, f64)]) -> Option<Vec<(f64, f64)>> {
        let period = self.excerpt.period();
        let shifted = |by: f64| {
            let at: Vec<f64> = best.iter().map(|&(delay, _)| delay + by).collect();
            self.attempt(&at)
        };
        let (before, after) = (shifted(-period)?, shifted(period)?);
        let cutoff = self.reading.settings().filter_cutoff_rad_per_s;
        // Filtered residuals are correlated over about 2/λ.
        let independent = (self.duration() * cutoff / 2.0).max(1.0);
        let refine = |(i, &(delay, cost)): (usize, &(f64, f64))| {
            let left = before[i].relative_residual.powi(2);
            let right = after[i].relative_residual.powi(2);
            let curvature = (left - 2.0 * cost + right) / period.powi(2);
            if curvature.is_nan() || curvature <= 0.0 {
                return (delay, f64::INFINITY);
            }
            let slope = (right - left) / (2.0 * period);
            let error = (2.0 * cost / (independent * curvature)).sqrt();
            (delay + (-slope / curvature).clamp(-period, period), error)
        };
        Some(best.iter().enumerate().map(refine).collect())
    }
}
