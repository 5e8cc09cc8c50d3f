//! What the residuals of a healthy robot look like: their variance by the state, and how often they exceed a threshold.

use super::residual::FEATURES;

/// Part of the torque of a joint (root mean square) that no model foretells of another motion.
const UNFORESEEN: f64 = 0.01;

/// Rounds of the fit of a variance.
const ROUNDS: usize = 60;

/// Time for which a residual must stay below its threshold until an event has ended, s.
pub(super) const HOLD_S: f64 = 0.25;

/// Part of the peaks of healthy motion that are its tail.
const TAIL: f64 = 0.4;

/// Least peaks of a tail.
const LEAST_PEAKS: usize = 12;

/// Shapes of a tail: the exponent of the size in the logarithm of the rate. 2 is that of normal noise, 1 that of errors of a model.
const SHAPES: [f64; 3] = [1.0, 1.5, 2.0];

/// A residual at one time, and the quantities with which its error grows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Instant {
    /// N·m (N).
    pub(super) value: f64,
    pub(super) features: [f64; FEATURES],
    /// Variance by the errors of the parameters, (N·m)² (N²).
    pub(super) of_parameters: f64,
    /// Whether the filters have begun just before.
    pub(super) begins: bool,
}

/// The variance of a residual by the state: a sum of features with coefficients that are not negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Variance(pub(super) [f64; FEATURES]);

impl Variance {
    /// Fits a variance to a healthy residual by maximum likelihood of normal noise, with multiplicative steps.
    ///
    /// # Source
    ///
    /// Févotte, Bertin and Durrieu, Neural Computation 2009: steps for the divergence of Itakura and Saito, which is this likelihood.
    pub(super) fn fit(all: &[Instant]) -> Self {
        let count = all.len().max(1) as f64;
        let mean = |of: &dyn Fn(&Instant) -> f64| all.iter().map(of).sum::<f64>() / count;
        let target = |x: &Instant| x.value * x.value + x.of_parameters;
        let whole = mean(&target).max(f64::MIN_POSITIVE);
        let mut coefficients: [f64; FEATURES] = std::array::from_fn(|at| {
            let size = mean(&|x: &Instant| x.features[at]);
            if size > 0.0 {
                whole / (FEATURES as f64 * size)
            } else {
                0.0
            }
        });
        for _ in 0..ROUNDS {
            let (mut up, mut down) = ([0.0; FEATURES], [0.0; FEATURES]);
            let variance = Self(coefficients);
            for x in all {
                let inverse = variance.at(&x.features).recip();
                for at in 0..FEATURES {
                    up[at] += x.features[at] * target(x) * inverse * inverse;
                    down[at] += x.features[at] * inverse;
                }
            }
            for at in 0..FEATURES {
                if down[at] > 0.0 {
                    coefficients[at] *= (up[at] / down[at]).sqrt();
                }
            }
        }
        coefficients[0] += UNFORESEEN * UNFORESEEN * mean(&|x: &Instant| x.features[2]);
        Self(coefficients)
    }

    /// Returns the variance at a state, (N·m)² (N²).
    pub(super) fn at(&self, features: &[f64; FEATURES]) -> f64 {
        let sum: f64 = (self.0.iter().zip(features)).map(|(a, f)| a * f).sum();
        sum.max(f64::MIN_POSITIVE)
    }
}

/// How often the peaks of a residual in standard deviations exceed a threshold:
///
/// ```text
/// rate(u) = ν (1 + (u^κ − u₀^κ)/(m s))^(−m)      u ≥ u₀
/// ```
///
/// This is an exponential law whose scale s is the mean of m peaks, with the error of this mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tail {
    /// κ.
    pub(super) shape: f64,
    /// s.
    pub(super) scale: f64,
    /// u₀.
    pub(super) begin: f64,
    /// ν, 1/s.
    pub(super) rate: f64,
    /// m.
    pub(super) count: f64,
}

impl Tail {
    /// Fits the tails of all joints, which have one shape; a joint with too few peaks gets the tail of all together. `None` if all
    /// together have too few.
    ///
    /// - `peaks`: of healthy motion, joint by joint; `duration`: of the motion, s.
    pub(super) fn all(peaks: &[Vec<f64>], duration: f64) -> Vec<Option<Self>> {
        let tails: Vec<Option<Peaks>> = peaks.iter().map(|peaks| Peaks::new(peaks)).collect();
        let Some(pooled) = Peaks::new(&peaks.concat()) else {
            return vec![None; peaks.len()];
        };
        let likelihood = |shape: f64| -> f64 {
            let own = tails
                .iter()
                .flatten()
                .map(|tail| tail.likelihood(shape))
                .sum::<f64>();
            if own == 0.0 {
                pooled.likelihood(shape)
            } else {
                own
            }
        };
        let best = SHAPES
            .into_iter()
            .max_by(|a, b| likelihood(*a).total_cmp(&likelihood(*b)));
        let shape = best.unwrap_or(SHAPES[0]);
        let count = peaks
            .iter()
            .filter(|peaks| !peaks.is_empty())
            .count()
            .max(1) as f64;
        (tails.iter())
            .map(|own| match own {
                Some(own) => Some(own.tail(shape, duration)),
                None => Some(pooled.tail(shape, duration * count)),
            })
            .collect()
    }

    /// Returns the threshold that healthy motion exceeds at a rate, 1/s.
    ///
    /// It is at least that of normal noise with the same variance: the variance contains the errors of the parameters, which the healthy
    /// logs, to which they were fitted, do not show.
    ///
    /// - `bandwidth`: of the residual, rad/s.
    pub(super) fn threshold(&self, rate: f64, bandwidth: f64) -> f64 {
        let crossings = bandwidth / std::f64::consts::TAU;
        let of_noise = (2.0 * (crossings / rate).max(1.0).ln()).sqrt();
        self.of_tail(rate).max(of_noise)
    }

    fn of_tail(&self, rate: f64) -> f64 {
        let growth = (self.rate / rate).max(1.0).powf(self.count.recip()) - 1.0;
        let beyond = self.count * self.scale * growth;
        (self.begin.powf(self.shape) + beyond).powf(self.shape.recip())
    }
}

/// The largest peaks of a motion.
struct Peaks {
    /// Largest peak that does not belong to the tail.
    begin: f64,
    tail: Vec<f64>,
}

impl Peaks {
    fn new(peaks: &[f64]) -> Option<Self> {
        let mut tail = peaks.to_vec();
        tail.sort_by(|a, b| b.total_cmp(a));
        let count = ((TAIL * tail.len() as f64) as usize).max(LEAST_PEAKS);
        let begin = *tail.get(count)?;
        tail.truncate(count);
        Some(Self { begin, tail })
    }

    fn scale(&self, shape: f64) -> f64 {
        let beyond = self
            .tail
            .iter()
            .map(|u| u.powf(shape) - self.begin.powf(shape));
        (beyond.sum::<f64>() / self.tail.len() as f64).max(f64::MIN_POSITIVE)
    }

    /// Returns the log-likelihood of a shape with its best scale.
    fn likelihood(&self, shape: f64) -> f64 {
        let slopes = self.tail.iter().map(|u| (shape * u.powf(shape - 1.0)).ln());
        slopes.sum::<f64>() - self.tail.len() as f64 * (self.scale(shape).ln() + 1.0)
    }

    fn tail(&self, shape: f64, duration: f64) -> Tail {
        Tail {
            shape,
            scale: self.scale(shape),
            begin: self.begin,
            rate: self.tail.len() as f64 / duration.max(f64::MIN_POSITIVE),
            count: self.tail.len() as f64,
        }
    }
}

/// Returns the largest value of each excursion of a residual beyond a level, in standard deviations.
pub(super) fn peaks(all: &[Instant], variance: &Variance, level: f64) -> Vec<f64> {
    let mut peaks = Vec::new();
    let mut largest = 0.0_f64;
    for x in all {
        let size = x.value.abs() / variance.at(&x.features).sqrt();
        if size > level && !x.begins {
            largest = largest.max(size);
        } else if largest > 0.0 {
            peaks.push(largest);
            largest = 0.0;
        }
    }
    peaks
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    use super::*;

    /// Normal noise with the correlation of a filter, whose variance grows with a speed.
    fn noise(count: usize, seed: u64) -> Vec<Instant> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut state = 0.0;
        (0..count)
            .map(|k| {
                let pole = 0.6_f64;
                let shock: f64 = random.sample(StandardNormal);
                state = pole * state + (1.0 - pole * pole).sqrt() * shock;
                let speed = (0.01 * k as f64).sin().powi(2);
                Instant {
                    value: state * (0.04 + 0.09 * speed).sqrt(),
                    features: [1.0, speed, 0.0, 0.0, 0.0],
                    of_parameters: 0.0,
                    begins: k == 0,
                }
            })
            .collect()
    }

    #[test]
    fn a_variance_that_grows_with_the_speed_is_found() {
        let variance = Variance::fit(&noise(20_000, 1));
        for (speed, expected) in [(0.0, 0.04), (0.5, 0.085), (1.0, 0.13)] {
            let found = variance.at(&[1.0, speed, 0.0, 0.0, 0.0]);
            assert!((found / expected - 1.0).abs() < 0.1, "{speed}: {found}");
        }
    }

    #[test]
    fn other_noise_exceeds_a_threshold_at_the_promised_rate() {
        let (period, learned) = (0.01, noise(6_000, 2));
        let variance = Variance::fit(&learned);
        let all = peaks(&learned, &variance, 1.0);
        let tail = Tail::all(&[all], 60.0)[0].unwrap();
        let other = noise(400_000, 3);
        for rate in [1.0, 0.1] {
            let above = peaks(&other, &variance, tail.threshold(rate, 50.0)).len() as f64;
            let promised = rate * period * 400_000.0;
            // The threshold is at least that of noise of the bandwidth, which crosses it less often.
            assert!(above < 2.0 * promised, "{rate}: {above} of {promised}");
            assert!(above > promised / 8.0, "{rate}: {above} of {promised}");
        }
    }

    #[test]
    fn few_peaks_give_no_tail_and_few_of_one_joint_that_of_all() {
        let some: Vec<f64> = (0..8).map(|k| 1.0 + 0.1 * f64::from(k)).collect();
        assert_eq!(Tail::all(std::slice::from_ref(&some), 10.0), [None]);
        let many: Vec<f64> = (0..40).map(|k| 1.0 + 0.05 * f64::from(k)).collect();
        let both = Tail::all(&[some, many], 10.0);
        assert!(both.iter().all(Option::is_some));
    }
}
