//! Decides whether samples were taken at the times of their stamps.

use super::cycle::{Cycle, refined};
use super::resample::lagrange;
use super::timing::{Evidence, Sampling};

/// Steps that differ from the period by less than this fraction of it are even.
pub(crate) const EVEN_STEP_PART: f64 = 0.02;

/// Numbers of cycles per usual step that are tried.
const CYCLES_PER_STEP: [f64; 6] = [2.0, 3.0, 4.0, 5.0, 8.0, 10.0];

/// Neighbouring residuals share samples, so this number of them counts as one independent residual.
const SAMPLES_PER_INDEPENDENT: f64 = 4.0;

/// Threshold for the logarithm of the likelihood ratio, 150 to 1.
const DECISIVE_LOG_RATIO: f64 = 5.0;

/// A cycle must reduce the mean square by this factor, because among six tried cycles a short one
/// fits any stamps closely by chance.
const MAX_CYCLE_SQUARE_RATIO: f64 = 0.5;

/// Compares three hypotheses about the times of samples: as stamped, even, or on a cycle. Returns
/// the evidence, and the answer if the evidence is decisive.
///
/// - `times`: stamps, s.
/// - `period`: the usual step, s.
/// - `longest`: steps above this number of periods are gaps.
/// - `channels`: indices and values.
///
/// A time error δ displaces a joint that moves at v by v·δ. So with the right times the samples lie
/// closest to the cubic through their neighbours.
pub(crate) fn weigh(
    times: &[f64],
    period: f64,
    longest: f64,
    channels: &[(usize, &[f64])],
) -> (Evidence, Option<Sampling>) {
    let even = refined(period, times);
    let mut candidates = vec![times.to_vec()];
    for part in std::iter::once(1.0).chain(CYCLES_PER_STEP) {
        candidates.push(ticks(even / part, times));
    }
    let wide = |step: f64| step > longest * period;
    let uneven = |step: f64| (step - period).abs() > EVEN_STEP_PART * period;
    let places: Vec<usize> = (2..times.len().saturating_sub(2))
        .filter(|&k| {
            let mut steps = times[k - 2..k + 3].windows(2).map(|pair| pair[1] - pair[0]);
            steps.clone().any(uneven) && !steps.any(wide)
        })
        .collect();
    let weights: Vec<Vec<[f64; 5]>> = (candidates.iter())
        .map(|times| {
            places
                .iter()
                .map(|&k| of_neighbours(&times[k - 2..k + 3]))
                .collect()
        })
        .collect();
    let mut likelihood = vec![0.0; candidates.len()];
    let mut telling: Option<(f64, usize, Vec<f64>)> = None;
    for &(channel, values) in channels {
        let squares: Vec<f64> = weights
            .iter()
            .map(|weights| mean_square(weights, &places, values))
            .collect();
        if !squares
            .iter()
            .all(|square| *square > 0.0 && square.is_finite())
        {
            continue;
        }
        let scale = 0.5 * places.len() as f64 / SAMPLES_PER_INDEPENDENT;
        for (sum, square) in likelihood.iter_mut().zip(&squares) {
            *sum -= scale * square.ln();
        }
        let least = squares.iter().copied().fold(f64::INFINITY, f64::min);
        let spread = squares[0].max(squares[1]) / least;
        if telling.as_ref().is_none_or(|(most, ..)| spread > *most) {
            telling = Some((spread, channel, squares));
        }
    }
    let (_, channel, squares) = telling.unwrap_or((0.0, 0, vec![0.0; candidates.len()]));
    let mut best = 2;
    for i in 3..candidates.len() {
        if likelihood[i] > likelihood[best] {
            best = i;
        }
    }
    let cycle = even / CYCLES_PER_STEP[best - 2];
    let (stamped, evenly) = (likelihood[0], likelihood[1]);
    let clearly = squares[best] < MAX_CYCLE_SQUARE_RATIO * squares[0].min(squares[1]);
    let answer = if clearly && likelihood[best] - stamped.max(evenly) > DECISIVE_LOG_RATIO {
        Some(Sampling::OnCycle(cycle))
    } else if stamped - evenly > DECISIVE_LOG_RATIO {
        Some(Sampling::AsStamped)
    } else if evenly - stamped > DECISIVE_LOG_RATIO {
        Some(Sampling::Even)
    } else {
        None
    };
    let evidence = Evidence {
        samples: places.len() as u64,
        channel,
        stamped: squares[0].sqrt(),
        even: squares[1].sqrt(),
        on_cycle: (cycle, squares[best].sqrt()),
        decisive: answer.is_some(),
    };
    (evidence, answer)
}

/// Returns the times of the ticks that belong to the stamps.
fn ticks(cycle: f64, times: &[f64]) -> Vec<f64> {
    let mut clock = Cycle::new(cycle, times);
    (0..times.len())
        .map(|k| cycle * clock.next(&times[k..]))
        .collect()
}

/// Returns the weights of five samples for the distance of the middle sample from the cubic through
/// the other four. The weights have norm 1, so white noise gives the same mean square for all
/// times.
fn of_neighbours(times: &[f64]) -> [f64; 5] {
    let others = [times[0], times[1], times[3], times[4]];
    let mut weights = [0.0; 5];
    weights[2] = 1.0;
    for (i, place) in [0, 1, 3, 4].into_iter().enumerate() {
        weights[place] = -lagrange(&others, i, times[2]);
    }
    let size = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
    weights.map(|w| w / size)
}

fn mean_square(weights: &[[f64; 5]], places: &[usize], values: &[f64]) -> f64 {
    let mut sum = 0.0;
    for (weights, &k) in weights.iter().zip(places) {
        // Values are taken relative to the middle one, so large positions lose no digits.
        let (middle, near) = (values[k], &values[k - 2..k + 3]);
        let miss: f64 = weights
            .iter()
            .zip(near)
            .map(|(w, x)| w * (x - middle))
            .sum();
        sum += miss * miss;
    }
    sum / places.len().max(1) as f64
}
