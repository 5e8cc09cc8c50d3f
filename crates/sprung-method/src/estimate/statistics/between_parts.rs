//! Agreement of estimates from several parts of the logs, and their scatter beyond the standard
//! errors.

use super::chi_square::upper_tail;
use super::normal::NORMAL_95;
use crate::fit::student_95;

/// Probability of a false alarm, for each parameter, below which its confidence interval contains
/// the changes between parts.
const FALSE_ALARM_PROBABILITY: f64 = 0.1;

/// Least degrees of freedom that count for Student's t. With fewer parts the quantile would make
/// every interval useless.
const MIN_FREEDOM: usize = 3;

/// Agreement of estimates of one parameter from several parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Between {
    /// Variance of the parameter between the parts, in the parameter's unit squared.
    pub(crate) variance: f64,
    /// Probability that parts with one value scatter at least as much.
    pub(crate) probability: f64,
    /// Mean, weighted by 1/s².
    pub(crate) mean: f64,
    /// `Σ (x - mean)²/s²`, chi-square if the parts have one value.
    pub(crate) statistic: f64,
    /// Number of parts minus one.
    pub(crate) freedom: usize,
}

impl Between {
    /// Returns the standard error by changes between the parts: zero if the parts agree. Since few
    /// parts give a poor variance, the deviation is multiplied by the ratio of the quantile of
    /// Student's t to that of the normal distribution.
    #[must_use]
    pub(crate) fn standard_error(&self) -> f64 {
        if self.probability > FALSE_ALARM_PROBABILITY {
            return 0.0;
        }
        let quantile = student_95(self.freedom.max(MIN_FREEDOM));
        self.variance.sqrt() * quantile / NORMAL_95
    }
}

/// Compares estimates of one parameter from several parts; `None` for fewer than two parts.
///
/// - `parts`: value and standard error from each part.
///
/// # Source
///
/// A random-effects variance, `τ² = (Q - (k - 1)) / (Σw (1 - 1/k))`, at least zero, with `w = 1/s²`
/// and `Q = Σ w (x - x̄)²`. For equal weights it is that of `DerSimonian` and Laird, "Meta-analysis
/// in clinical trials", 1986. Their divisor `Σw - Σw²/Σw` nearly vanishes if one part has almost
/// all information, for example if the robot stands still in the others; τ² is then meaningless.
#[must_use]
pub(crate) fn between_parts(parts: &[(f64, f64)]) -> Option<Between> {
    if parts.len() < 2 {
        return None;
    }
    let freedom = parts.len() - 1;
    let weights: Vec<f64> = parts.iter().map(|(_, error)| error.powi(-2)).collect();
    let sum: f64 = weights.iter().sum();
    let mean = (parts.iter().zip(&weights).map(|((x, _), w)| w * x)).sum::<f64>() / sum;
    let q: f64 = (parts.iter().zip(&weights))
        .map(|((x, _), w)| w * (x - mean).powi(2))
        .sum();
    let scale = sum * freedom as f64 / parts.len() as f64;
    let variance = ((q - freedom as f64) / scale).max(0.0);
    variance.is_finite().then(|| Between {
        variance,
        probability: upper_tail(q, freedom),
        mean,
        statistic: q,
        freedom,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_errors_give_the_sample_variance_minus_their_square() {
        let parts = [(1.0, 0.5), (4.0, 0.5), (7.0, 0.5)];
        let found = between_parts(&parts).unwrap();
        assert!((found.variance - (9.0 - 0.25)).abs() < 1e-12);
        assert!(found.probability < 1e-12);
        // Two degrees of freedom count as three: 3.182 (table) over 1.960.
        let expected = 8.75_f64.sqrt() * 3.182 / 1.96;
        assert!((found.standard_error() / expected - 1.0).abs() < 0.01);
    }

    #[test]
    fn parts_within_their_errors_have_no_variance() {
        let found = between_parts(&[(1.0, 0.5), (1.4, 0.5), (0.8, 0.4), (1.1, 0.6)]).unwrap();
        assert!(found.variance.abs() < 1e-15 && found.standard_error().abs() < 1e-15);
        assert!(found.probability > 0.5);
        assert_eq!(between_parts(&[(1.0, 0.5)]), None);
    }

    #[test]
    fn a_precise_part_has_a_large_weight() {
        // Weights 4, 16, 16: mean 4/3, Q = 16, Σw (1 - 1/k) = 24.
        let found = between_parts(&[(0.0, 0.5), (2.0, 0.25), (1.0, 0.25)]).unwrap();
        assert!((found.variance - 14.0 / 24.0).abs() < 1e-12);
    }
}
