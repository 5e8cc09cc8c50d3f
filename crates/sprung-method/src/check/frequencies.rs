//! Finds motions of one frequency, which hardly separate inertias from springs and gravity.

use std::f64::consts::TAU;

use sprung_core::linear::{factor, solve};

use crate::finding::{Finding, Severity};
use crate::log::Signal;
use crate::prepare::Excerpt;
use crate::regression::Reading;

/// Maximum number of samples of a position in the search.
const MAX_SAMPLES: usize = 512;

/// Smallest and largest number of periods in the excerpt.
const MIN_PERIODS: f64 = 2.0;
const MAX_PERIODS: f64 = 64.0;

/// Step of the search and of its refinement, in periods per excerpt.
const STEP: f64 = 0.25;
const FINE_STEP: f64 = 1.0 / 64.0;

/// Part of a velocity's variance that other frequencies may explain. Friction distorts the motion, but in motions
/// between two points at constant speed, a tenth of the power has other frequencies.
const OTHER_FREQUENCIES: f64 = 0.03;

/// A joint whose standard deviation is below this part of the largest one hardly moves.
const HARDLY_MOVES: f64 = 0.1;

/// Number of terms: mean, sine and cosine of a frequency and of its double.
const TERMS: usize = 5;

/// Reports a log in which every joint that moves has one frequency and its double.
pub(super) fn one_frequency(reading: &Reading, excerpt: &Excerpt, file: &str) -> Option<Finding> {
    let channels = reading.channels();
    let joints = 0..reading.model().joint_count();
    let velocities: Vec<Vec<f64>> = joints
        .filter_map(|joint| channels.telling(Signal::Motor, joint))
        .map(|channel| differences(excerpt, channel))
        .collect();
    let largest = (velocities.iter().map(|velocity| variance(velocity))).fold(0.0, f64::max);
    let moving = (velocities.iter()).filter(|velocity| {
        variance(velocity) > HARDLY_MOVES.powi(2) * largest && velocity.len() > 2 * TERMS
    });
    let found: Option<Vec<f64>> = moving.map(|velocity| periods(velocity)).collect();
    let found = found.filter(|found| !found.is_empty())?;
    let hertz = |periods: &f64| periods / excerpt.duration();
    let least = found.iter().map(hertz).fold(f64::INFINITY, f64::min);
    let most = found.iter().map(hertz).fold(0.0, f64::max);
    let frequencies = if most - least < STEP / excerpt.duration() {
        format!("of {least:.2} Hz")
    } else {
        format!("({least:.2} to {most:.2} Hz)")
    };
    Some(
        Finding::new(
            Severity::Warning,
            "one-frequency",
            format!(
                "every joint in {file} moves with one frequency {frequencies} and its double: each \
                 period repeats the errors of the encoders, so a longer log does not average them, and \
                 the motion hardly separates inertias from springs and gravity. Intervals and promised \
                 errors do not hold for other motions"
            ),
            "record a motion with four or more frequencies that are no multiples of each other, \
             different ones in each joint",
        )
        .seen(file, "", least, "Hz"),
    )
}

/// Returns the differences of a position between evenly distributed samples of the excerpt.
fn differences(excerpt: &Excerpt, channel: usize) -> Vec<f64> {
    let step = excerpt.samples().div_ceil(MAX_SAMPLES).max(1);
    let positions: Vec<f64> = excerpt.channel(channel).step_by(step).collect();
    (positions.windows(2))
        .map(|pair| pair[1] - pair[0])
        .collect()
}

fn variance(values: &[f64]) -> f64 {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count
}

/// Returns the number of periods in which a velocity repeats; `None` if it has more frequencies.
fn periods(values: &[f64]) -> Option<f64> {
    let whole = variance(values);
    let best = |first: f64, last: f64, step: f64| {
        let count = ((last - first) / step).round() as usize;
        (0..=count)
            .map(|k| first + step * k as f64)
            .map(|periods| (periods, unexplained(values, periods)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let (about, _) = best(MIN_PERIODS, MAX_PERIODS, STEP)?;
    let (periods, left) = best(about - STEP, about + STEP, FINE_STEP)?;
    (left < OTHER_FREQUENCIES * whole).then_some(periods)
}

/// Returns the mean square of a velocity without a frequency and its double; infinite if the terms are not independent.
///
/// - `periods`: number of periods in the whole.
fn unexplained(values: &[f64], periods: f64) -> f64 {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let mut normal = [0.0; TERMS * TERMS];
    let mut right = [0.0; TERMS];
    let mut squares = 0.0;
    let (step_sin, step_cos) = (TAU * periods / count).sin_cos();
    let (mut sin, mut cos) = (0.0, 1.0);
    for value in values {
        let terms = [1.0, sin, cos, 2.0 * sin * cos, cos * cos - sin * sin];
        let value = value - mean;
        squares += value * value;
        for (i, term) in terms.iter().enumerate() {
            right[i] += term * value;
            for (j, other) in terms[..=i].iter().enumerate() {
                normal[i * TERMS + j] += term * other;
            }
        }
        (sin, cos) = (
            sin * step_cos + cos * step_sin,
            cos * step_cos - sin * step_sin,
        );
    }
    if !factor(&mut normal, TERMS) {
        return f64::INFINITY;
    }
    let mut solution = right;
    solve(&normal, &mut solution);
    let explained: f64 = solution.iter().zip(&right).map(|(x, b)| x * b).sum();
    (squares - explained).max(0.0) / count
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns 400 samples of 10 s of sines: amplitude and frequency, Hz.
    fn sines(all: &[(f64, f64)]) -> Vec<f64> {
        (0..400)
            .map(|k| 0.025 * f64::from(k))
            .map(|t| {
                0.3 + (all.iter().map(|(size, f)| size * (TAU * f * t + f).sin())).sum::<f64>()
            })
            .collect()
    }

    #[test]
    fn one_frequency_and_its_double_are_found_and_two_frequencies_are_not() {
        let found = periods(&sines(&[(1.0, 0.43), (0.6, 0.86)])).unwrap();
        assert!((found - 4.3).abs() < 0.02, "{found}");
        assert!(periods(&sines(&[(1.0, 0.7)])).is_some());
        assert_eq!(periods(&sines(&[(1.0, 0.43), (0.3, 0.66)])), None);
        // Less than two periods are no repetition.
        assert_eq!(periods(&sines(&[(1.0, 0.12)])), None);
        let line: Vec<f64> = (0..400).map(f64::from).collect();
        assert_eq!(periods(&line), None);
    }
}
