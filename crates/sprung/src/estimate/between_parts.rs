//! Whether estimates from several parts of the logs agree, and how much they scatter beyond their
//! standard errors.

use super::chi_square::upper_tail;

/// Agreement of estimates of one parameter from several parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Between {
    /// Variance of the parameter between the parts, in the parameter's unit squared.
    pub(crate) variance: f64,
    /// Probability that parts with one value scatter at least as much.
    pub(crate) probability: f64,
}

/// Compares estimates of one parameter from several parts; `None` for fewer than two parts.
///
/// - `parts`: value and standard error from each part.
///
/// # Source
///
/// The random-effects variance of `DerSimonian` and Laird, "Meta-analysis in clinical trials",
/// 1986: `τ² = (Q - (k - 1)) / (Σw - Σw²/Σw)`, at least zero, with `w = 1/s²` and
/// `Q = Σ w (x - x̄)²`.
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
    let scale = sum - weights.iter().map(|w| w * w).sum::<f64>() / sum;
    let variance = ((q - freedom as f64) / scale).max(0.0);
    variance.is_finite().then(|| Between {
        variance,
        probability: upper_tail(q, freedom),
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
    }

    #[test]
    fn parts_within_their_errors_have_no_variance() {
        let found = between_parts(&[(1.0, 0.5), (1.4, 0.5), (0.8, 0.4), (1.1, 0.6)]).unwrap();
        assert!(found.variance.abs() < 1e-15);
        assert!(found.probability > 0.5);
        assert_eq!(between_parts(&[(1.0, 0.5)]), None);
    }

    #[test]
    fn a_precise_part_has_a_large_weight() {
        // Weights 4, 16, 16: mean 4/3, Q = 16, Σw - Σw²/Σw = 36 - 528/36.
        let found = between_parts(&[(0.0, 0.5), (2.0, 0.25), (1.0, 0.25)]).unwrap();
        assert!((found.variance - 14.0 / (36.0 - 528.0 / 36.0)).abs() < 1e-12);
    }
}
