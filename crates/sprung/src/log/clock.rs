//! Even sampling.

use super::{LogError, Place};

/// Deviation of a step from the period that is tolerated, as a part of it.
///
/// Treating a sample as if it came a tenth of a period off misplaces a joint
/// at 1 rad/s and 1 kHz by 1e-4 rad, as much as an encoder with 16384 counts
/// (standard deviation of its quantisation: 1.1e-4 rad).
pub const JITTER_LIMIT: f64 = 0.1;

/// A step of at least this many periods is a gap: the log goes on as if it
/// began anew.
const GAP: f64 = 1.5;

const LEARNING: usize = 256;

/// Gaps of a log.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gaps {
    /// How many.
    pub count: u64,
    /// How long together, s.
    pub duration: f64,
}

/// Checks that time goes forward in even steps.
#[derive(Clone, Debug)]
pub struct Clock {
    file: String,
    samples: u64,
    first: f64,
    last: f64,
    // Steps of the first samples, kept until the period is known.
    early: Vec<(Place, u64, f64)>,
    period: Option<f64>,
    worst: f64,
    gaps: Gaps,
    // Samples after gaps that nobody has asked for, from 0.
    found: Vec<u64>,
}

impl Clock {
    /// Returns a clock that has seen nothing.
    #[must_use]
    pub fn new(file: &str) -> Self {
        Self {
            file: file.to_owned(),
            samples: 0,
            first: 0.0,
            last: 0.0,
            early: Vec::new(),
            period: None,
            worst: 0.0,
            gaps: Gaps::default(),
            found: Vec::new(),
        }
    }

    /// Takes the time of the next sample, in s, found at `place`.
    ///
    /// # Errors
    ///
    /// [`LogError::TimeNotIncreasing`] or [`LogError::Uneven`].
    pub fn tick(&mut self, place: Place, time: f64) -> Result<(), LogError> {
        self.samples += 1;
        let before = std::mem::replace(&mut self.last, time);
        if self.samples == 1 {
            self.first = time;
            return Ok(());
        }
        let step = time - before;
        if step <= 0.0 {
            return Err(LogError::TimeNotIncreasing {
                file: self.file.clone(),
                place,
                before,
                after: time,
            });
        }
        let sample = self.samples - 1;
        if let Some(period) = self.period {
            return self.judge(place, sample, step, period);
        }
        self.early.push((place, sample, step));
        if self.early.len() == LEARNING {
            self.learn()?;
        }
        Ok(())
    }

    /// Ends the log: short ones are judged now.
    ///
    /// # Errors
    ///
    /// [`LogError::TooShort`] for fewer than two samples, or
    /// [`LogError::Uneven`].
    pub fn finish(&mut self) -> Result<(), LogError> {
        if self.samples < 2 {
            return Err(LogError::TooShort {
                file: self.file.clone(),
                found: self.samples,
                needed: 2,
                why: "a sampling period is the time between two samples".to_owned(),
            });
        }
        if self.period.is_none() {
            self.learn()?;
        }
        Ok(())
    }

    /// Returns the sampling period, s, once it is known.
    #[must_use]
    pub fn period(&self) -> Option<f64> {
        self.period
    }

    /// Returns the number of samples so far.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Returns the time between the first and the last sample so far, s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.last - self.first
    }

    /// Returns the largest deviation of a step from the period, as a part of
    /// the period.
    #[must_use]
    pub fn jitter(&self) -> f64 {
        self.worst
    }

    /// Returns the gaps so far.
    #[must_use]
    pub fn gaps(&self) -> Gaps {
        self.gaps
    }

    /// Returns the samples after gaps, counted from 0, that were found since it
    /// was last asked.
    pub fn new_gaps(&mut self) -> Vec<u64> {
        std::mem::take(&mut self.found)
    }

    fn learn(&mut self) -> Result<(), LogError> {
        let early = std::mem::take(&mut self.early);
        let mut steps: Vec<f64> = early.iter().map(|&(_, _, step)| step).collect();
        steps.sort_by(f64::total_cmp);
        let median = steps[steps.len() / 2];
        // The mean over the window: times may be printed with so few digits
        // that single steps are off by several percent. Gaps would bias it.
        steps.retain(|step| *step < GAP * median);
        let mean = steps.iter().sum::<f64>() / steps.len() as f64;
        let biased = (mean - median).abs() > JITTER_LIMIT * median;
        let period = if biased { median } else { mean };
        self.period = Some(period);
        for (place, sample, step) in early {
            self.judge(place, sample, step, period)?;
        }
        Ok(())
    }

    fn judge(&mut self, place: Place, sample: u64, step: f64, period: f64) -> Result<(), LogError> {
        if step >= GAP * period {
            self.gaps.count += 1;
            self.gaps.duration += step - period;
            self.found.push(sample);
            return Ok(());
        }
        let deviation = (step - period).abs() / period;
        self.worst = self.worst.max(deviation);
        if deviation <= JITTER_LIMIT {
            return Ok(());
        }
        Err(LogError::Uneven {
            file: self.file.clone(),
            place,
            step_ms: step * 1e3,
            period_ms: period * 1e3,
            percent: 100.0 * deviation,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(times: impl Iterator<Item = f64>) -> Result<Clock, LogError> {
        let mut clock = Clock::new("log.csv");
        for (k, time) in times.enumerate() {
            clock.tick(Place::Line(k as u64 + 2), time)?;
        }
        clock.finish()?;
        Ok(clock)
    }

    #[test]
    fn period_of_rounded_times_is_unbiased() {
        // 960 Hz printed with four decimals: steps of 1.0 and 1.1 ms.
        let times = (0..5000).map(|k| (f64::from(k) / 960.0 * 1e4).round() / 1e4);
        let period = run(times).unwrap().period().unwrap();
        assert!((period * 960.0 - 1.0).abs() < 1e-3, "{period}");
    }

    #[test]
    fn gaps_are_counted_and_placed() {
        let late = |k: i32| k + 3 * i32::from(k > 100) + 40 * i32::from(k > 400);
        let mut clock = run((0..500).map(|k| f64::from(late(k)) * 1e-3)).unwrap();
        assert!((clock.period().unwrap() - 1e-3).abs() < 1e-12);
        assert_eq!(clock.gaps().count, 2);
        assert!((clock.gaps().duration - 0.043).abs() < 1e-9);
        assert_eq!(clock.new_gaps(), [101, 401]);
        assert!(clock.new_gaps().is_empty());
    }

    #[test]
    fn a_step_that_is_no_gap_is_refused() {
        let times = (0..500).map(|k| f64::from(k) * 1e-3 + if k > 100 { 3e-4 } else { 0.0 });
        let error = run(times).unwrap_err().to_string();
        assert!(
            error.starts_with("line 103 of log.csv: 1.3000 ms"),
            "{error}"
        );
    }
}
