//! Whether a refinement predicts what it has not seen as well as least squares does.

use super::refine::Refined;
use crate::estimate::least_squares::fits_of_growing;
use crate::model::Model;
use crate::regression::System;

/// The last of so many parts of the logs is held out; and the parts of which as many
/// are seen as come before.
const HELD_OUT: usize = 4;
const PARTS: usize = 16;

/// How much worse than least squares a refinement may predict what neither has seen:
/// by chance, a few seconds of a disturbance make it a tenth on one good log in a hundred.
const WORSE: f64 = 1.2;

/// What two estimates from the first three quarters of the logs leave of the last
/// one's filtered torque: root mean squares over that of the joints' torques.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HeldOut {
    pub(super) refined: f64,
    pub(super) linear: f64,
}

impl HeldOut {
    /// Says that a refinement predicts worse than what it began with.
    pub(super) fn unpredictive(self) -> Option<String> {
        (self.refined > WORSE * self.linear).then(|| {
            format!(
                "estimated from the first three quarters of the logs it misses {:.1} % of the filtered \
                 torque of the last, least squares {:.1} %: what it takes for disturbances repeats with \
                 the motion",
                100.0 * self.refined,
                100.0 * self.linear
            )
        })
    }
}

/// Compares both estimates; nothing if a part of the logs does not determine them.
pub(super) fn held_out(model: &Model, system: &System, refined: &Refined) -> Option<HeldOut> {
    let fits: Vec<_> = fits_of_growing(model, system, PARTS).collect();
    // Both shall have seen as much; all that a refinement uses comes first.
    let used = (refined.samples as f64 / system.samples().max(1) as f64).min(1.0);
    let seen = used.min((HELD_OUT - 1) as f64 / HELD_OUT as f64);
    let count = (seen * fits.len() as f64).floor() as usize;
    let (_, linear) = fits.get(count.checked_sub(1)?)?;
    let end = count as f64 / fits.len() as f64 / used * refined.duration + 1e-9;
    let so_far = refined.trace.iter().take_while(|(time, _)| *time <= end);
    let own = &so_far.last()?.1;
    let last = system.groups(HELD_OUT).into_iter().nth(HELD_OUT - 1)?;
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
        assert_eq!(held(0.03).unpredictive(), None);
        // Disturbances of a few seconds do that by chance.
        assert_eq!(held(0.057).unpredictive(), None);
        let text = held(0.061).unpredictive().unwrap();
        assert!(
            text.contains("6.1 % of the filtered torque of the last, least squares 5.0 %"),
            "{text}"
        );
    }
}
