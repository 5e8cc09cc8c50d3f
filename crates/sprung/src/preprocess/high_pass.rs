//! The high-pass filter of deflections from gyroscopes.
//!
//! A gyroscope gives the rate of the deflection e, and its integral drifts. The rows of a joint with
//! gyroscope pass the filter `h = s²/(s + w)²`, and h e follows from motor position and gyroscope
//! without drift:
//!
//! ```text
//! h e = h phi - s/(s + w)² dq
//! ```
//!
//! Both sides of a row pass the same filter, so the row stays exact. A constant bias of the rate has no
//! effect on h e after the filter has settled.

/// Time after a start in which the filter settles, in time constants: the rest of a constant rate is below
/// 1.5 %.
const SETTLING_TIME_CONSTANTS: f64 = 6.0;

/// One stage `s/(s + w)` and `1/(s + w)`, by Tustin's rule.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HighPass {
    decay: f64,
    /// Gain of differences.
    high: f64,
    /// Gain of sums, s.
    low: f64,
    settling: u64,
}

/// State of one stage.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Stage {
    input: f64,
    output: f64,
}

impl HighPass {
    /// - `corner`: w, rad/s; `period`: T, s.
    pub(crate) fn new(corner: f64, period: f64) -> Self {
        let c = 2.0 / period;
        Self {
            decay: (c - corner) / (c + corner),
            high: c / (c + corner),
            low: (c + corner).recip(),
            settling: (SETTLING_TIME_CONSTANTS / (corner * period)).ceil() as u64,
        }
    }

    /// Returns the number of samples in which the filter settles.
    pub(crate) fn settling(&self) -> u64 {
        self.settling
    }

    /// Returns the output of `s/(s + w)`.
    fn rise(&self, stage: &mut Stage, input: f64) -> f64 {
        stage.output = self.decay * stage.output + self.high * (input - stage.input);
        stage.input = input;
        stage.output
    }

    /// Returns the output of `1/(s + w)`.
    fn sum(&self, stage: &mut Stage, input: f64) -> f64 {
        stage.output = self.decay * stage.output + self.low * (input + stage.input);
        stage.input = input;
        stage.output
    }

    /// Returns the output of `s²/(s + w)²`.
    pub(crate) fn process(&self, [first, second]: &mut [Stage; 2], input: f64) -> f64 {
        let once = self.rise(first, input);
        self.rise(second, once)
    }
}

/// The filtered deflection of a joint from its motor position and the rate of its link.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct DeflectionFilter {
    motor: [Stage; 2],
    link: [Stage; 2],
    has_begun: bool,
}

impl DeflectionFilter {
    /// Returns h e, rad.
    ///
    /// - `phi`: motor position, rad; `rate`: rate of the link, rad/s.
    pub(crate) fn process(&mut self, filter: &HighPass, phi: f64, rate: f64) -> f64 {
        if !self.has_begun {
            self.has_begun = true;
            self.motor[0].input = phi;
            self.link[0].input = rate;
            return 0.0;
        }
        let [integral, high] = &mut self.link;
        let integral = filter.sum(integral, rate);
        filter.process(&mut self.motor, phi) - filter.rise(high, integral)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deflections_from_rates_equal_filtered_deflections() {
        let (corner, period) = (1.3, 1e-3);
        let filter = HighPass::new(corner, period);
        let mut own = DeflectionFilter::default();
        let mut exact = [Stage::default(); 2];
        let mut worst = 0.0_f64;
        for k in 0..20_000_u64 {
            let t = k as f64 * period;
            let deflection = 0.05 * (7.0 * t).sin();
            let q = (2.0 * t).sin();
            // The rate has a bias of 0.02 rad/s.
            let rate = 2.0 * (2.0 * t).cos() + 0.02;
            let found = own.process(&filter, q + deflection, rate);
            let expected = filter.process(&mut exact, deflection);
            if k > 2 * filter.settling() {
                worst = worst.max((found - expected).abs());
            }
        }
        // The rest of the bias and the error of the integration, measured 7e-6.
        assert!(worst < 3e-5, "{worst:e}");
    }
}
