//! Standard errors from the scatter of the score over segments of the log.
//!
//! The inverse of the information is the covariance only if the innovations are white with the
//! variance that the filter expects. With model error the score of neighbouring samples is
//! correlated. Sums over overlapping segments show its variance (Bartlett weights).
//!
//! # Source
//!
//! Newey and West, Econometrica 1987; White, Econometrica 1982: "Maximum likelihood estimation of
//! misspecified models".

use sprung_core::linear::dot;

use crate::estimate::statistics::HELD_OUT_PARTS;

/// Lengths of the segments, s. Friction repeats with the motion, so the longest segment has the
/// length of a motion.
const SEGMENTS_S: [f64; 4] = [0.25, 0.5, 1.0, 2.0];

/// A number that is a linear function of the gradient about the optimum: an unknown, or the delay
/// of a channel.
pub(super) struct Influence {
    /// Derivatives of minus the number by the gradient.
    pub(super) row: Vec<f64>,
    /// Variance of the number by the information.
    pub(super) variance: f64,
}

/// Returns the factor of each number's standard error: the largest ratio of the standard error by
/// segments of the score to that by the information, at least 1.
///
/// - `gradients`: gradients after growing parts of equal length, \[parts × unknowns\].
/// - `duration`: length of the log, s.
pub(super) fn widening(
    influences: &[&Influence],
    gradients: &[Vec<f64>],
    duration: f64,
) -> Vec<f64> {
    let of_number = |influence: &&Influence| {
        let score: Vec<f64> = gradients
            .iter()
            .map(|part| dot(&influence.row, part))
            .collect();
        let Some(whole) = score.last().copied() else {
            return 1.0;
        };
        let share = |part: usize| (part + 1) as f64 / score.len() as f64;
        let centred = score.iter().enumerate();
        let centred: Vec<f64> = centred
            .map(|(part, value)| value - share(part) * whole)
            .collect();
        widening_of(&centred, influence.variance, duration)
    };
    influences.iter().map(of_number).collect()
}

/// Returns the factor of the standard error of one number.
///
/// - `growing`: influence of growing parts of equal length on the number, without its mean; the last one is zero.
/// - `variance`: of the number by the information; `duration`: length of the log, s.
pub(super) fn widening_of(growing: &[f64], variance: f64, duration: f64) -> f64 {
    let parts = growing.len();
    let up_to = |part: usize| part.checked_sub(1).map_or(0.0, |last| growing[last]);
    let mut widest = 1.0_f64;
    for seconds in SEGMENTS_S {
        let length = (seconds / duration * parts as f64).round() as usize;
        // Fewer segments give a poor variance.
        if length == 0 || length * HELD_OUT_PARTS > parts {
            continue;
        }
        let segments = parts + 1 - length;
        // Centring removes a part of the variance, the same as of a mean.
        let share = length as f64 / parts as f64;
        let scale = parts as f64 / (segments * length) as f64 / (1.0 - share);
        let sum: f64 = (0..segments)
            .map(|from| (up_to(from + length) - up_to(from)).powi(2))
            .sum();
        widest = widest.max((scale * sum / variance).sqrt());
    }
    widest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the growing sums of a score of two unknowns: one white, the other constant over
    /// `run` parts.
    fn gradients(parts: usize, run: usize) -> Vec<Vec<f64>> {
        let mut state = 7_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let (mut sum, mut held) = (vec![0.0; 2], 0.0);
        (0..parts)
            .map(|part| {
                if part % run == 0 {
                    held = random();
                }
                sum[0] += random();
                sum[1] += held;
                sum.clone()
            })
            .collect()
    }

    #[test]
    fn correlated_scores_widen_and_white_ones_do_not() {
        let (parts, run) = (4000, 10);
        // Information of a score whose parts are independent, with the variance 1/12 each.
        let variance = 12.0 / parts as f64;
        let influence = |row: [f64; 2]| Influence {
            row: row.to_vec(),
            variance,
        };
        let (white, slow) = (influence([variance, 0.0]), influence([0.0, variance]));
        let found = widening(&[&white, &slow], &gradients(parts, run), 400.0);
        assert!(found[0] < 1.3, "{found:?}");
        let expected = (run as f64).sqrt();
        assert!((0.7..1.3).contains(&(found[1] / expected)), "{found:?}");
    }

    #[test]
    fn a_short_log_keeps_the_information() {
        let unknown = Influence {
            row: vec![1.0],
            variance: 1.0,
        };
        let one: Vec<Vec<f64>> = (0..400).map(|part| vec![f64::from(part % 7)]).collect();
        assert_eq!(widening(&[&unknown], &one, 1.0), [1.0]);
        assert_eq!(widening(&[&unknown], &[], 40.0), [1.0]);
    }
}
