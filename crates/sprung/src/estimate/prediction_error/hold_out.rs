//! Whether a refinement predicts held-out samples as well as least squares does.

use super::refined::Refined;
use crate::fit::fits_of_growing;
use crate::model::Model;
use crate::regression::System;

/// Number of parts of the logs, of which the last one is held out, and number of growing parts for
/// which least squares is fitted.
const HOLD_OUT_PARTS: usize = 4;
const GROWING_PARTS: usize = 16;

/// Maximum ratio of the held-out residual of the refinement to that of least squares. A disturbance
/// of a few seconds makes the ratio 1.1 by chance on one good log in a hundred.
const MAX_ERROR_RATIO: f64 = 1.2;

/// Residuals of two estimates from the first three quarters of the logs, in the filtered torque of
/// the last quarter: root mean squares relative to the joints' torques.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HeldOut {
    pub(super) refined: f64,
    pub(super) linear: f64,
}

impl HeldOut {
    /// Returns whether the refinement predicts worse than least squares, from which it started.
    pub(super) fn is_worse(self) -> bool {
        self.refined > MAX_ERROR_RATIO * self.linear
    }
}

/// Compares both estimates; `None` if a part of the logs does not determine them.
pub(super) fn held_out(model: &Model, system: &System, refined: &Refined) -> Option<HeldOut> {
    let fits: Vec<_> = fits_of_growing(model, system, GROWING_PARTS).collect();
    // The refinement uses only the beginning of the logs. Both estimates here use the same samples.
    let used = (refined.samples as f64 / system.samples().max(1) as f64).min(1.0);
    let seen = used.min((HOLD_OUT_PARTS - 1) as f64 / HOLD_OUT_PARTS as f64);
    let count = (seen * fits.len() as f64).floor() as usize;
    let (_, linear) = fits.get(count.checked_sub(1)?)?;
    let end = count as f64 / fits.len() as f64 / used * refined.duration + 1e-9;
    let so_far = refined.trace.iter().take_while(|(time, _)| *time <= end);
    let own = &so_far.last()?.1;
    let last = system
        .groups(HOLD_OUT_PARTS)
        .into_iter()
        .nth(HOLD_OUT_PARTS - 1)?;
    let left = |theta: &[f64]| -> f64 {
        let squares = last.iter().enumerate().map(|(row, factor)| {
            let x: Vec<f64> = model.row_columns(row).iter().map(|&c| theta[c]).collect();
            let own: f64 = factor.residual(&x).iter().map(|r| r * r).sum();
            let torque = last[model.torque_row(model.joint_of(row))].rhs_norm();
            own / (torque * torque)
        });
        (squares.sum::<f64>() / last.len() as f64).sqrt()
    };
    let found = HeldOut {
        refined: left(own),
        linear: left(linear.as_ref()?),
    };
    (found.refined.is_finite() && found.linear.is_finite()).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refinement_stands_back_where_it_predicts_a_fifth_worse() {
        let held = |refined| HeldOut {
            refined,
            linear: 0.05,
        };
        assert!(!held(0.03).is_worse());
        // A disturbance of a few seconds causes this by chance.
        assert!(!held(0.057).is_worse());
        assert!(held(0.061).is_worse());
    }
}
