//! Finds the clock of the samples from late or inexact time stamps.

/// Default tolerance for the deviation of a step from the period, as a fraction of the period.
///
/// A time error of a tenth of a period misplaces a joint that moves at 1 rad/s and is sampled at 1
/// kHz by 1e-4 rad. This is about the quantisation noise of an encoder with 16384 counts (standard
/// deviation 1.1e-4 rad).
pub(crate) const JITTER_LIMIT: f64 = 0.1;

/// Steps above this multiple of the median may span missing samples, so they do not enter the
/// period.
const MAX_SINGLE_STEP: f64 = 1.5;

/// A step of at least this number of periods is a gap, and a new segment begins after it. In
/// shorter steps the missing samples, at most three, are interpolated.
pub(crate) const GAP_PERIODS: f64 = 4.5;

/// Number of stamps examined to detect a late stamp: the stamps after a late one follow at short
/// intervals.
pub(crate) const LOOK_AHEAD_SAMPLES: usize = 32;

/// Fraction of a stamp's deviation by which the clock is corrected. It is large enough to follow
/// the drift of clocks, a few parts in 10 000, and small enough to ignore single late stamps.
const CLOCK_GAIN: f64 = 1.0 / 64.0;

/// Range in which the period is searched about the usual step, as a fraction of it, and number of
/// samples of the first search.
const PERIOD_SEARCH_PART: f64 = 0.05;
const FIRST_SEARCH_SAMPLES: usize = 128;

/// The search keeps the given period unless its resolution, as a fraction of the period, is finer
/// than this.
const PERIOD_TOLERANCE: f64 = 1e-2;

/// Deviations are clipped at this fraction of a cycle before they correct the clock.
const CLIPPED_PHASE: f64 = 0.25;

/// Returns the usual step between time stamps; 0 if there is no step.
pub(crate) fn usual_step(times: &[f64]) -> f64 {
    let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    let Some(&median) = steps.get(steps.len() / 2) else {
        return 0.0;
    };
    if median <= 0.0 {
        return steps.iter().sum::<f64>() / steps.len() as f64;
    }
    // The mean over all steps is used, because stamps with few digits put errors of several percent
    // on single steps. Gaps are excluded, because they would bias the mean.
    steps.retain(|step| *step < MAX_SINGLE_STEP * median);
    let mean = steps.iter().sum::<f64>() / steps.len() as f64;
    let even = |step: &f64| (step - mean).abs() <= JITTER_LIMIT * mean;
    if steps.iter().all(even) { mean } else { median }
}

/// A clock that ticks once per cycle, found from stamps that may be late.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cycle {
    // In s.
    period: f64,
    // Time of tick 0, s.
    base: f64,
    // Tick of the last sample; `None` before the first.
    index: Option<f64>,
}

impl Cycle {
    /// Returns a clock whose tick 0 is at the first of `times`.
    pub(crate) fn new(cycle: f64, times: &[f64]) -> Self {
        let first = times.first().copied().unwrap_or_default();
        Self {
            period: cycle,
            base: first + phase(cycle, first, times),
            index: None,
        }
    }

    /// Returns a clock whose tick `index` was at the stamp `last`.
    pub(crate) fn after(cycle: f64, last: f64, index: f64, times: &[f64]) -> Self {
        Self {
            period: cycle,
            base: last + phase(cycle, last, times) - index * cycle,
            index: Some(index),
        }
    }

    /// Returns the tick of the next sample, a whole number above the last one.
    ///
    /// - `times`: stamps of this sample and of later ones; the first [`LOOK_AHEAD_SAMPLES`] are used.
    ///
    /// Stamps may be late but not early, and there is at most one sample per tick. Therefore the
    /// tick is at most the tick nearest to each later stamp, minus the number of samples up to that
    /// stamp.
    pub(crate) fn next(&mut self, times: &[f64]) -> f64 {
        let nearest = |time: f64| ((time - self.base) / self.period).round();
        let bounds = times.iter().take(LOOK_AHEAD_SAMPLES).enumerate();
        let mut index = bounds
            .map(|(k, &time)| nearest(time) - k as f64)
            .fold(f64::INFINITY, f64::min);
        if let Some(before) = self.index {
            index = index.max(before + 1.0);
        }
        let time = times.first().copied().unwrap_or_default();
        let deviation = time - self.base - index * self.period;
        if deviation.is_finite() {
            let clip = CLIPPED_PHASE * self.period;
            self.base += CLOCK_GAIN * deviation.clamp(-clip, clip);
        }
        self.index = Some(index);
        index
    }

    /// Returns the time of the last tick, s, including the mean lateness of the stamps.
    pub(crate) fn time(&self) -> f64 {
        self.base + self.index.unwrap_or_default() * self.period
    }

    /// Defines the tick of the next sample as tick 0.
    ///
    /// - `times`: stamp of this sample and those that follow.
    pub(crate) fn begin(&mut self, times: &[f64]) {
        self.index = None;
        // If the first stamp is late, the stamps after it follow at short intervals.
        let index = self.next(times);
        self.base += index * self.period;
        self.index = Some(0.0);
    }

    /// Finds the phase of the ticks again and restarts at tick 0, for example after a gap.
    pub(crate) fn restart(&mut self, times: &[f64]) {
        *self = Self::new(self.period, times);
        self.begin(times);
    }
}

/// Returns the phase of the ticks relative to `from`, in s, between minus and plus half a cycle.
fn phase(cycle: f64, from: f64, times: &[f64]) -> f64 {
    let (sine, cosine) = coherence(cycle, from, times);
    sine.atan2(cosine) * cycle / std::f64::consts::TAU
}

/// Returns the sums of the sines and of the cosines of the stamps' phase angles within the cycle.
fn coherence(cycle: f64, from: f64, times: &[f64]) -> (f64, f64) {
    let turn = std::f64::consts::TAU / cycle;
    let (mut sine, mut cosine) = (0.0, 0.0);
    for time in times {
        let angle = turn * (time - from);
        if angle.is_finite() {
            sine += angle.sin();
            cosine += angle.cos();
        }
    }
    (sine, cosine)
}

/// Returns the cycle within [`PERIOD_SEARCH_PART`] of `cycle` that fits the stamps best.
///
/// The result is the peak of the stamps' periodogram. Occasional late stamps and missing samples
/// shift the mean and the median of the steps, but they hardly shift this peak.
pub(crate) fn refined(cycle: f64, times: &[f64]) -> f64 {
    let Some(&first) = times.first() else {
        return cycle;
    };
    let mut count = FIRST_SEARCH_SAMPLES.min(times.len());
    // The width of the peak is one turn over all stamps, a fraction 1/count of the cycle.
    let mut best = highest(
        cycle,
        PERIOD_SEARCH_PART,
        0.1 / count as f64,
        first,
        &times[..count],
    );
    while count < times.len() {
        let reach = 0.5 / count as f64;
        count = (2 * count).min(times.len());
        best = highest(best, reach, 0.1 / count as f64, first, &times[..count]);
    }
    let width = 0.1 / count as f64;
    if width < PERIOD_TOLERANCE {
        highest(best, width, 0.02 * width, first, times)
    } else {
        cycle
    }
}

/// Returns the cycle near `cycle` that fits the stamps best.
///
/// - `reach`, `step`: range and resolution of the search, as fractions of `cycle`.
fn highest(cycle: f64, reach: f64, step: f64, first: f64, times: &[f64]) -> f64 {
    let steps = (reach / step).ceil() as i32;
    let (mut best, mut most) = (cycle, f64::NEG_INFINITY);
    for k in -steps..=steps {
        let tried = cycle * (1.0 + f64::from(k) * step);
        let (sine, cosine) = coherence(tried, first, times);
        if sine.hypot(cosine) > most {
            (best, most) = (tried, sine.hypot(cosine));
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn period_of_rounded_times_is_unbiased() {
        // Times at 960 Hz, printed with four decimals, have steps of 1.0 and 1.1 ms.
        let times: Vec<f64> = (0..257)
            .map(|k| (f64::from(k) / 960.0 * 1e4).round() / 1e4)
            .collect();
        let period = usual_step(&times);
        // The first and the last stamp are rounded by up to 0.05 ms each.
        let limit = 2.0 * 0.05e-3 / (256.0 / 960.0);
        assert!((period * 960.0 - 1.0).abs() < limit, "{period}");
    }

    #[test]
    fn ticks_are_found_from_late_stamps() {
        // Every stamp is late by up to a third of a cycle. Every 500th stamp is 2.1 cycles late, so
        // the stamps after it follow at once. One tick is missing. The cycle is longer than 1 ms by
        // a factor of 1 + 1e-4.
        let ticks: Vec<f64> = (0..3000).filter(|k| *k != 700).map(f64::from).collect();
        let mut state = 1_u64;
        let mut times: Vec<f64> = Vec::new();
        for (k, tick) in ticks.iter().enumerate() {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            let late = (state >> 40) as f64 / f64::from(1 << 24) / 3.0;
            let late = if k % 500 == 250 { 2.1 } else { late };
            let time = 5.0 + 1e-3 * 1.0001 * (tick + late);
            let after = times.last().map_or(0.0, |last| last + 1e-6);
            times.push(time.max(after));
        }
        let cycle = refined(1e-3, &times);
        // Least squares find the slope of n even stamps with a standard error of √12 σ / n^1.5. A uniform lateness of
        // up to a third of a cycle has √12 σ = 1/3.
        let standard_error = (ticks.len() as f64).powf(-1.5) / 3.0;
        let error = (cycle / 1.0001e-3 - 1.0).abs();
        assert!(error < 4.0 * standard_error, "{cycle}");
        for cycle in [cycle, 1e-3] {
            let mut clock = Cycle::new(cycle, &times[..LOOK_AHEAD_SAMPLES]);
            for (k, tick) in ticks.iter().enumerate() {
                let told = clock.next(&times[k..]);
                assert!((told - tick).abs() < 0.5, "{k}: {told} for {tick}");
                let late = clock.time() - 5.0 - 1.0001e-3 * tick;
                // A mean of latenesses is between the least and the largest of them.
                assert!((0.0..1.0001e-3 / 3.0).contains(&late), "{k}: {late}");
            }
        }
    }
}
