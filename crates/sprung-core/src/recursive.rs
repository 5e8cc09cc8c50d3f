//! Recursive least squares with forgetting factor (LSFF).
//!
//! The gain matrix is stored as `P = U D U^T` with `U` unit upper triangular and `D` diagonal, so
//! it is symmetric by construction and stays positive definite.

/// Errors of the settings or the memory of the estimator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RecursiveError {
    /// The named setting is not a positive finite number.
    NotPositive(&'static str),
    /// The memory of the caller has the wrong length.
    Memory {
        /// Required length, from [`memory_len`].
        expected: usize,
        /// Length of the given memory.
        found: usize,
    },
}

impl core::fmt::Display for RecursiveError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NotPositive(name) => write!(f, "the {name} must be positive and finite"),
            Self::Memory { expected, found } => {
                write!(f, "the memory holds {found} numbers, {expected} are needed")
            }
        }
    }
}

impl core::error::Error for RecursiveError {}

/// Settings of [`ForgettingLeastSquares`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Forgetting rate δ, 1/s, positive: the weight of a sample falls as e^{−δt} with its age t.
    pub forgetting: f64,
    /// Diagonal of `P(0)`, positive.
    pub initial_gain: f64,
    /// Limit of the entries of `D`, positive. Forgetting pauses while an entry would exceed it, so
    /// directions without excitation do not wind up.
    pub gain_limit: f64,
    /// Sampling period T, s, positive.
    pub period: f64,
}

/// Returns the number of `f64` that the estimator needs for `parameters` parameters.
#[must_use]
pub const fn memory_len(parameters: usize) -> usize {
    // theta, D, U, and two work vectors.
    parameters * (parameters + 4)
}

/// The estimator. `M` is memory of the caller: a slice, array or vector.
#[derive(Clone, Debug)]
pub struct ForgettingLeastSquares<M> {
    memory: M,
    parameters: usize,
    growth: f64,
    noise: f64,
    gain_limit: f64,
    paused: u64,
}

impl<M: AsRef<[f64]> + AsMut<[f64]>> ForgettingLeastSquares<M> {
    /// Returns an estimator that starts at theta = 0.
    ///
    /// - `memory`: [`memory_len`]`(parameters)` numbers; their values do not matter.
    ///
    /// # Errors
    ///
    /// [`RecursiveError::NotPositive`] if a setting is not positive and finite,
    /// [`RecursiveError::Memory`] if the memory has the wrong length.
    pub fn new(
        settings: &Settings,
        parameters: usize,
        mut memory: M,
    ) -> Result<Self, RecursiveError> {
        for (name, value) in [
            ("forgetting factor", settings.forgetting),
            ("initial gain", settings.initial_gain),
            ("gain limit", settings.gain_limit),
            ("sampling period", settings.period),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(RecursiveError::NotPositive(name));
            }
        }
        let (expected, found) = (memory_len(parameters), memory.as_ref().len());
        if expected != found {
            return Err(RecursiveError::Memory { expected, found });
        }
        let all = memory.as_mut();
        all.fill(0.0);
        all[parameters..2 * parameters].fill(settings.initial_gain);
        Ok(Self {
            memory,
            parameters,
            growth: libm::exp(settings.forgetting * settings.period),
            noise: 1.0 / settings.period,
            gain_limit: settings.gain_limit,
            paused: 0,
        })
    }

    /// Returns the estimated parameters, \[p\].
    #[must_use]
    pub fn theta(&self) -> &[f64] {
        &self.memory.as_ref()[..self.parameters]
    }

    /// Returns the number of samples at which the gain limit paused forgetting.
    #[must_use]
    pub fn paused(&self) -> u64 {
        self.paused
    }

    /// Returns an entry of the gain matrix `P`, \[p × p\].
    #[must_use]
    pub fn gain(&self, row: usize, column: usize) -> f64 {
        let p = self.parameters;
        let all = self.memory.as_ref();
        let (d, u) = (&all[p..2 * p], &all[2 * p..2 * p + p * p]);
        let entry = |i: usize, k: usize| match i.cmp(&k) {
            core::cmp::Ordering::Less => u[i * p + k],
            core::cmp::Ordering::Equal => 1.0,
            core::cmp::Ordering::Greater => 0.0,
        };
        (0..p)
            .map(|k| entry(row, k) * d[k] * entry(column, k))
            .sum()
    }

    /// Multiplies the gain matrix by e^{δT}. Call it once per sample, before the updates with the
    /// sample's rows.
    pub fn forget(&mut self) {
        let p = self.parameters;
        let d = &mut self.memory.as_mut()[p..2 * p];
        if d.iter().any(|&gain| gain * self.growth > self.gain_limit) {
            self.paused += 1;
            return;
        }
        for gain in d {
            *gain *= self.growth;
        }
    }

    /// Updates the estimate with one row of the filtered regression, `row · theta = rhs`.
    ///
    /// - `row`: row of `Y_f`, \[p\]. Missing entries count as zero; further entries are ignored.
    ///
    /// # Source
    ///
    /// Eq. (30) with corrected transposes: `dtheta = P Y_f^T e`, `dP = δ P - P Y_f^T Y_f P`. Both
    /// are integrated over one period, so `P` stays positive definite. The update of `U` and `D` is
    /// Bierman's.
    pub fn update(&mut self, row: &[f64], rhs: f64) {
        let p = self.parameters;
        let (theta, rest) = self.memory.as_mut().split_at_mut(p);
        let (d, rest) = rest.split_at_mut(p);
        let (u, rest) = rest.split_at_mut(p * p);
        let (f, gain) = rest.split_at_mut(p);

        let mut error = rhs;
        for (value, column) in theta.iter().zip(row) {
            error -= value * column;
        }
        // f = U^T row.
        f.fill(0.0);
        for (i, &column) in row.iter().enumerate().take(p) {
            if column != 0.0 {
                f[i] += column;
                for k in i + 1..p {
                    f[k] += u[i * p + k] * column;
                }
            }
        }
        // Column k of U changes by a multiple of the gain of the columns before k.
        let mut variance = self.noise;
        gain.fill(0.0);
        for k in 0..p {
            let weighted = d[k] * f[k];
            let before = variance;
            variance += weighted * f[k];
            if weighted == 0.0 {
                continue;
            }
            let step = -f[k] / before;
            d[k] *= before / variance;
            for i in 0..k {
                let old = u[i * p + k];
                u[i * p + k] = old + gain[i] * step;
                gain[i] += weighted * old;
            }
            gain[k] += weighted;
        }
        for (value, k) in theta.iter_mut().zip(gain) {
            *value += *k / variance * error;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETTINGS: Settings = Settings {
        forgetting: 1.0,
        initial_gain: 10.0,
        gain_limit: 1e8,
        period: 1e-3,
    };

    /// A deterministic sequence between -1 and 1.
    fn noise(state: &mut u64) -> f64 {
        *state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (*state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    #[test]
    fn equals_the_information_form_of_the_printed_equations() {
        const P: usize = 4;
        let truth = [1.0, -2.0, 0.5, 3.0];
        let mut filter = ForgettingLeastSquares::new(&SETTINGS, P, [0.0; memory_len(P)]).unwrap();
        // Information matrix and vector: H' = e^{-δT} H + T y y^T.
        let mut h = [[0.0; P]; P];
        let mut b = [0.0; P];
        for (i, row) in h.iter_mut().enumerate() {
            row[i] = 0.1;
        }
        let mut seed = 7;
        let decay = libm::exp(-1e-3);
        for _ in 0..500 {
            let y: [f64; P] = core::array::from_fn(|_| noise(&mut seed) * 10.0);
            let rhs = y.iter().zip(truth).map(|(a, b)| a * b).sum::<f64>() + noise(&mut seed);
            filter.forget();
            filter.update(&y, rhs);
            for i in 0..P {
                for (entry, column) in h[i].iter_mut().zip(y) {
                    *entry = decay * *entry + 1e-3 * y[i] * column;
                }
                b[i] = decay * b[i] + 1e-3 * y[i] * rhs;
            }
        }
        // The estimate solves H theta = b exactly.
        for (row, b) in h.iter().zip(b) {
            let left: f64 = row.iter().zip(filter.theta()).map(|(h, x)| h * x).sum();
            assert!((left - b).abs() < 1e-9 * b.abs().max(1.0));
        }
        // P H = I.
        let product = |i: usize, j: usize| -> f64 {
            h.iter()
                .enumerate()
                .map(|(k, row)| filter.gain(i, k) * row[j])
                .sum()
        };
        for i in 0..P {
            for j in 0..P {
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((product(i, j) - expected).abs() < 1e-9, "{i} {j}");
            }
        }
    }

    #[test]
    fn gain_stays_bounded_and_positive_without_excitation() {
        const P: usize = 3;
        let mut filter = ForgettingLeastSquares::new(&SETTINGS, P, [0.0; memory_len(P)]).unwrap();
        let mut seed = 3;
        // One hour at 1 kHz without excitation of the third parameter.
        for _ in 0..3_600_000 {
            let y = [noise(&mut seed), noise(&mut seed), 0.0];
            filter.forget();
            filter.update(&y, 2.0 * y[0] - y[1]);
        }
        assert!(filter.paused() > 0);
        for i in 0..P {
            assert!(filter.gain(i, i) > 0.0 && filter.gain(i, i) <= 1e8);
        }
        // Rounding times the largest gain.
        assert!((filter.theta()[0] - 2.0).abs() < 1e8 * f64::EPSILON);
        assert!(filter.theta()[2].abs() < 1e-12);
    }

    #[test]
    fn settings_that_are_not_positive_and_wrong_memory_are_refused() {
        let settings = Settings {
            forgetting: f64::NAN,
            ..SETTINGS
        };
        assert_eq!(
            ForgettingLeastSquares::new(&settings, 1, [0.0; 5]).unwrap_err(),
            RecursiveError::NotPositive("forgetting factor")
        );
        assert_eq!(
            ForgettingLeastSquares::new(&SETTINGS, 2, [0.0; 5]).unwrap_err(),
            RecursiveError::Memory {
                expected: 12,
                found: 5
            }
        );
    }
}
