//! Input shapers: sequences of impulses that excite no vibration of a mode, and the filter that
//! convolves commands with such a sequence.

use core::f64::consts::PI;

use crate::links::LengthError;

/// Longest delay of a sampled sequence, samples.
pub const LONGEST_DELAY: usize = 1 << 24;

/// Largest deviation from 1 of a sum of amplitudes.
const SUM_TOLERANCE: f64 = 1e-9;

/// An impulse that is nearer to a sample belongs to this sample, in sampling periods.
const NEAR_SAMPLE: f64 = 1e-9;

/// Errors of modes, sequences and shapers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ShaperError {
    /// The named setting is not a positive finite number.
    NotPositive(&'static str),
    /// A damping ratio is not in [0, 1).
    Damping,
    /// A residual level is not between 0 and 1.
    Level,
    /// A sequence has no impulse.
    Empty,
    /// The time of an impulse is negative or not finite.
    Time,
    /// An impulse comes later than [`LONGEST_DELAY`].
    TooLate,
    /// The amplitudes are not finite, or their sum is not 1.
    Sum,
    /// A rest value is not finite.
    NotFinite,
    /// A slice has the wrong length.
    Length(LengthError),
}

impl core::fmt::Display for ShaperError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NotPositive(name) => write!(f, "the {name} must be positive and finite"),
            Self::Damping => write!(f, "the damping ratio must be at least 0 and less than 1"),
            Self::Level => write!(f, "the residual level must be between 0 and 1"),
            Self::Empty => write!(f, "the sequence has no impulse"),
            Self::Time => write!(f, "the times of impulses must be finite and at least 0"),
            Self::TooLate => write!(
                f,
                "an impulse comes later than {LONGEST_DELAY} samples after the first"
            ),
            Self::Sum => write!(f, "the amplitudes must be finite and have the sum 1"),
            Self::NotFinite => write!(f, "the rest values must be finite"),
            Self::Length(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for ShaperError {}

impl From<LengthError> for ShaperError {
    fn from(error: LengthError) -> Self {
        Self::Length(error)
    }
}

/// An impulse of a sequence. The amplitudes of a sequence have the sum 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impulse {
    /// Time after the command, s.
    pub time: f64,
    /// Part of the command.
    pub amplitude: f64,
}

/// An impulse of a sampled sequence.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tap {
    /// Time after the command, samples.
    pub delay: usize,
    /// Part of the command.
    pub weight: f64,
}

/// A lightly damped mode of vibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    frequency: f64,
    damping: f64,
}

impl Mode {
    /// Returns a mode.
    ///
    /// - `frequency`: natural frequency without damping, rad/s, positive.
    /// - `damping`: damping ratio, in [0, 1).
    ///
    /// # Errors
    ///
    /// [`ShaperError::NotPositive`] or [`ShaperError::Damping`] if a value is outside its range.
    pub fn new(frequency: f64, damping: f64) -> Result<Self, ShaperError> {
        positive(frequency, "natural frequency")?;
        if !(0.0..1.0).contains(&damping) {
            return Err(ShaperError::Damping);
        }
        Ok(Self { frequency, damping })
    }

    /// Returns a mode from its natural frequency in Hz.
    ///
    /// # Errors
    ///
    /// Those of [`Mode::new`].
    pub fn from_hz(hz: f64, damping: f64) -> Result<Self, ShaperError> {
        Self::new(2.0 * PI * hz, damping)
    }

    /// Returns the natural frequency, rad/s.
    #[must_use]
    pub fn frequency(&self) -> f64 {
        self.frequency
    }

    /// Returns the natural frequency, Hz.
    #[must_use]
    pub fn hz(&self) -> f64 {
        self.frequency / (2.0 * PI)
    }

    /// Returns the damping ratio.
    #[must_use]
    pub fn damping(&self) -> f64 {
        self.damping
    }

    /// Returns the frequency of the decaying vibration, rad/s.
    #[must_use]
    pub fn damped_frequency(&self) -> f64 {
        self.frequency * libm::sqrt((1.0 - self.damping) * (1.0 + self.damping))
    }
}

fn positive(value: f64, name: &'static str) -> Result<(), ShaperError> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(ShaperError::NotPositive(name))
    }
}

/// Returns the sequence of `N` impulses whose residual vibration, and its first `N - 2` derivatives
/// by the frequency, vanish at the mode: ZV for 2 impulses, ZVD for 3, ZVDD for 4.
///
/// The impulses are half a damped period apart. The amplitudes are
/// `binomial(N - 1, i) K^i / (1 + K)^(N - 1)` with `K = exp(-πζ / sqrt(1 - ζ²))`.
///
/// # Source
///
/// singer1990.
#[must_use]
pub fn zero_vibration<const N: usize>(mode: &Mode) -> [Impulse; N] {
    const { assert!(N >= 2) };
    let half_period = PI / mode.damped_frequency();
    let ratio = libm::exp(-mode.damping * mode.frequency * half_period);
    let mut amplitude = 1.0 / libm::pow(1.0 + ratio, (N - 1) as f64);
    let mut sequence = [Impulse::default(); N];
    for (i, impulse) in sequence.iter_mut().enumerate() {
        *impulse = Impulse {
            time: i as f64 * half_period,
            amplitude,
        };
        amplitude *= ratio * (N - 1 - i) as f64 / (i + 1) as f64;
    }
    sequence
}

/// Returns the sequence of `N` impulses for an undamped mode whose residual vibration stays below a
/// level in the widest band of frequencies: EI for 3 impulses, two-hump EI for 4.
///
/// - `frequency`: centre of the band, rad/s, positive.
/// - `level`: residual vibration V of the humps, in (0, 1).
///
/// The residual is `V |T(x cos(πω / 2ω₀))|` with the Chebyshev polynomial T of degree `N - 1` and
/// `T(x) = 1/V`. The zeros of the sequence follow from those of T.
///
/// # Errors
///
/// [`ShaperError::NotPositive`] or [`ShaperError::Level`] if a value is outside its range.
///
/// # Source
///
/// singhose1997, whose closed forms are those of 3 and 4 impulses; dolph1946 for any number.
pub fn extra_insensitive_undamped<const N: usize>(
    frequency: f64,
    level: f64,
) -> Result<[Impulse; N], ShaperError> {
    const { assert!(N >= 2) };
    positive(frequency, "natural frequency")?;
    if !(level > 0.0 && level < 1.0) {
        return Err(ShaperError::Level);
    }
    let degree = (N - 1) as f64;
    let scale = libm::cosh(libm::acosh(1.0 / level) / degree);
    // Coefficients of the product of one factor per conjugate pair of zeros.
    let mut product = [0.0; N];
    product[0] = 1.0;
    for pair in 0..N / 2 {
        if 2 * pair + 2 == N {
            multiply(&mut product, [1.0, 0.0]);
        } else {
            let zero = libm::cos((2 * pair + 1) as f64 * PI / (2.0 * degree)) / scale;
            multiply(&mut product, [2.0 - 4.0 * zero * zero, 1.0]);
        }
    }
    let sum: f64 = product.iter().sum();
    let mut sequence = [Impulse::default(); N];
    for (i, (impulse, coefficient)) in sequence.iter_mut().zip(product).enumerate() {
        *impulse = Impulse {
            time: i as f64 * PI / frequency,
            amplitude: coefficient / sum,
        };
    }
    Ok(sequence)
}

/// Multiplies a polynomial in place by `1 + factor[0] z + factor[1] z²`.
fn multiply(polynomial: &mut [f64], factor: [f64; 2]) {
    let [mut before, mut last] = [0.0; 2];
    for coefficient in polynomial {
        let current = *coefficient;
        *coefficient += factor[0] * last + factor[1] * before;
        (before, last) = (last, current);
    }
}

/// Writes the convolution of two sequences, in the order of time.
///
/// - `out`: \[impulses of `a` × impulses of `b`\].
///
/// # Errors
///
/// [`LengthError`] if `out` has another length.
pub fn convolve(a: &[Impulse], b: &[Impulse], out: &mut [Impulse]) -> Result<(), LengthError> {
    let expected = a.len().saturating_mul(b.len());
    length("the convolved sequence", expected, out.len())?;
    let pairs = a.iter().flat_map(|a| b.iter().map(move |b| (a, b)));
    for (impulse, (a, b)) in out.iter_mut().zip(pairs) {
        *impulse = Impulse {
            time: a.time + b.time,
            amplitude: a.amplitude * b.amplitude,
        };
    }
    out.sort_unstable_by(|a, b| {
        (a.time.total_cmp(&b.time)).then(a.amplitude.total_cmp(&b.amplitude))
    });
    Ok(())
}

/// Returns the amplitude of a mode's vibration after the last impulse, as a part of that after one
/// impulse of amplitude 1.
///
/// `V = exp(-ζω t_N) sqrt(C² + S²)`, `C = Σ A_i exp(ζω t_i) cos(ω_d t_i)`, S with the sine. It is
/// also the residual vibration of a shaped step as a part of that of the step.
///
/// # Source
///
/// singer1990.
#[must_use]
pub fn residual(sequence: &[Impulse], mode: &Mode) -> f64 {
    let end = sequence
        .iter()
        .fold(0.0, |end, impulse| impulse.time.max(end));
    let decay = mode.damping * mode.frequency;
    let damped = mode.damped_frequency();
    let [mut c, mut s] = [0.0; 2];
    for impulse in sequence {
        let amplitude = impulse.amplitude * libm::exp(decay * (impulse.time - end));
        let (sine, cosine) = libm::sincos(damped * impulse.time);
        c += amplitude * cosine;
        s += amplitude * sine;
    }
    libm::hypot(c, s)
}

/// Writes the taps of a sampled sequence in the order of delays, and returns their number.
///
/// - `period`: sampling period, s, positive.
/// - `taps`: memory for two taps per impulse.
///
/// An impulse between two samples is divided between them by its distance from each, so the mean
/// delay stays. The weights have the sum 1.
///
/// # Errors
///
/// [`ShaperError`] if the period is not positive and finite, the memory is too short, or the
/// sequence is empty, longer than [`LONGEST_DELAY`] or does not have the sum 1.
pub fn sample(sequence: &[Impulse], period: f64, taps: &mut [Tap]) -> Result<usize, ShaperError> {
    positive(period, "sampling period")?;
    let needed = sequence.len().saturating_mul(2);
    if taps.len() < needed {
        length("the memory of taps", needed, taps.len())?;
    }
    let sum = unit_sum(sequence.iter().map(|impulse| impulse.amplitude))?;
    let mut count = 0;
    for impulse in sequence {
        if !(impulse.time.is_finite() && impulse.time >= 0.0) {
            return Err(ShaperError::Time);
        }
        let position = impulse.time / period;
        if position >= LONGEST_DELAY as f64 {
            return Err(ShaperError::TooLate);
        }
        let delay = (position + NEAR_SAMPLE) as usize;
        let late = position - delay as f64;
        let late = if late < NEAR_SAMPLE { 0.0 } else { late };
        let weight = impulse.amplitude / sum;
        for (delay, weight) in [(delay, weight * (1.0 - late)), (delay + 1, weight * late)] {
            if weight.abs() > 0.0 {
                count = insert(taps, count, Tap { delay, weight });
            }
        }
    }
    Ok(count)
}

/// Adds a tap to the first `count` taps, which are in the order of delays. Returns their number.
fn insert(taps: &mut [Tap], count: usize, tap: Tap) -> usize {
    let at = taps[..count].partition_point(|other| other.delay < tap.delay);
    if at < count && taps[at].delay == tap.delay {
        taps[at].weight += tap.weight;
        return count;
    }
    taps[at..=count].rotate_right(1);
    taps[at] = tap;
    count + 1
}

fn length(what: &'static str, expected: usize, found: usize) -> Result<(), LengthError> {
    if expected == found {
        return Ok(());
    }
    Err(LengthError {
        what,
        expected,
        found,
    })
}

/// Returns the sum of amplitudes, which is 1 up to rounding.
fn unit_sum(amplitudes: impl ExactSizeIterator<Item = f64>) -> Result<f64, ShaperError> {
    if amplitudes.len() == 0 {
        return Err(ShaperError::Empty);
    }
    let sum: f64 = amplitudes.sum();
    let close = (sum - 1.0).abs() <= SUM_TOLERANCE;
    if close {
        Ok(sum)
    } else {
        Err(ShaperError::Sum)
    }
}

/// Returns the number of `f64` that a [`Shaper`] needs.
#[must_use]
pub fn memory_len(taps: &[Tap], signals: usize) -> usize {
    rows(taps).saturating_mul(signals)
}

/// Returns the number of samples that a shaper remembers.
fn rows(taps: &[Tap]) -> usize {
    let longest = taps.iter().map(|tap| tap.delay).max();
    longest.map_or(0, |longest| longest.saturating_add(1))
}

/// Filter that convolves signals with a sampled sequence. `M` is memory of the caller, a slice,
/// array or vector.
///
/// A constant input gives exactly this constant. With positive weights an output lies, up to
/// rounding, between the least and the largest of the remembered inputs.
#[derive(Clone, Debug)]
pub struct Shaper<'t, M> {
    taps: &'t [Tap],
    memory: M,
    signals: usize,
    rows: usize,
    newest: usize,
}

impl<'t, M: AsRef<[f64]> + AsMut<[f64]>> Shaper<'t, M> {
    /// Returns a shaper whose signals rested at the given values until now.
    ///
    /// - `taps`: from [`sample`].
    /// - `rest`: one value per signal, finite.
    /// - `memory`: [`memory_len`] numbers; their values do not matter.
    ///
    /// # Errors
    ///
    /// [`ShaperError`] if there is no tap, a delay is longer than [`LONGEST_DELAY`], the weights do
    /// not have the sum 1, the memory has another length, or a rest value is not finite.
    pub fn new(taps: &'t [Tap], rest: &[f64], memory: M) -> Result<Self, ShaperError> {
        unit_sum(taps.iter().map(|tap| tap.weight))?;
        let rows = rows(taps);
        if rows > LONGEST_DELAY + 1 {
            return Err(ShaperError::TooLate);
        }
        let expected = memory_len(taps, rest.len());
        length("the memory of the shaper", expected, memory.as_ref().len())?;
        let mut shaper = Self {
            taps,
            memory,
            signals: rest.len(),
            rows,
            newest: 0,
        };
        shaper.start(rest)?;
        Ok(shaper)
    }

    /// Forgets all samples: the signals rested at the given values until now.
    ///
    /// - `rest`: one value per signal, finite.
    ///
    /// # Errors
    ///
    /// [`ShaperError::Length`] if the number of values differs, [`ShaperError::NotFinite`] if one is
    /// not finite. The shaper then stays as it was.
    pub fn start(&mut self, rest: &[f64]) -> Result<(), ShaperError> {
        length("the rest values", self.signals, rest.len())?;
        if !rest.iter().all(|value| value.is_finite()) {
            return Err(ShaperError::NotFinite);
        }
        for row in self.memory.as_mut().chunks_exact_mut(self.signals.max(1)) {
            row.copy_from_slice(rest);
        }
        Ok(())
    }

    /// Filters one sample of each signal.
    ///
    /// - `input`, `output`: one value per signal.
    ///
    /// An input that is not finite is replaced by the last finite one of its signal, or by the rest
    /// value if there is none: the shaped command holds its target.
    ///
    /// # Errors
    ///
    /// [`LengthError`] if a slice has another length. The shaper then stays as it was.
    pub fn process(&mut self, input: &[f64], output: &mut [f64]) -> Result<(), LengthError> {
        length("the input of the shaper", self.signals, input.len())?;
        length("the output of the shaper", self.signals, output.len())?;
        let last = self.newest * self.signals;
        self.newest = (self.newest + 1) % self.rows;
        let newest = self.newest * self.signals;
        let memory = self.memory.as_mut();
        for (i, value) in input.iter().enumerate() {
            let held = memory[last + i];
            memory[newest + i] = if value.is_finite() { *value } else { held };
        }
        let Some((first, others)) = self.taps.split_first() else {
            return Ok(());
        };
        for (i, output) in output.iter_mut().enumerate() {
            let past = |tap: &Tap| {
                let row = (self.newest + self.rows - tap.delay) % self.rows;
                memory[row * self.signals + i]
            };
            // The differences to the first tap vanish exactly if the signal is constant.
            let reference = past(first);
            *output = others.iter().fold(reference, |sum, tap| {
                sum + (tap.weight * past(tap) - tap.weight * reference)
            });
        }
        Ok(())
    }
}
