//! Estimates with cut-offs of the position filter around the chosen cut-off.

use crate::estimate::result::{CutoffChoice, CutoffPoint};
use crate::fit::{HoldOut, fit_quickly};
use crate::prepare::Excerpt;
use crate::regression::Reading;

/// Tried cut-offs relative to the chosen one.
const CUTOFF_FACTORS: [f64; 5] = [0.5, 0.7, 1.0, 1.4, 2.0];

/// Number of parts of the beginning of a log, each of which is held out once.
const HOLD_OUT_PARTS: usize = 8;

/// Estimates the parameters with cut-offs around the chosen one, from the beginning of a log.
#[must_use]
pub(crate) fn sweep(reading: &Reading, excerpt: &Excerpt, reason: String) -> CutoffChoice {
    let chosen = reading.position_cutoff_hz();
    let points = CUTOFF_FACTORS.iter().filter_map(|part| {
        // The noise of a velocity grows with the power 1.5 of the cut-off.
        let weights = (reading.weights()).map(|w| w.clone().with_noise(part.powf(1.5)));
        let mut reading = reading.with_position_cutoff(part * chosen);
        if let Some(weights) = weights {
            reading = reading.with_weights(weights);
        }
        let system = excerpt.reduce(&reading)?;
        Some(CutoffPoint {
            cutoff_hz: part * chosen,
            values: fit_quickly(reading.model(), &system)?,
            held_out_residual: HoldOut::new(reading.model(), &system, HOLD_OUT_PARTS)
                .missed_by_fits()
                .and_then(|missed| missed.of_torque_rows()),
        })
    });
    CutoffChoice {
        reason,
        sweep: points.collect(),
    }
}
