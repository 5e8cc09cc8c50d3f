//! What the resolution of the positions alone leaves of a torque unexplained.

use crate::prepare::{Excerpt, RowFit, velocity_noise};
use crate::regression::{Reading, System, TransitionWeights};

/// Part of the motor torque that may stay unexplained, root mean squares, beyond what
/// the resolution of the positions leaves of it.
pub(crate) const UNEXPLAINED: f64 = 0.2;

/// Returns the part of a torque that a model leaves unexplained where the positions
/// are exact.
///
/// - `relative`: residual over torque, root mean squares.
/// - `share`: what noise leaves through Coulomb transitions, likewise.
#[must_use]
pub(crate) fn beyond_resolution(relative: f64, share: f64) -> f64 {
    (relative.powi(2) - share.powi(2)).max(0.0).sqrt()
}

/// Returns what the noise of the velocities leaves of each joint's torque through
/// Coulomb transitions, root mean squares over the torque, \[n\]; zero where that
/// cannot be said.
///
/// - `fits`: of the torque's row of each joint.
pub(super) fn transition_shares(reading: &Reading, excerpt: &Excerpt, fits: &[RowFit]) -> Vec<f64> {
    let model = reading.model();
    let mut theta = vec![0.0; model.parameters().len()];
    for fit in fits {
        for (column, value) in fit.values() {
            theta[column] = value;
        }
    }
    let noise = velocity_noise(
        model,
        reading.channels(),
        excerpt,
        reading.position_cutoff_hz(),
    );
    let weights = TransitionWeights::unweighted(model, &noise, &theta);
    let reading = reading.with_weights(weights);
    let rows: Vec<usize> = (0..fits.len()).map(|j| model.torque_row(j)).collect();
    let system = excerpt.reduce_rows(&reading, &rows);
    (0..rows.len())
        .map(|i| {
            let kept = system.as_ref().map(System::kept);
            kept.and_then(|kept| kept.transition_share(i))
                .unwrap_or(0.0)
        })
        .collect()
}
