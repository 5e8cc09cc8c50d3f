//! Extra-insensitive sequences for damped modes, from their defining equations.

use std::f64::consts::PI;

use faer::linalg::solvers::Solve;
use faer::{Mat, c64};
use sprung_core::shaper::{Impulse, Mode, ShaperError, extra_insensitive_undamped};

/// Largest step of the damping ratio from one solution to the next.
const DAMPING_STEP: f64 = 0.05;

/// Newton steps for one damping ratio, and halvings of a step.
const STEPS: usize = 30;
const HALVINGS: usize = 20;

/// Largest error of a solved equation.
const TOLERANCE: f64 = 1e-10;

/// Step of the central differences.
const DIFFERENCE: f64 = 1e-6;

/// The unknowns at the centre frequency 1 rad/s.
#[derive(Clone)]
struct Unknowns {
    /// Amplitudes and times of all impulses but the first, which comes at time 0 and has the rest of the sum, \[n\].
    amplitudes: Vec<f64>,
    times: Vec<f64>,
    /// Frequencies without residual vibration, \[n\].
    zeros: Vec<f64>,
    /// Frequencies of the humps between them, \[n - 1\].
    humps: Vec<f64>,
}

/// Returns the sequence with a number of impulses; `None` if the equations have no solution with positive amplitudes.
///
/// - `level`: residual vibration of the humps; two impulses have no hump.
///
/// At the damping ratio of the mode the residual vanishes at `impulses - 1` frequencies and has the level at the
/// humps between them. The mode's frequency is that of the middle hump or zero.
///
/// # Source
///
/// singer1990 for two impulses, singhose1994 for three, singhose1997 for more; the last two publish curve fits, here Newton's method solves the equations.
pub(super) fn extra_insensitive(mode: &Mode, level: f64, impulses: usize) -> Option<Vec<Impulse>> {
    let undamped = match impulses {
        2 => undamped::<2>(level),
        3 => undamped::<3>(level),
        4 => undamped::<4>(level),
        5 => undamped::<5>(level),
        _ => return None,
    };
    let mut found = Unknowns::undamped(&undamped.ok()?, level);
    let steps = (mode.damping() / DAMPING_STEP).ceil();
    for step in 1..=steps as usize {
        let damping = mode.damping() * step as f64 / steps;
        found = found.solved(damping, level)?;
    }
    let sequence = found.sequence(mode.frequency());
    let positive = sequence.iter().all(|impulse| impulse.amplitude > 0.0);
    (positive && sequence.is_sorted_by(|a, b| a.time < b.time)).then_some(sequence)
}

fn undamped<const N: usize>(level: f64) -> Result<Vec<Impulse>, ShaperError> {
    extra_insensitive_undamped::<N>(1.0, level).map(Vec::from)
}

impl Unknowns {
    fn undamped(sequence: &[Impulse], level: f64) -> Self {
        let n = sequence.len() - 1;
        let degree = n as f64;
        // The residual is a Chebyshev polynomial of the scaled cosine.
        let scale = ((1.0 / level).acosh() / degree).cosh();
        let at = |angle: f64| 2.0 / PI * (angle.cos() / scale).acos();
        Self {
            amplitudes: sequence[1..]
                .iter()
                .map(|impulse| impulse.amplitude)
                .collect(),
            times: sequence[1..].iter().map(|impulse| impulse.time).collect(),
            zeros: (0..n).map(|k| at((k as f64 + 0.5) * PI / degree)).collect(),
            humps: (1..n).map(|k| at(k as f64 * PI / degree)).collect(),
        }
    }

    fn sequence(&self, frequency: f64) -> Vec<Impulse> {
        let first = Impulse {
            time: 0.0,
            amplitude: 1.0 - self.amplitudes.iter().sum::<f64>(),
        };
        let others = self.amplitudes.iter().zip(&self.times);
        let others = others.map(|(&amplitude, time)| Impulse {
            time: time / frequency,
            amplitude,
        });
        std::iter::once(first).chain(others).collect()
    }

    /// Returns the numbers that the equations determine: all but the frequency at the centre.
    fn free(&mut self) -> impl Iterator<Item = &mut f64> {
        let n = self.zeros.len();
        let features = (self.zeros.iter_mut().enumerate())
            .map(move |(k, zero)| (2 * k, zero))
            .chain((self.humps.iter_mut().enumerate()).map(|(k, hump)| (2 * k + 1, hump)))
            .filter(move |(place, _)| *place != n - 1)
            .map(|(_, feature)| feature);
        (self.amplitudes.iter_mut())
            .chain(&mut self.times)
            .chain(features)
    }

    /// Returns the errors of the equations.
    fn errors(&self, damping: f64, level: f64) -> Vec<f64> {
        let sequence = self.sequence(1.0);
        let end = self.times.last().copied().unwrap_or_default();
        let rate = c64::new(damping, (1.0 - damping * damping).sqrt());
        // Vibration after the last impulse in levels, and its derivative by the frequency.
        let vibration = |frequency: f64| {
            let mut sums = [c64::new(0.0, 0.0); 2];
            for impulse in &sequence {
                let exponent = rate * impulse.time - damping * end;
                let term = (exponent * frequency).exp() * (impulse.amplitude / level);
                sums[0] += term;
                sums[1] += term * exponent;
            }
            sums
        };
        let zeros = self.zeros.iter().flat_map(|&frequency| {
            let [value, _] = vibration(frequency);
            [value.re, value.im]
        });
        let humps = self.humps.iter().flat_map(|&frequency| {
            let [value, slope] = vibration(frequency);
            [value.norm_sqr() - 1.0, (value.conj() * slope).re]
        });
        zeros.chain(humps).collect()
    }

    /// Returns the solution for a damping ratio near that of these unknowns.
    fn solved(mut self, damping: f64, level: f64) -> Option<Self> {
        let largest = |errors: &[f64]| {
            errors
                .iter()
                .fold(0.0, |most: f64, error| most.max(error.abs()))
        };
        let mut errors = self.errors(damping, level);
        for _ in 0..STEPS {
            if largest(&errors) < TOLERANCE {
                return Some(self);
            }
            let step = self.newton_step(&errors, damping, level);
            let mut part = 1.0;
            let (next, next_errors) = (0..HALVINGS).find_map(|_| {
                let next = self.moved(&step, part);
                let next_errors = next.errors(damping, level);
                part *= 0.5;
                let better = largest(&next_errors) < largest(&errors);
                better.then_some((next, next_errors))
            })?;
            (self, errors) = (next, next_errors);
        }
        None
    }

    fn moved(&self, step: &[f64], part: f64) -> Self {
        let mut moved = self.clone();
        for (feature, step) in moved.free().zip(step) {
            *feature += part * step;
        }
        moved
    }

    fn newton_step(&self, errors: &[f64], damping: f64, level: f64) -> Vec<f64> {
        let count = errors.len();
        let mut jacobian = Mat::zeros(count, count);
        for column in 0..count {
            let mut unit = vec![0.0; count];
            unit[column] = DIFFERENCE;
            let [after, before] =
                [1.0, -1.0].map(|part| self.moved(&unit, part).errors(damping, level));
            for row in 0..count {
                jacobian[(row, column)] = (after[row] - before[row]) / (2.0 * DIFFERENCE);
            }
        }
        let right = Mat::from_fn(count, 1, |row, _| -errors[row]);
        let step = jacobian.partial_piv_lu().solve(&right);
        (0..count).map(|row| step[(row, 0)]).collect()
    }
}
