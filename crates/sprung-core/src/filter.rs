//! The filter pair of the filtered regressor: `f(s) = λ/(s + λ)` and
//! `g(s) = s f(s)`, in discrete time.

/// Discretisation of the continuous pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Discretization {
    /// Zero-order hold, as printed in the paper. It makes every estimated inertia too small by the
    /// factor 1 − λT/2, and part of an inertial torque acts as viscous friction.
    ZeroOrderHold,
    /// Bilinear rule: `g` and `s f` have the same phase.
    Tustin,
}

/// Errors of the settings of a filter pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FilterError {
    /// The named setting is not a positive finite number.
    NotPositive(&'static str),
}

impl core::fmt::Display for FilterError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NotPositive(name) => write!(f, "the {name} must be positive and finite"),
        }
    }
}

impl core::error::Error for FilterError {}

/// Coefficients of the discrete pair; both filters have the same pole.
///
/// `low[k] = -a low[k-1] + f0 x[k] + f1 x[k-1]`, and `g0`, `g1` likewise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterPair {
    a: f64,
    f: [f64; 2],
    g: [f64; 2],
}

/// State of one filtered entry: the contribution of the last inputs to the next output, and the
/// last output.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FilterState {
    carry: f64,
    output: f64,
    started: bool,
}

/// State of many entries that are filtered together. `M` is memory of the caller, a slice, array or
/// vector of [`bank_len`] numbers.
#[derive(Clone, Debug)]
pub struct FilterBank<M> {
    memory: M,
    started: bool,
}

/// Returns the number of `f64` that a [`FilterBank`] needs for `entries` entries.
#[must_use]
pub const fn bank_len(entries: usize) -> usize {
    2 * entries
}

impl FilterState {
    /// Returns the state after a low-pass filter has received the same value for ever.
    #[must_use]
    pub fn settled(pair: &FilterPair, value: f64) -> Self {
        Self {
            carry: pair.carry(0.0, value),
            output: value,
            started: true,
        }
    }
}

impl<M: AsRef<[f64]> + AsMut<[f64]>> FilterBank<M> {
    /// Returns a bank that has not received a sample.
    ///
    /// - `memory`: two numbers per entry; their values do not matter.
    #[must_use]
    pub fn new(memory: M) -> Self {
        Self {
            memory,
            started: false,
        }
    }

    /// Resets the bank: the next sample is the first of a log.
    pub fn restart(&mut self) {
        self.started = false;
    }

    /// Filters one sample of all entries and returns the outputs.
    ///
    /// - `momentum`, `rest`: one number per entry. If one slice is shorter, only its entries are
    ///   filtered.
    ///
    /// The recursions start at rest, as in [`FilterPair::process`].
    pub fn process(&mut self, pair: &FilterPair, momentum: &[f64], rest: &[f64]) -> &[f64] {
        let memory = self.memory.as_mut();
        let (carry, output) = memory.split_at_mut(memory.len() / 2);
        let started = core::mem::replace(&mut self.started, true);
        if !started {
            carry.fill(0.0);
            output.fill(0.0);
        }
        let inputs = momentum.iter().zip(rest);
        for ((output, carry), (momentum, rest)) in output.iter_mut().zip(carry).zip(inputs) {
            let next = pair.step(*carry, *output, *momentum, *rest);
            *output = if started { next } else { 0.0 };
            *carry = pair.carry(*momentum, *rest);
        }
        output
    }
}

impl FilterPair {
    /// Discretises the pair.
    ///
    /// - `cutoff`: λ, rad/s, positive.
    /// - `period`: T, s, positive.
    ///
    /// # Errors
    ///
    /// [`FilterError::NotPositive`] if either value is not positive and finite.
    ///
    /// # Source
    ///
    /// Eqs. (19) and (20) for the zero-order hold.
    pub fn new(
        cutoff: f64,
        period: f64,
        discretization: Discretization,
    ) -> Result<Self, FilterError> {
        if !(cutoff.is_finite() && cutoff > 0.0) {
            return Err(FilterError::NotPositive("filter cut-off"));
        }
        if !(period.is_finite() && period > 0.0) {
            return Err(FilterError::NotPositive("sampling period"));
        }
        let x = cutoff * period;
        Ok(match discretization {
            Discretization::ZeroOrderHold => Self {
                a: -libm::exp(-x),
                f: [0.0, -libm::expm1(-x)],
                g: [cutoff, -cutoff],
            },
            Discretization::Tustin => {
                let d = 2.0 + x;
                Self {
                    a: (x - 2.0) / d,
                    f: [x / d, x / d],
                    g: [2.0 * cutoff / d, -2.0 * cutoff / d],
                }
            }
        })
    }

    /// Returns the pole of both filters. From each sample to the next, an error of the initial
    /// state is multiplied by this pole.
    #[must_use]
    pub fn pole(&self) -> f64 {
        -self.a
    }

    /// Returns the factors of the present and of the last input in the output of the low-pass filter.
    #[must_use]
    pub fn low_pass(&self) -> [f64; 2] {
        self.f
    }

    /// Filters one entry of the regressor and returns `g_D momentum + f_D rest`.
    ///
    /// The recursion starts at rest: the first output is zero. This removes the initial momentum
    /// exactly; otherwise its effect would decay only with the filter.
    ///
    /// # Source
    ///
    /// Eq. (23). The null initial conditions of the paper are valid only for a robot that starts at
    /// rest.
    pub fn process(&self, state: &mut FilterState, momentum: f64, rest: f64) -> f64 {
        let output = if state.started {
            self.step(state.carry, state.output, momentum, rest)
        } else {
            0.0
        };
        *state = FilterState {
            carry: self.carry(momentum, rest),
            output,
            started: true,
        };
        output
    }

    #[inline]
    fn step(&self, carry: f64, output: f64, momentum: f64, rest: f64) -> f64 {
        carry + (self.g[0] * momentum + self.f[0] * rest) - self.a * output
    }

    #[inline]
    fn carry(&self, momentum: f64, rest: f64) -> f64 {
        self.g[1] * momentum + self.f[1] * rest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_must_be_positive() {
        for (cutoff, period, name) in [
            (0.0, 1e-3, "filter cut-off"),
            (f64::NAN, 1e-3, "filter cut-off"),
            (30.0, -1.0, "sampling period"),
            (30.0, f64::INFINITY, "sampling period"),
        ] {
            for discretization in [Discretization::ZeroOrderHold, Discretization::Tustin] {
                let error = FilterPair::new(cutoff, period, discretization).unwrap_err();
                assert_eq!(error, FilterError::NotPositive(name));
            }
        }
    }

    #[test]
    fn low_pass_has_unit_gain_and_rate_of_ramp_is_its_slope() {
        for discretization in [Discretization::ZeroOrderHold, Discretization::Tustin] {
            let pair = FilterPair::new(30.0, 1e-3, discretization).unwrap();
            let (mut low, mut rate) = (FilterState::default(), FilterState::default());
            let (mut y, mut dy) = (0.0, 0.0);
            for k in 0..3000 {
                y = pair.process(&mut low, 0.0, 1.0);
                dy = pair.process(&mut rate, 0.5 * 1e-3 * f64::from(k), 0.0);
            }
            assert!((y - 1.0).abs() < 1e-12);
            let gain = match discretization {
                Discretization::ZeroOrderHold => 0.03 / -libm::expm1(-0.03),
                Discretization::Tustin => 1.0,
            };
            assert!((dy - 0.5 * gain).abs() < 1e-12);
        }
    }
}
