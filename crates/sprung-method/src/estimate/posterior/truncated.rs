//! Draws of a standard normal distribution between two ends.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// Width above which normal draws are tried between ends on both sides of zero: the acceptance rate is then at least
/// that of uniform draws.
const WIDE: f64 = 2.5;

/// Returns a draw of the standard normal distribution between two ends, by rejection; the nearest end to zero if they
/// contain nothing.
///
/// # Source
///
/// Robert, "Simulation of truncated normal variables", Statistics and Computing, 1995.
pub(super) fn draw([low, high]: [f64; 2], rng: &mut ChaCha8Rng) -> f64 {
    if low.is_nan() || high.is_nan() || low >= high {
        return 0.0_f64.max(low).min(high);
    }
    if high < 0.0 {
        return -draw([-high, -low], rng);
    }
    if low <= 0.0 {
        if high - low > WIDE {
            loop {
                let z: f64 = rng.sample(StandardNormal);
                if z >= low && z <= high {
                    return z;
                }
            }
        }
        return uniform([low, high], 0.0, rng);
    }
    // The exponential distribution that is accepted most often beyond the lower end.
    let rate = f64::midpoint(low, (low * low + 4.0).sqrt());
    if (high - low) * rate < 1.0 {
        return uniform([low, high], low, rng);
    }
    loop {
        let z = low - rng.random::<f64>().max(f64::MIN_POSITIVE).ln() / rate;
        let accepted = (-0.5 * (z - rate).powi(2)).exp();
        if z <= high && rng.random::<f64>() <= accepted {
            return z;
        }
    }
}

/// - `most_likely`: point between the ends where the density is largest.
fn uniform([low, high]: [f64; 2], most_likely: f64, rng: &mut ChaCha8Rng) -> f64 {
    loop {
        let z = low + (high - low) * rng.random::<f64>();
        let accepted = (0.5 * (most_likely * most_likely - z * z)).exp();
        if rng.random::<f64>() <= accepted {
            return z;
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    /// Returns mean and variance of the distribution, by summation.
    fn moments([low, high]: [f64; 2]) -> [f64; 2] {
        let (low, high) = (low.max(-12.0), high.min(12.0));
        let steps = 200_000;
        let mut sums = [0.0; 3];
        for k in 0..steps {
            let z = low + (high - low) * (f64::from(k) + 0.5) / f64::from(steps);
            let density = (0.5 * (low.max(0.0).powi(2) - z * z)).exp();
            for (power, sum) in (0..).zip(&mut sums) {
                *sum += density * z.powi(power);
            }
        }
        let mean = sums[1] / sums[0];
        [mean, sums[2] / sums[0] - mean * mean]
    }

    #[test]
    fn draws_have_mean_and_variance_of_the_distribution_between_the_ends() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let infinite = f64::INFINITY;
        for ends in [
            [-infinite, infinite],
            [-0.3, 0.4],
            [-0.5, 3.0],
            [0.2, infinite],
            [3.0, infinite],
            [3.0, 3.1],
            [6.0, 9.0],
            [-infinite, -4.0],
            [0.5, 1.5],
        ] {
            let count = 40_000;
            let draws: Vec<f64> = (0..count).map(|_| draw(ends, &mut rng)).collect();
            assert!(draws.iter().all(|z| *z >= ends[0] && *z <= ends[1]));
            let mean = draws.iter().sum::<f64>() / f64::from(count);
            let variance = draws.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / f64::from(count);
            let [expected, spread] = if ends[1] < 0.0 {
                let [mean, spread] = moments([-ends[1], -ends[0]]);
                [-mean, spread]
            } else {
                moments(ends)
            };
            assert!(
                (mean - expected).abs() < 4.0 * (spread / f64::from(count)).sqrt(),
                "{ends:?}: {mean} {expected}"
            );
            assert!(
                (variance / spread - 1.0).abs() < 0.05,
                "{ends:?}: {variance} {spread}"
            );
        }
    }

    #[test]
    fn ends_that_contain_nothing_do_not_hang() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        assert!(draw([1.0, 1.0], &mut rng) <= 1.0);
        assert!(draw([2.0, 1.0], &mut rng) <= 2.0);
        let _ = draw([f64::NAN, 1.0], &mut rng);
    }
}
