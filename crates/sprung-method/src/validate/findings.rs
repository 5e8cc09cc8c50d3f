//! Findings about a parameter set on a log.

use crate::check::{UNEXPLAINED, beyond_resolution};
use crate::finding::{Finding, Severity};
use crate::model::{Model, ModelError};
use crate::simulate::{Diverged, LoopError};

/// Residual of a joint's filtered motor torque along the measured motion.
#[derive(Clone, Debug)]
pub(super) struct TorqueFit {
    /// Name of the joint.
    pub(super) joint: String,
    /// Residual of the torque, root mean square, N·m (N).
    pub(super) residual: f64,
    /// Residual over torque, root mean squares.
    pub(super) relative: f64,
    /// Fraction of the torque that velocity noise may cause in the Coulomb transition.
    pub(super) transition: f64,
}

impl TorqueFit {
    /// Returns whether the residual exceeds the limit after the share of velocity noise is
    /// subtracted.
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

#[expect(
    clippy::wildcard_enum_match_arm,
    reason = "all other errors have one remedy"
)]
pub(super) fn not_simulable(label: &str, error: &LoopError) -> Finding {
    Finding::new(
        Severity::Serious,
        "not-simulable",
        format!("{label}: the loop cannot be simulated: {error}"),
        match error {
            LoopError::Model(ModelError::Missing { .. }) => {
                "give the nominal values that the feedforward needs"
            }
            _ => "read the warnings of the identification",
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
            format!(
                "negative friction feeds energy into the loop: {}",
                names.join(", ")
            ),
            "compare with the row in which these parameters are zero; identify with an estimator that \
             finds positive values",
        )
    };
    Finding::new(
        Severity::Serious,
        "loop-runs-away",
        format!("{label}: {diverged}: {reason}"),
        remedy,
    )
}

/// Returns the indices of negative friction parameters, which feed energy into the robot.
pub(super) fn negative_friction(model: &Model, theta: &[f64]) -> Vec<usize> {
    (model.parameters().iter().zip(theta).enumerate())
        .filter(|(_, (parameter, value))| **value < 0.0 && parameter.is_friction())
        .map(|(i, _)| i)
        .collect()
}

/// Returns findings about torques that the model does not explain.
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
                "{label}: the model's filtered motor torque of {} differs from the measured one by \
                 {:.0} % (root mean squares)",
                torque.joint,
                100.0 * torque.relative
            ),
            "look at the torque over time; identify from a log that moves like this one",
        )
    })
}

/// Finding that the simulated loop differs from that of the log, although the model explains the
/// torque along the measured motion.
///
/// - `motion`: error of the simulated positions over their measured motion.
pub(super) fn moves_otherwise(label: &str, motion: f64) -> Finding {
    Finding::new(
        Severity::Warning,
        "loop-moves-otherwise",
        format!(
            "{label}: the simulated positions differ from the measured ones by {:.0} % of their motion, \
             although the model explains the torque along the measured motion: the log does not start \
             at rest, its clock differs from the reference's, or another controller ran",
            100.0 * motion
        ),
        "let the log start at rest and its time begin with the reference, and check gains, reference \
         and velocity window",
    )
}

pub(super) fn until_gap() -> Finding {
    Finding::new(
        Severity::Warning,
        "simulated-until-gap",
        "the log has gaps, and a loop cannot be simulated across a gap; it is compared up to the first \
         gap"
        .to_owned(),
        "cut the log at its gaps and validate on the longest part",
    )
}
