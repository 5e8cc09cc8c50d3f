//! Velocity from positions on line, by two moving averages.

/// Largest window of each average, samples.
pub const LONGEST_WINDOW: usize = 32;

const MEMORY: usize = 2 * LONGEST_WINDOW;

/// Errors of the settings of a velocity estimator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum VelocityError {
    /// A window is longer than [`LONGEST_WINDOW`].
    WindowTooLong {
        /// Samples of the window, `p + 1`.
        samples: usize,
        /// Largest allowed number of samples.
        limit: usize,
    },
    /// The sampling period is not a positive finite number.
    PeriodNotPositive,
}

impl core::fmt::Display for VelocityError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::WindowTooLong { samples, limit } => write!(
                f,
                "the velocity window has {samples} samples, the longest is {limit}"
            ),
            Self::PeriodNotPositive => {
                write!(f, "the sampling period must be positive and finite")
            }
        }
    }
}

impl core::error::Error for VelocityError {}

/// Velocity estimator. It averages positions over `p1 + 1` samples, and the difference quotients of
/// these averages over `p2 + 1` samples.
#[derive(Clone, Copy, Debug)]
pub struct AveragedVelocity {
    positions: [f64; MEMORY],
    newest: usize,
    started: bool,
    position_window: usize,
    rate_window: usize,
    scale: f64,
}

impl AveragedVelocity {
    /// Returns an estimator that has not received a sample.
    ///
    /// - `p1`, `p2`: the windows hold `p1 + 1` and `p2 + 1` samples.
    /// - `period`: sampling period T, s, positive.
    ///
    /// # Errors
    ///
    /// [`VelocityError::WindowTooLong`] for a window of more than [`LONGEST_WINDOW`] samples,
    /// [`VelocityError::PeriodNotPositive`] if the period is not positive and finite.
    ///
    /// # Source
    ///
    /// Eqs. (25) and (26).
    pub fn new(p1: usize, p2: usize, period: f64) -> Result<Self, VelocityError> {
        for p in [p1, p2] {
            if p >= LONGEST_WINDOW {
                return Err(VelocityError::WindowTooLong {
                    samples: p.saturating_add(1),
                    limit: LONGEST_WINDOW,
                });
            }
        }
        if !(period.is_finite() && period > 0.0) {
            return Err(VelocityError::PeriodNotPositive);
        }
        let (position_window, rate_window) = (p1 + 1, p2 + 1);
        Ok(Self {
            positions: [0.0; MEMORY],
            newest: 0,
            started: false,
            position_window,
            rate_window,
            scale: 1.0 / (period * (position_window * rate_window) as f64),
        })
    }

    /// Takes the next position, rad (m), and returns the velocity, rad/s (m/s).
    ///
    /// The joint is assumed to rest at the first position before the first sample.
    pub fn process(&mut self, position: f64) -> f64 {
        if !self.started {
            self.positions = [position; MEMORY];
            self.started = true;
        }
        self.newest = (self.newest + 1) % MEMORY;
        self.positions[self.newest] = position;
        // The sum of the difference quotients telescopes, so only the two ends of the rate window
        // remain.
        let mut difference = 0.0;
        for age in 0..self.position_window {
            difference += self.past(age) - self.past(age + self.rate_window);
        }
        difference * self.scale
    }

    fn past(&self, age: usize) -> f64 {
        self.positions[(self.newest + MEMORY - age) % MEMORY]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equals_the_printed_averages() {
        let (p1, p2, period) = (4_usize, 3_usize, 1e-3);
        let signal = |k: i64| {
            let t = k.max(0) as f64 * period;
            libm::sin(7.0 * t) + 0.3 * t
        };
        let mean = |k: i64| (0..=p1 as i64).map(|j| signal(k - j)).sum::<f64>() / (p1 + 1) as f64;
        let mut estimator = AveragedVelocity::new(p1, p2, period).unwrap();
        for k in 0..200 {
            let v = estimator.process(signal(k));
            let printed = (0..=p2 as i64)
                .map(|j| (mean(k - j) - mean(k - j - 1)) / period)
                .sum::<f64>()
                / (p2 + 1) as f64;
            assert!((v - printed).abs() < 1e-11, "{k}: {v} {printed}");
        }
    }

    #[test]
    fn a_joint_at_rest_has_velocity_zero_and_long_windows_are_refused() {
        let mut estimator = AveragedVelocity::new(4, 4, 1e-3).unwrap();
        for _ in 0..20 {
            assert!(estimator.process(0.7).abs() < 1e-15);
        }
        assert_eq!(
            AveragedVelocity::new(4, 32, 1e-3).unwrap_err(),
            VelocityError::WindowTooLong {
                samples: 33,
                limit: 32
            }
        );
    }
}
