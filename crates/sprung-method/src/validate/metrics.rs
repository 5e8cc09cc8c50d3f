//! Error measures of streams.

/// Root mean square of a stream of errors.
///
/// # Source
///
/// Eq. (31).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rms {
    squares: f64,
    samples: u64,
}

impl Rms {
    /// Adds the next error.
    pub fn push(&mut self, error: f64) {
        self.squares += error * error;
        self.samples += 1;
    }

    /// Returns the root mean square so far; zero before the first error.
    #[must_use]
    pub fn value(&self) -> f64 {
        (self.squares / self.samples.max(1) as f64).sqrt()
    }
}

/// Standard deviation of a stream of values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    mean: f64,
    squares: f64,
    samples: u64,
}

impl Spread {
    /// Adds the next value.
    ///
    /// # Source
    ///
    /// Welford's recursion.
    pub fn push(&mut self, value: f64) {
        self.samples += 1;
        let before = value - self.mean;
        self.mean += before / self.samples as f64;
        self.squares += before * (value - self.mean);
    }

    /// Returns the standard deviation so far.
    #[must_use]
    pub fn value(&self) -> f64 {
        (self.squares / self.samples.max(1) as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_is_independent_of_the_mean() {
        let mut spread = Spread::default();
        for k in 0..1000 {
            spread.push(1e3 + (std::f64::consts::TAU * f64::from(k) / 1000.0).sin());
        }
        assert!((spread.value() - 0.5_f64.sqrt()).abs() < 1e-9);
    }

    #[test]
    fn rms_of_a_sine_is_its_amplitude_over_root_two() {
        let mut rms = Rms::default();
        for k in 0..1000 {
            rms.push(3.0 * (std::f64::consts::TAU * f64::from(k) / 1000.0).sin());
        }
        assert!((rms.value() - 3.0 / 2.0_f64.sqrt()).abs() < 1e-12);
    }
}
