//! What there is to say of a parameter set beside a log.

use crate::check::{UNEXPLAINED, beyond_resolution};
use crate::finding::{Finding, Severity};
use crate::model::{Model, ModelError};
use crate::simulate::{Diverged, LoopError};

/// How the filtered motor torque of a joint is explained along the measured motion.
pub(super) struct TorqueFit {
    /// Name of the joint.
    pub(super) joint: String,
    /// What is left of the torque, root mean square, N·m (N).
    pub(super) residual: f64,
    /// The same over the torque.
    pub(super) relative: f64,
    /// Part of the torque that noise may turn over where friction changes its sign.
    pub(super) transition: f64,
}

impl TorqueFit {
    /// Returns whether more is left than the resolution of the positions explains.
    pub(super) fn is_unexplained(&self) -> bool {
        self.relative.is_finite() && beyond_resolution(self.relative, self.transition) > UNEXPLAINED
    }
}

pub(super) fn parameters_missing(label: &str, error: &ModelError) -> Finding {
    Finding::new(
        Severity::Serious,
        "parameters-missing",
        format!("{label}: {error}"),
        "identify from a log that excites these parameters",
    )
}

pub(super) fn not_simulable(label: &str, error: &LoopError) -> Finding {
    Finding::new(
        Severity::Serious,
        "not-simulable",
        format!("{label}: the loop cannot be simulated: {error}"),
        match error {
            LoopError::Model(ModelError::Missing { .. }) => {
                "give the nominal values that the feedforward needs"
            }
            _ => "look at the warnings of the identification",
        },
    )
}

/// - `theta`: parameters of the loop, \[p\]; `period`: of the log, s.
pub(super) fn runs_away(
    label: &str,
    model: &Model,
    theta: &[f64],
    period: f64,
    diverged: Diverged,
) -> Finding {
    let names: Vec<String> = (negative_friction(model, theta).into_iter())
        .map(|i| {
            let p = &model.parameters()[i];
            format!("{} = {:.4} {}", p.name, theta[i], p.unit)
        })
        .collect();
    let (reason, remedy) = if names.is_empty() {
        (
            format!(
                "the controller's gains do not stabilise this model at the log's period of {:.4} ms",
                1e3 * period
            ),
            "check the gains and the velocity window; the log must be recorded at the controller's \
             own period",
        )
    } else {
        (
            format!("friction below zero feeds energy in: {}", names.join(", ")),
            "compare the row with these set to zero; identify with an estimator that finds them \
             positive",
        )
    };
    Finding::new(
        Severity::Serious,
        "loop-runs-away",
        format!("{label}: {diverged}: {reason}"),
        remedy,
    )
}

/// Returns the indices of friction that feeds energy in.
pub(super) fn negative_friction(model: &Model, theta: &[f64]) -> Vec<usize> {
    (model.parameters().iter().zip(theta).enumerate())
        .filter(|(_, (parameter, value))| **value < 0.0 && parameter.is_friction())
        .map(|(i, _)| i)
        .collect()
}

/// Says which torques are not explained.
pub(super) fn poor_prediction<'a>(
    label: &'a str,
    torques: &'a [TorqueFit],
) -> impl Iterator<Item = Finding> + 'a {
    let unexplained = torques.iter().filter(|torque| torque.is_unexplained());
    unexplained.map(move |torque| {
        Finding::new(
            Severity::Warning,
            "poor-prediction",
            format!(
                "{label}: the model misses the filtered motor torque of {} by {:.0} % (root mean \
                 squares)",
                torque.joint,
                100.0 * torque.relative
            ),
            "look at the torque over time; identify from a log that moves like this one",
        )
    })
}

/// A model that fits along the measured motion, in a loop that moves otherwise: it is the loop
/// that is not the one of the log.
///
/// - `motion`: error of the simulated positions, as a part of their measured motion.
pub(super) fn moves_otherwise(label: &str, motion: f64) -> Finding {
    Finding::new(
        Severity::Warning,
        "loop-moves-otherwise",
        format!(
            "{label}: the simulated positions miss the measured ones by {:.0} % of their motion, \
             though the model explains the torque along them: the log does not start at rest, its \
             clock is not the reference's, or another controller ran",
            100.0 * motion
        ),
        "cut the log at its start, let its time begin where the reference does, and check gains, \
         reference and velocity window",
    )
}

pub(super) fn until_gap() -> Finding {
    Finding::new(
        Severity::Warning,
        "simulated-until-gap",
        "the log has gaps, over which a loop cannot be simulated; it is compared up to the first"
            .to_owned(),
        "cut the log at its gaps and validate on the longest part",
    )
}
