//! Input shapers against published values, and against an oscillator that is integrated.

use std::f64::consts::{PI, TAU};

use sprung_core::links::LengthError;
use sprung_core::shaper::{
    Impulse, LONGEST_DELAY, Mode, Shaper, ShaperError, Tap, convolve, extra_insensitive_undamped,
    memory_len, residual, sample, zero_vibration,
};

fn assert_sequence(found: &[Impulse], expected: &[(f64, f64)], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    for (found, (time, amplitude)) in found.iter().zip(expected) {
        assert!((found.time - time).abs() < tolerance, "{found:?} {time}");
        assert!(
            (found.amplitude - amplitude).abs() < tolerance,
            "{found:?} {amplitude}"
        );
    }
}

#[test]
fn zero_vibration_has_the_published_values() {
    let undamped = Mode::from_hz(2.0, 0.0).unwrap();
    let zv: [_; 2] = zero_vibration(&undamped);
    assert_sequence(&zv, &[(0.0, 0.5), (0.25, 0.5)], 1e-15);
    let zvd: [_; 3] = zero_vibration(&undamped);
    assert_sequence(&zvd, &[(0.0, 0.25), (0.25, 0.5), (0.5, 0.25)], 1e-15);
    // K = 0.7292476 for a damping ratio of 0.1, and a period of 1/sqrt(0.99) s at 1 Hz.
    let damped = Mode::from_hz(1.0, 0.1).unwrap();
    let half = 0.502_518_9;
    let zv: [_; 2] = zero_vibration(&damped);
    assert_sequence(&zv, &[(0.0, 0.578_286_2), (half, 0.421_713_8)], 1e-7);
    let zvd: [_; 3] = zero_vibration(&damped);
    let expected = [
        (0.0, 0.334_414_9),
        (half, 0.487_742_5),
        (2.0 * half, 0.177_842_5),
    ];
    assert_sequence(&zvd, &expected, 1e-7);
    let zvdd: [_; 4] = zero_vibration(&damped);
    for (sequence, name) in [(&zv[..], "ZV"), (&zvd[..], "ZVD"), (&zvdd[..], "ZVDD")] {
        assert!(residual(sequence, &damped) < 1e-15, "{name}");
        let sum: f64 = sequence.iter().map(|impulse| impulse.amplitude).sum();
        assert!((sum - 1.0).abs() < 1e-15, "{name}");
    }
}

#[test]
fn extra_insensitive_has_the_published_values() {
    for v in [0.01_f64, 0.05, 0.2] {
        let one: [_; 3] = extra_insensitive_undamped(PI, v).unwrap();
        let [outer, inner] = [0.25 * (1.0 + v), 0.5 * (1.0 - v)];
        assert_sequence(&one, &[(0.0, outer), (1.0, inner), (2.0, outer)], 1e-14);
        let x = (v * v * ((1.0 - v * v).sqrt() + 1.0)).cbrt();
        let outer = (3.0 * x * x + 2.0 * x + 3.0 * v * v) / (16.0 * x);
        let inner = 0.5 - outer;
        let two: [_; 4] = extra_insensitive_undamped(PI, v).unwrap();
        let expected = [(0.0, outer), (1.0, inner), (2.0, inner), (3.0, outer)];
        assert_sequence(&two, &expected, 1e-14);
        let outer = (1.0 + 3.0 * v + 2.0 * (2.0 * (v * v + v)).sqrt()) / 16.0;
        let next = 0.25 * (1.0 - v);
        let three: [_; 5] = extra_insensitive_undamped(PI, v).unwrap();
        let expected = [
            (0.0, outer),
            (1.0, next),
            (2.0, 1.0 - 2.0 * (outer + next)),
            (3.0, next),
            (4.0, outer),
        ];
        assert_sequence(&three, &expected, 1e-14);
    }
}

/// Returns the width of the band of frequencies about 1 with a residual of at most 5 %.
fn insensitivity(sequence: &[Impulse]) -> f64 {
    let at = |frequency: f64| residual(sequence, &Mode::new(frequency, 0.0).unwrap());
    let edge = |step: f64| {
        let outside = (1..10_000).find(|k| at(1.0 + f64::from(*k) * step) > 0.05 * (1.0 + 1e-9));
        f64::from(outside.unwrap()) * step.abs()
    };
    edge(1e-4) + edge(-1e-4)
}

#[test]
fn widths_of_5_percent_are_the_published_ones() {
    let mode = Mode::new(1.0, 0.0).unwrap();
    let zv: [_; 2] = zero_vibration(&mode);
    let zvd: [_; 3] = zero_vibration(&mode);
    let zvdd: [_; 4] = zero_vibration(&mode);
    let ei: [_; 3] = extra_insensitive_undamped(1.0, 0.05).unwrap();
    let two_humps: [_; 4] = extra_insensitive_undamped(1.0, 0.05).unwrap();
    let three_humps: [_; 5] = extra_insensitive_undamped(1.0, 0.05).unwrap();
    // The residual of ZV is the cosine of πω/2, that of the others a power or Chebyshev polynomial of it.
    let power = |n: f64| 4.0 / PI * 0.05_f64.powf(1.0 / n).asin();
    let humps = |n: f64| 4.0 / PI * (1.0 / (20_f64.acosh() / n).cosh()).asin();
    for (sequence, closed_form, published) in [
        (&zv[..], power(1.0), 0.06),
        (&zvd[..], power(2.0), 0.29),
        (&zvdd[..], power(3.0), 0.48),
        (&ei[..], humps(2.0), 0.40),
        (&two_humps[..], humps(3.0), 0.73),
        (&three_humps[..], humps(4.0), 0.96),
    ] {
        let found = insensitivity(sequence);
        println!("{} impulses: {found:.4}", sequence.len());
        assert!((found - closed_form).abs() < 3e-4, "{found} {closed_form}");
        assert!((found - published).abs() < 0.006, "{found} {published}");
    }
}

/// Exponential of a 2 × 2 matrix, by squares of a Taylor series.
fn exponential(mut a: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let product = |a: &[[f64; 2]; 2], b: &[[f64; 2]; 2]| {
        [0, 1].map(|i| [0, 1].map(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]))
    };
    let size = a
        .iter()
        .flatten()
        .fold(0.0, |most: f64, x| most.max(x.abs()));
    let squares = size.max(1.0).log2().ceil() as i32 + 6;
    a = a.map(|row| row.map(|x| x / 2_f64.powi(squares)));
    let mut sum = [[1.0, 0.0], [0.0, 1.0]];
    let mut term = sum;
    for k in 1..12 {
        term = product(&term, &a).map(|row| row.map(|x| x / f64::from(k)));
        for (sum, term) in sum.iter_mut().flatten().zip(term.iter().flatten()) {
            *sum += term;
        }
    }
    for _ in 0..squares {
        sum = product(&sum, &sum);
    }
    sum
}

/// An oscillator `x'' + 2ζω x' + ω² x = ω² u` that follows a command constant in steps.
struct Oscillator {
    mode: Mode,
    state: [f64; 2],
}

impl Oscillator {
    fn advance(&mut self, command: f64, time: f64) {
        let (w, z) = (self.mode.frequency(), self.mode.damping());
        let matrix = [[0.0, time], [-w * w * time, -2.0 * z * w * time]];
        let [x, dx] = [self.state[0] - command, self.state[1]];
        let [[a, b], [c, d]] = exponential(matrix);
        self.state = [a * x + b * dx + command, c * x + d * dx];
    }

    /// Amplitude of the decaying vibration about a command.
    fn amplitude(&self, command: f64) -> f64 {
        let (w, z) = (self.mode.frequency(), self.mode.damping());
        let x = self.state[0] - command;
        let quadrature = (self.state[1] + z * w * x) / self.mode.damped_frequency();
        x.hypot(quadrature)
    }
}

/// Returns the vibration after a shaped step, as a part of that after the step.
fn simulated(sequence: &[Impulse], mode: Mode) -> f64 {
    let mut oscillator = Oscillator {
        mode,
        state: [0.0; 2],
    };
    let step = oscillator.amplitude(1.0);
    let (mut command, mut time) = (0.0, 0.0);
    for impulse in sequence {
        oscillator.advance(command, impulse.time - time);
        time = impulse.time;
        command += impulse.amplitude;
    }
    oscillator.amplitude(1.0) / step
}

#[test]
fn residual_is_that_of_an_integrated_oscillator() {
    let centre = Mode::from_hz(7.0, 0.05).unwrap();
    let zv: [_; 2] = zero_vibration(&centre);
    let zvd: [_; 3] = zero_vibration(&centre);
    let ei: [_; 3] = extra_insensitive_undamped(centre.frequency(), 0.05).unwrap();
    let other: [_; 3] = zero_vibration(&Mode::from_hz(19.0, 0.02).unwrap());
    let mut both = [Impulse::default(); 9];
    convolve(&ei, &other, &mut both).unwrap();
    for sequence in [&zv[..], &zvd, &ei, &both] {
        for hz in [3.0, 6.3, 7.0, 8.1, 21.0] {
            for damping in [0.0, 0.05, 0.3] {
                let mode = Mode::from_hz(hz, damping).unwrap();
                let (v, found) = (residual(sequence, &mode), simulated(sequence, mode));
                assert!((v - found).abs() < 1e-9, "{hz} {damping}: {v} {found}");
            }
        }
    }
}

#[test]
fn convolution_of_two_sequences_stops_both_modes() {
    let modes = [(4.0, 0.03), (11.0, 0.1)].map(|(hz, z)| Mode::from_hz(hz, z).unwrap());
    let [slow, fast] = modes.map(|mode| zero_vibration::<2>(&mode));
    let mut both = [Impulse::default(); 4];
    convolve(&slow, &fast, &mut both).unwrap();
    assert!(both.is_sorted_by(|a, b| a.time <= b.time));
    for mode in modes {
        assert!(residual(&both, &mode) < 1e-15);
    }
    let between = Mode::from_hz(6.0, 0.02).unwrap();
    let product = residual(&slow, &between) * residual(&fast, &between);
    assert!((residual(&both, &between) - product).abs() < 1e-15);
    let error = convolve(&slow, &fast, &mut [Impulse::default(); 3]).unwrap_err();
    assert_eq!((error.expected, error.found), (4, 3));
}

/// Returns the taps of a sequence.
fn taps(sequence: &[Impulse], period: f64) -> Vec<Tap> {
    let mut taps = vec![Tap::default(); 2 * sequence.len()];
    let count = sample(sequence, period, &mut taps).unwrap();
    taps.truncate(count);
    taps
}

#[test]
fn sampling_keeps_sum_and_mean_delay() {
    let period = 0.004;
    let zvd: [_; 3] = zero_vibration(&Mode::from_hz(7.3, 0.04).unwrap());
    let taps = taps(&zvd, period);
    assert_eq!(taps.len(), 5);
    assert!(taps.is_sorted_by(|a, b| a.delay < b.delay));
    let sum: f64 = taps.iter().map(|tap| tap.weight).sum();
    let mean: f64 = (taps.iter())
        .map(|tap| tap.weight * tap.delay as f64 * period)
        .sum();
    let exact: f64 = zvd
        .iter()
        .map(|impulse| impulse.amplitude * impulse.time)
        .sum();
    assert!((sum - 1.0).abs() < 1e-15 && (mean - exact).abs() < 1e-15);
    // A time that is a multiple of the period up to rounding has one tap.
    let half = Mode::from_hz(0.5 / (30.0 * period), 0.0).unwrap();
    let exact = self::taps(&zero_vibration::<2>(&half), period);
    assert_eq!(
        exact.iter().map(|tap| tap.delay).collect::<Vec<_>>(),
        [0, 30]
    );
    // Impulses between the same samples share taps.
    let near = [0.0, 0.1, 0.3].map(|part| Impulse {
        time: part * period,
        amplitude: 1.0 / 3.0,
    });
    assert_eq!(self::taps(&near, period).len(), 2);
}

#[test]
fn filter_is_the_direct_convolution_and_stops_a_sampled_oscillator() {
    let (period, mode) = (0.002, Mode::from_hz(5.0, 0.02).unwrap());
    let ei: [_; 3] = extra_insensitive_undamped(mode.frequency(), 0.05).unwrap();
    let taps = taps(&ei, period);
    let mut shaper = Shaper::new(&taps, &[0.0, 0.3], vec![9.0; memory_len(&taps, 2)]).unwrap();
    let signals = [
        |k: i64| f64::from(u8::from(k >= 0)),
        |k: i64| 0.3 + 0.2 * (0.01 * k.max(0) as f64).sin(),
    ];
    let mut oscillator = Oscillator {
        mode,
        state: [0.0; 2],
    };
    let step = oscillator.amplitude(1.0);
    let longest = taps.last().unwrap().delay as i64;
    for k in 0..400 {
        let mut output = [0.0; 2];
        (shaper.process(&signals.map(|signal| signal(k)), &mut output)).unwrap();
        for (signal, output) in signals.iter().zip(output) {
            let direct: f64 = (taps.iter())
                .map(|tap| tap.weight * signal(k - tap.delay as i64))
                .sum();
            assert!((direct - output).abs() < 1e-15, "{k}");
        }
        if k == longest {
            let sampled = impulses(&taps, period);
            let (found, v) = (oscillator.amplitude(1.0) / step, residual(&sampled, &mode));
            assert!((found - v).abs() < 1e-9 && v < 0.08, "{found} {v}");
        }
        oscillator.advance(output[0], period);
    }
}

fn impulses(taps: &[Tap], period: f64) -> Vec<Impulse> {
    let impulse = |tap: &Tap| Impulse {
        time: tap.delay as f64 * period,
        amplitude: tap.weight,
    };
    taps.iter().map(impulse).collect()
}

#[test]
fn a_constant_passes_exactly() {
    let mode = Mode::from_hz(3.3, 0.07).unwrap();
    let zvdd: [_; 4] = zero_vibration(&mode);
    let taps = taps(&zvdd, 0.003);
    let [rest, target] = [0.1_f64, -1.0 / 3.0];
    let mut shaper = Shaper::new(&taps, &[rest], vec![0.0; memory_len(&taps, 1)]).unwrap();
    let mut output = [0.0];
    let mut steps = |shaper: &mut Shaper<'_, _>, input: f64, count: usize| {
        for _ in 0..count {
            shaper.process(&[input], &mut output).unwrap();
        }
        output[0].to_bits()
    };
    assert_eq!(steps(&mut shaper, rest, 1), rest.to_bits());
    let longest = taps.last().unwrap().delay;
    assert_ne!(steps(&mut shaper, target, longest), target.to_bits());
    assert_eq!(steps(&mut shaper, target, 1), target.to_bits());
    // Values that are not finite hold the target.
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(steps(&mut shaper, value, 2 * longest), target.to_bits());
    }
    shaper.start(&[rest]).unwrap();
    assert_eq!(steps(&mut shaper, f64::NAN, longest), rest.to_bits());
    assert_eq!(shaper.start(&[f64::NAN]), Err(ShaperError::NotFinite));
    assert_eq!(steps(&mut shaper, rest, 1), rest.to_bits());
    // The largest numbers do not overflow.
    let largest = steps(&mut shaper, f64::MAX, longest / 2);
    assert!(f64::from_bits(largest).is_finite());
    assert!(f64::from_bits(steps(&mut shaper, f64::MIN, longest / 4)).is_finite());
}

#[test]
fn bad_values_are_refused() {
    let impulse = |time, amplitude| Impulse { time, amplitude };
    for hz in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = ShaperError::NotPositive("natural frequency");
        assert_eq!(Mode::from_hz(hz, 0.1), Err(error));
        assert_eq!(extra_insensitive_undamped::<3>(hz, 0.05), Err(error));
    }
    for damping in [-0.1, 1.0, f64::NAN] {
        assert_eq!(Mode::from_hz(1.0, damping), Err(ShaperError::Damping));
    }
    for level in [0.0, 1.0, f64::NAN] {
        let found = extra_insensitive_undamped::<4>(TAU, level);
        assert_eq!(found, Err(ShaperError::Level));
    }
    let mut taps = [Tap::default(); 4];
    for (sequence, error) in [
        (vec![], ShaperError::Empty),
        (vec![impulse(0.0, 0.9)], ShaperError::Sum),
        (vec![impulse(0.0, f64::NAN)], ShaperError::Sum),
        (vec![impulse(-1e-9, 1.0)], ShaperError::Time),
        (vec![impulse(f64::NAN, 1.0)], ShaperError::Time),
        (vec![impulse(1e9, 1.0)], ShaperError::TooLate),
        (
            vec![impulse(0.0, 0.25); 4],
            ShaperError::Length(LengthError {
                what: "the memory of taps",
                expected: 8,
                found: 4,
            }),
        ),
    ] {
        assert_eq!(sample(&sequence, 1e-3, &mut taps), Err(error), "{error}");
    }
    let tap = |delay, weight| Tap { delay, weight };
    let refusal = |taps: &[Tap], memory: usize| {
        let memory = vec![0.0; memory];
        Shaper::new(taps, &[0.0], memory).unwrap_err()
    };
    assert_eq!(refusal(&[], 0), ShaperError::Empty);
    assert_eq!(refusal(&[tap(0, 0.5)], 1), ShaperError::Sum);
    assert_eq!(refusal(&[tap(usize::MAX, 1.0)], 1), ShaperError::TooLate);
    assert_eq!(
        refusal(&[tap(LONGEST_DELAY + 1, 1.0)], 1),
        ShaperError::TooLate
    );
    assert!(matches!(refusal(&[tap(3, 1.0)], 3), ShaperError::Length(_)));
    let taps = [tap(2, 1.0)];
    let mut shaper = Shaper::new(&taps, &[0.0], vec![0.0; 3]).unwrap();
    assert!(shaper.process(&[1.0, 2.0], &mut [0.0]).is_err());
    assert!(shaper.process(&[1.0], &mut [0.0, 0.0]).is_err());
    assert!(shaper.start(&[]).is_err());
}
