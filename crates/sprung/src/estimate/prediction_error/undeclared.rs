//! Errors of the parameters by effects that the model lacks and the likelihood sees: laws, delays,
//! saturations.

use super::missing_laws::MissingLaw;
use super::refined::Refined;

/// An effect counts if its estimate exceeds this number of standard errors. Below 5 standard errors
/// no finding reports it, because a log has up to eight tests per joint.
const POSSIBLE_SIGMAS: f64 = 3.0;

/// Returns the possible error of each parameter by undeclared laws, delays and saturations: its
/// largest move with one of them, \[p\]. One effect often looks like several, so their moves do not add.
pub(super) fn bias(refined: &Refined, missing: &[MissingLaw]) -> Vec<f64> {
    let laws = missing.iter().map(|law| (law.significance(), &law.moves));
    let channels = refined.delays.iter().chain(&refined.saturations);
    let channels = channels.map(|own| (own.significance(), &own.moves));
    largest_moves(refined.theta.len(), &refined.free, laws.chain(channels))
}

/// Returns the largest move of each parameter by one of the significant effects, \[p\].
///
/// - `free`: indices of the parameters that move.
/// - `effects`: size of each effect in standard errors, and the moves with it, \[free\].
fn largest_moves<'a>(
    parameters: usize,
    free: &[usize],
    effects: impl Iterator<Item = (f64, &'a Vec<f64>)>,
) -> Vec<f64> {
    let mut largest = vec![0.0_f64; parameters];
    for (_, moves) in effects.filter(|(size, _)| *size > POSSIBLE_SIGMAS) {
        for (&index, own) in free.iter().zip(moves) {
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
            (2.9, vec![9.0, 9.0]),
            (3.1, vec![-0.5, f64::NAN]),
            (8.0, vec![0.2, 0.3]),
            // Nothing determines this effect.
            (f64::NAN, vec![9.0, 9.0]),
            // An estimated delay has no moves: it is among the unknowns.
            (7.0, Vec::new()),
        ];
        let effects = effects.iter().map(|(size, moves)| (*size, moves));
        let found = largest_moves(4, &[1, 3], effects);
        assert_eq!(found, [0.0, 0.5, 0.0, 0.3]);
    }
}
