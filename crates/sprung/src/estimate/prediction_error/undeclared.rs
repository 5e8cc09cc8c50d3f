//! Errors of the parameters by effects that the model lacks and the likelihood sees: laws and delays.

use super::missing_laws::MissingLaw;
use super::refined::Refined;

/// An effect counts if its estimate exceeds this number of standard errors. Below 5 standard errors
/// no finding reports it, because a log has up to seven tests per joint.
const POSSIBLE_SIGMAS: f64 = 3.0;

/// Returns the possible error of each parameter by undeclared laws and delays: its largest move with
/// one of them, \[p\]. One effect often looks like several, so their moves do not add.
pub(super) fn bias(refined: &Refined, missing: &[MissingLaw]) -> Vec<f64> {
    let laws = missing.iter().map(|law| (law.significance(), &law.moves));
    let delays = (refined.delays.iter()).map(|delay| (delay.significance(), &delay.moves));
    let mut bias = vec![0.0_f64; refined.theta.len()];
    for (_, moves) in laws.chain(delays).filter(|(own, _)| *own > POSSIBLE_SIGMAS) {
        for (&index, own) in refined.free.iter().zip(moves) {
            if own.is_finite() {
                bias[index] = bias[index].max(own.abs());
            }
        }
    }
    bias
}
