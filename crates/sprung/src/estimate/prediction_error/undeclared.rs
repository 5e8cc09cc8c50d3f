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
    let mut bias = vec![0.0_f64; refined.theta.len()];
    for (_, moves) in laws
        .chain(channels)
        .filter(|(own, _)| *own > POSSIBLE_SIGMAS)
    {
        for (&index, own) in refined.free.iter().zip(moves) {
            if own.is_finite() {
                bias[index] = bias[index].max(own.abs());
            }
        }
    }
    bias
}
