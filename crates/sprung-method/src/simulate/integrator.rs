//! Explicit Runge-Kutta steps of order 5 with error control (Dormand-Prince).
//!
//! Motor friction is stiff only while a velocity crosses zero: its rate is above 2000 1/s in the
//! tanh transition and 20 to 60 1/s outside. Error control takes one step per sampling period
//! outside and a few steps inside. This costs a third of a fixed step that is small enough for the
//! transition, and it bounds the error. An implicit method would need a Jacobian in every step.

const STAGES: usize = 7;

const A: [[f64; STAGES - 1]; STAGES] = [
    [0.0; 6],
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [
        19372.0 / 6561.0,
        -25360.0 / 2187.0,
        64448.0 / 6561.0,
        -212.0 / 729.0,
        0.0,
        0.0,
    ],
    [
        9017.0 / 3168.0,
        -355.0 / 33.0,
        46732.0 / 5247.0,
        49.0 / 176.0,
        -5103.0 / 18656.0,
        0.0,
    ],
    // The last stage is the solution of order 5.
    [
        35.0 / 384.0,
        0.0,
        500.0 / 1113.0,
        125.0 / 192.0,
        -2187.0 / 6784.0,
        11.0 / 84.0,
    ],
];

/// Order 5 minus order 4.
const E: [f64; STAGES] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// The integrator reached its limit of steps, because the accelerations are too large.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepsExhausted;

/// Integrates autonomous differential equations over fixed periods.
#[derive(Clone, Debug)]
pub(crate) struct Integrator {
    tolerance: f64,
    step: f64,
    // Slopes, one vector per stage.
    slopes: [Vec<f64>; STAGES],
    y: Vec<f64>,
}

impl Integrator {
    /// Returns an integrator of `states` states.
    ///
    /// - `tolerance`: largest accepted error of a step in any state, in the state's unit, positive.
    #[must_use]
    pub(crate) fn new(tolerance: f64, states: usize) -> Self {
        Self {
            tolerance,
            step: f64::INFINITY,
            slopes: std::array::from_fn(|_| vec![0.0; states]),
            y: vec![0.0; states],
        }
    }

    /// Integrates the state `x` over `duration`, s.
    ///
    /// - `rate`: takes a state and writes its time derivative.
    ///
    /// # Errors
    ///
    /// [`StepsExhausted`] after ten thousand steps; a state that is not finite also leads to it.
    pub(crate) fn advance(
        &mut self,
        x: &mut [f64],
        duration: f64,
        mut rate: impl FnMut(&[f64], &mut [f64]),
    ) -> Result<(), StepsExhausted> {
        let mut left = duration;
        rate(x, &mut self.slopes[0]);
        for _ in 0..10_000 {
            // Equal steps avoid a very short last step.
            let count = (left / self.step).ceil().max(1.0);
            let h = left / count;
            for (stage, weights) in A.iter().enumerate().skip(1) {
                self.y.copy_from_slice(x);
                let (done, rest) = self.slopes.split_at_mut(stage);
                for (weight, slope) in weights.iter().zip(done) {
                    if *weight != 0.0 {
                        for (y, s) in self.y.iter_mut().zip(slope) {
                            *y += h * weight * *s;
                        }
                    }
                }
                rate(&self.y, &mut rest[0]);
            }
            let mut error: f64 = 0.0;
            for i in 0..x.len() {
                let e: f64 = (E.iter().zip(&self.slopes))
                    .map(|(weight, slope)| weight * slope[i])
                    .sum();
                error = error.max((h * e).abs());
                if e.is_nan() {
                    error = f64::INFINITY;
                }
            }
            let ratio = error / self.tolerance;
            let factor = 0.9 * ratio.max(1e-10).powf(-0.2);
            self.step = h * factor.clamp(0.2, 4.0);
            if ratio <= 1.0 {
                x.copy_from_slice(&self.y);
                if count < 1.5 {
                    return Ok(());
                }
                left -= h;
                self.slopes.swap(0, STAGES - 1);
            }
        }
        Err(StepsExhausted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oscillator_keeps_its_phase() {
        const TOLERANCE: f64 = 1e-11;
        let mut integrator = Integrator::new(TOLERANCE, 2);
        let mut x = [1.0, 0.0];
        for _ in 0..1000 {
            integrator
                .advance(&mut x, 1e-2, |x, rate| {
                    rate.copy_from_slice(&[x[1], -25.0 * x[0]]);
                })
                .unwrap();
        }
        // Nothing damps the oscillator, so the errors of 1000 periods, each below the tolerance, may add up; the
        // velocity is five times as large as the position.
        let limit = 1000.0 * TOLERANCE;
        assert!((x[0] - 50.0_f64.cos()).abs() < limit);
        assert!((x[1] + 5.0 * 50.0_f64.sin()).abs() < 5.0 * limit);
    }

    #[test]
    fn finite_escape_time_is_an_error() {
        let mut integrator = Integrator::new(1e-9, 1);
        let mut x = [1.0];
        // x' = x² reaches infinity at t = 1.
        assert_eq!(
            integrator.advance(&mut x, 2.0, |x, rate| rate[0] = x[0] * x[0]),
            Err(StepsExhausted)
        );
    }
}
