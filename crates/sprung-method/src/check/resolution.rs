//! Computes the part of a torque's residual by the resolution of the positions.

use crate::prepare::{Excerpt, RowFit, velocity_noise};
use crate::regression::{Reading, System, TransitionWeights};

/// Limit of the unexplained fraction of a motor torque, root mean squares, after the part by the
/// resolution of the positions is subtracted.
pub(crate) const UNEXPLAINED: f64 = 0.2;

/// Returns the unexplained fraction of a torque with exact positions.
///
/// - `relative`: residual over torque, root mean squares.
/// - `share`: velocity noise that passes through Coulomb transitions over torque, root mean
///   squares.
#[must_use]
pub(crate) fn beyond_resolution(relative: f64, share: f64) -> f64 {
    (relative.powi(2) - share.powi(2)).max(0.0).sqrt()
}

/// Returns the velocity noise that passes through Coulomb transitions into each joint's torque,
/// root mean squares over the torque, \[n\]; zero if it cannot be computed.
///
/// - `fits`: fits of each joint's torque row.
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
