//! Estimates the noise of positions and velocities from a log.

use super::excerpt::Excerpt;
use crate::description::LinkPosition;
use crate::log::{Channels, Measures};
use crate::model::Model;
use crate::regression::VelocityNoise;

/// Limit of the samples that the noise is estimated from.
const MAX_SAMPLES: usize = 20_000;

/// Returns the standard deviation of a channel's noise, and the step between its values if it is
/// quantised; `None` if the channel is constant.
pub fn noise(excerpt: &Excerpt, channel: usize) -> Option<(f64, Option<f64>)> {
    let values = beginning(excerpt, channel);
    let largest = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let steps: Vec<f64> = (values.windows(2))
        .map(|w| (w[1] - w[0]).abs())
        // Rounding errors are not steps.
        .filter(|step| *step > 1e-9 * largest)
        .collect();
    let smallest = steps.iter().copied().fold(f64::INFINITY, f64::min);
    if !smallest.is_finite() {
        return None;
    }
    let whole = (steps.iter())
        .filter(|step| {
            let counts = *step / smallest;
            (counts - counts.round()).abs() < 0.05 * counts.clamp(1.0, 4.0)
        })
        .count();
    let few = steps.iter().filter(|step| **step < 1.5 * smallest).count();
    // Values between steps would not be multiples of the smallest difference.
    let quantised = whole * 50 >= steps.len() * 49 && few * 100 >= steps.len();
    let white = white_noise(&values);
    let step = quantised.then_some(smallest);
    Some((
        step.map_or(0.0, |step| step / 12_f64.sqrt()).max(white),
        step,
    ))
}

fn beginning(excerpt: &Excerpt, channel: usize) -> Vec<f64> {
    (excerpt.blocks().iter())
        .flat_map(|block| &block.values[channel])
        .copied()
        .take(MAX_SAMPLES)
        .collect()
}

/// Returns the standard deviation of the noise of a channel's samples, with that of its counts. Unlike the median of
/// [`white_noise`], it is not confined to the steps of an encoder. Three quarters of the samples must change little.
pub(crate) fn sample_noise(excerpt: &Excerpt, channel: usize) -> f64 {
    noise_of_samples(beginning(excerpt, channel))
}

/// Order of the differences: motion hardly shows in them. White noise has 252 times its variance.
const ORDER: usize = 5;
const VARIANCE_OF_DIFFERENCES: f64 = 252.0;

/// Mean of the absolute values of the three quarters of a standard normal distribution that are nearest to zero.
const MEAN_OF_THREE_QUARTERS: f64 = 0.514_86;

fn noise_of_samples(mut values: Vec<f64>) -> f64 {
    for _ in 0..ORDER {
        values = values.windows(2).map(|w| w[1] - w[0]).collect();
    }
    let kept = 3 * values.len() / 4;
    if kept == 0 {
        return 0.0;
    }
    let mut sizes: Vec<f64> = values.iter().map(|value| value.abs()).collect();
    sizes.select_nth_unstable_by(kept, f64::total_cmp);
    let mean = sizes[..kept].iter().sum::<f64>() / kept as f64;
    mean / (MEAN_OF_THREE_QUARTERS * VARIANCE_OF_DIFFERENCES.sqrt())
}

/// Returns the standard deviation of the white noise on a signal. Most samples must change little
/// over three periods.
pub(crate) fn white_noise(values: &[f64]) -> f64 {
    let mut third: Vec<f64> = (values.windows(4))
        .map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).abs())
        .collect();
    let median = match third.len() / 2 {
        0 => third.first().copied().unwrap_or(0.0),
        half => *third.select_nth_unstable_by(half, f64::total_cmp).1,
    };
    // A third difference of white noise has 20 times its variance; 1.4826 converts the median.
    1.4826 * median / 20_f64.sqrt()
}

/// Returns the standard deviation of a filtered velocity over that of the position's white noise,
/// 1/s.
///
/// - `cutoff`: f, Hz; `period`: T, s.
///
/// # Source
///
/// Noise of standard deviation s, filtered twice at `f` and differentiated, has
/// the standard deviation `s √(2 f T) 2π f / √3`.
#[must_use]
pub(crate) fn velocity_per_position(cutoff: f64, period: f64) -> f64 {
    (2.0 * cutoff * period).sqrt() * std::f64::consts::TAU * cutoff / 3_f64.sqrt()
}

/// Returns the noise of the filtered velocities, estimated from the positions.
///
/// - `cutoff`: of the position filter, Hz.
#[must_use]
pub(crate) fn velocity_noise(
    model: &Model,
    channels: &Channels,
    excerpt: &Excerpt,
    cutoff: f64,
) -> VelocityNoise {
    let n = model.joint_count();
    let scale = velocity_per_position(cutoff, excerpt.period());
    let (mut link, mut motor) = (vec![0.0_f64; n], vec![0.0_f64; n]);
    let mut from_motor: Vec<bool> = (0..n).map(|joint| !model.is_flexible(joint)).collect();
    for (i, channel) in channels.all.iter().enumerate() {
        let level = || scale * noise(excerpt, i).map_or(0.0, |(noise, _)| noise);
        let joint = channel.joint;
        match channel.quantity.measures() {
            Measures::Position {
                link: of_link,
                motor: of_motor,
            } if of_link != 0.0 => {
                link[joint] = level();
                from_motor[joint] |= of_motor != 0.0;
            }
            Measures::Position { .. } => motor[joint] = level(),
            Measures::RightHandSide(_)
            | Measures::Target
            | Measures::Switch
            | Measures::Motion(..)
            | Measures::Covariate(_) => {}
        }
    }
    for (from_motor, instrument) in from_motor.iter_mut().zip(channels.instruments.iter()) {
        *from_motor |= instrument.link_position() == LinkPosition::ByTorque;
    }
    // Link positions that are measured relative to the motor contain the motor's noise too.
    for joint in (0..n).filter(|&joint| from_motor[joint]) {
        link[joint] = link[joint].hypot(motor[joint]);
    }
    VelocityNoise { link, motor }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    use super::*;

    /// The steps of an encoder, also where the decimals of a log hide them, do not confine the noise.
    #[test]
    fn noise_of_less_than_a_count_is_found() {
        const SAMPLES: usize = 20_000;
        for (deviation, decimals) in [(0.4, 1e-9), (0.4, 0.01), (0.7, 1e-9), (3.0, 1e-9)] {
            let mut rng = ChaCha8Rng::seed_from_u64(1);
            let values: Vec<f64> = (0..SAMPLES)
                .map(|k| {
                    let noise: f64 = rng.sample(StandardNormal);
                    let counts = (500.0 * (1e-3 * k as f64).sin() + deviation * noise).round();
                    (0.8713 * counts / decimals).round() * decimals
                })
                .collect();
            // Rounding to counts adds its own noise.
            let expected = 0.8713 * f64::hypot(deviation, 12_f64.sqrt().recip());
            let found = noise_of_samples(values);
            assert!(
                (found / expected - 1.0).abs() < 0.06,
                "{deviation}, {decimals}: {found} instead of {expected}"
            );
        }
    }
}
