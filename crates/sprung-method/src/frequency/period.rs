//! Finds the period of a motion that repeats itself.

use faer::c64;

use super::fourier::{smooth_length, transforms};
use super::record::Segment;

/// Samples of a position in the search, before it is repeated with all samples near the result.
const SEARCH_SAMPLES: usize = 4096;

/// Correlation with the motion one period earlier: the least of a first guess, and the largest
/// correlation before it, so that a slow motion is not its own repetition.
const GUESS_CORRELATION: f64 = 0.9;
const BETWEEN_CORRELATION: f64 = 0.7;

/// Largest root mean square of the change over a period, relative to the motion.
const MAX_CHANGE: f64 = 0.03;

/// Returns the period of the motion in samples of the segment, if all joints that move repeat their
/// motion at least once.
#[must_use]
pub(super) fn period(segment: &Segment) -> Option<usize> {
    let joints = 0..segment.joints();
    let moving: Vec<&[f64]> = (joints.map(|joint| segment.motor(joint)))
        .filter(|motion| variance(motion) > 0.0)
        .collect();
    let every = segment.len().div_ceil(SEARCH_SAMPLES).max(1);
    let guess = guess(&moving, every)? * every;
    let near = guess.saturating_sub(2 * every).max(1)..=guess + 2 * every;
    let (period, change) = near
        .filter(|period| 2 * period <= segment.len())
        .map(|period| (period, change(&moving, period)))
        .min_by(|a, b| a.1.total_cmp(&b.1))?;
    (change < MAX_CHANGE.powi(2)).then_some(period)
}

/// Returns the first shift, in steps of `every` samples, at which the mean correlation of the
/// joints has a high peak.
fn guess(moving: &[&[f64]], every: usize) -> Option<usize> {
    let count = moving.first()?.len() / every;
    let padded = smooth_length(2 * count + 2 * count / 10);
    if count < 8 || padded < 2 * count {
        return None;
    }
    let mut correlation = vec![0.0; count / 2 + 1];
    for motion in moving {
        let mean = motion.iter().sum::<f64>() / motion.len() as f64;
        let thinned: Vec<f64> = (motion.iter().step_by(every).take(count))
            .map(|x| x - mean)
            .chain(std::iter::repeat_n(0.0, padded - count))
            .collect();
        let spectrum = transforms(&[&thinned], padded / 2).pop()?;
        let power: Vec<f64> = (0..padded)
            .map(|m| spectrum.get(m.min(padded - m)).map_or(0.0, c64::norm_sqr))
            .collect();
        let found = transforms(&[&power], padded / 2).pop()?;
        let whole = found[0].re;
        for (shift, sum) in correlation.iter_mut().enumerate() {
            let overlap = count as f64 / (count - shift) as f64;
            *sum += found[shift].re / whole * overlap / moving.len() as f64;
        }
    }
    let left = (correlation.iter()).position(|value| *value < BETWEEN_CORRELATION)?;
    let behind = correlation[left..].iter();
    let first = left
        + behind
            .clone()
            .position(|value| *value > GUESS_CORRELATION)?;
    (first..correlation.len())
        .take_while(|&shift| correlation[shift] > GUESS_CORRELATION)
        .max_by(|&a, &b| correlation[a].total_cmp(&correlation[b]))
}

/// Returns the mean square change over a shift at the end of the motion, relative to the variance, of
/// the joint with the largest one.
fn change(moving: &[&[f64]], shift: usize) -> f64 {
    let of = |motion: &&[f64]| {
        let last = &motion[motion.len() - shift..];
        let before = &motion[motion.len() - 2 * shift..];
        let squares: f64 = (last.iter().zip(before))
            .map(|(a, b)| (a - b).powi(2))
            .sum();
        squares / shift as f64 / variance(last)
    };
    moving.iter().map(of).fold(0.0, f64::max)
}

fn variance(values: &[f64]) -> f64 {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count
}
