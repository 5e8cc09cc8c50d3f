//! Errors of the parameters by effects that the model lacks and the likelihood sees: laws, delays,
//! saturations, eccentric encoders.

use super::missing_laws::MissingLaw;
use super::refined::Refined;
use crate::estimate::statistics::SIGNIFICANT_SIGMAS;

/// Error of the correction for noise of the logged torques, relative to the correction. Tests of the
/// correction show up to 10 % for single parameters.
const ERROR_OF_NOISE_CORRECTION: f64 = 0.05;

/// Returns the possible error of each parameter by undeclared laws, delays, saturations and
/// eccentricities: its largest move with one of them, \[p\]. One effect often looks like several, so
/// their moves do not add. The error of the correction for noise counts as such a move.
pub(super) fn bias(refined: &Refined, missing: &[MissingLaw]) -> Vec<f64> {
    let laws = missing.iter().map(|law| (law.significance(), &law.moves));
    let channels = (refined.delays.iter())
        .chain(&refined.torques_delay)
        .chain(&refined.saturations)
        .chain(&refined.eccentricities)
        .filter(|own| !own.estimated)
        .map(|own| (own.significance(), &own.moves));
    let effects: Vec<(f64, &Vec<f64>)> = laws.chain(channels).collect();
    let mut largest = largest_moves(refined.theta.len(), &refined.free, &effects);
    for (&index, moved) in refined.free.iter().zip(&refined.by_noise) {
        largest[index] = largest[index].max(ERROR_OF_NOISE_CORRECTION * moved.abs());
    }
    largest
}

/// Returns the number of standard errors beyond which an effect counts. It grows with the number of
/// tested effects, so that a log without any exceeds it with the same probability.
///
/// ```text
/// z² = 3² + 2 ln n
/// ```
fn limit(tested: usize) -> f64 {
    (SIGNIFICANT_SIGMAS.powi(2) + 2.0 * (tested.max(1) as f64).ln()).sqrt()
}

/// Returns the largest move of each parameter by one of the significant effects, \[p\].
///
/// - `free`: indices of the parameters that move.
/// - `effects`: size of each effect in standard errors, and the moves with it, \[free\].
fn largest_moves(parameters: usize, free: &[usize], effects: &[(f64, &Vec<f64>)]) -> Vec<f64> {
    let mut largest = vec![0.0_f64; parameters];
    let tested = effects.iter().filter(|(size, _)| size.is_finite()).count();
    let limit = limit(tested);
    for (_, moves) in effects.iter().filter(|(size, _)| *size > limit) {
        for (&index, own) in free.iter().zip(moves.iter()) {
            if own.is_finite() {
                largest[index] = largest[index].max(own.abs());
            }
        }
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_move_by_a_significant_effect_counts() {
        let effects = [
            (3.3, vec![9.0, 9.0]),
            (3.5, vec![-0.5, f64::NAN]),
            (8.0, vec![0.2, 0.3]),
            // Nothing determines this effect.
            (f64::NAN, vec![9.0, 9.0]),
        ];
        let effects: Vec<(f64, &Vec<f64>)> = (effects.iter())
            .map(|(size, moves)| (*size, moves))
            .collect();
        let found = largest_moves(4, &[1, 3], &effects);
        assert_eq!(found, [0.0, 0.5, 0.0, 0.3]);
    }

    /// Probability beyond z standard errors on both sides, by its asymptotic series.
    fn beyond(z: f64) -> f64 {
        (2.0 / std::f64::consts::PI).sqrt() * (-z * z / 2.0).exp() / z * (1.0 - 1.0 / (z * z))
    }

    #[test]
    fn more_tests_raise_no_more_alarms() {
        let one = beyond(limit(1));
        for tested in [2, 8, 60] {
            let any = tested as f64 * beyond(limit(tested));
            assert!((0.6..1.05).contains(&(any / one)), "{tested}: {any} {one}");
        }
    }
}
