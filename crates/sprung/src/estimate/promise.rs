//! The prediction error that a result promises for a new experiment of the same kind.

use serde::{Deserialize, Serialize};

use crate::fit::{HoldOut, JointFit, Missed, joint_fits};
use crate::model::Model;
use crate::regression::System;

/// Number of consecutive parts of the logs that are left out in turn.
const PARTS: usize = 8;

/// Prediction errors of a joint along a measured motion, filtered by the filter pair, root mean
/// squares.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointPrediction {
    /// Name of the joint.
    pub joint: String,
    /// Motor torque, N·m (N).
    pub torque_nm: f64,
    /// Error of the motor torque, N·m (N).
    pub torque_error_nm: f64,
    /// Deflection of the spring, rad (m); absent without a spring of positive stiffness.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deflection_rad: Option<f64>,
    /// Error of the deflection that moves the link, rad (m): residual of the link's equation over
    /// the stiffness.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deflection_error_rad: Option<f64>,
}

impl JointPrediction {
    fn new(joint: &str, fit: &JointFit) -> Self {
        Self {
            joint: joint.to_owned(),
            torque_nm: fit.torque,
            torque_error_nm: fit.torque_error,
            deflection_rad: fit.deflection.map(|(deflection, _)| deflection),
            deflection_error_rad: fit.deflection.map(|(_, error)| error),
        }
    }
}

/// Returns a fraction in percent with two significant digits, but at most three decimals.
#[must_use]
pub(crate) fn percent(fraction: f64) -> String {
    let percent = 100.0 * fraction;
    let decimals = match percent.abs() {
        size if size >= 9.95 => 0,
        size if size >= 0.995 => 1,
        size if size >= 0.0995 => 2,
        _ => 3,
    };
    format!("{percent:.decimals$} %")
}

/// Returns the prediction errors of each joint on the samples of a system; empty if it has no
/// samples.
///
/// - `theta`: parameters, \[p\].
#[must_use]
pub(crate) fn predictions(model: &Model, system: &System, theta: &[f64]) -> Vec<JointPrediction> {
    let fits = joint_fits(model, system, theta).unwrap_or_default();
    (model.joints().iter().zip(&fits))
        .map(|(joint, fit)| JointPrediction::new(joint, fit))
        .collect()
}

/// Ratio of the error on parts that a fit has not seen to the error on all parts with the fit of all
/// parts, row by row: at least 1; infinite if the other parts do not determine the parameters.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct HeldOutRatio(Vec<f64>);

impl HeldOutRatio {
    /// Fits all parts but one by least squares, and predicts the part that is left out.
    ///
    /// - `linear`: least squares of all parts, \[p\].
    pub(super) fn new(model: &Model, system: &System, linear: &[f64]) -> Self {
        let hold_out = HoldOut::new(model, system, PARTS);
        let seen = (0..hold_out.len()).fold(Missed::default(), |sum, part| {
            sum.with(&hold_out.missed(part, linear))
        });
        let unseen = hold_out.missed_by_fits();
        let ratio = |row: usize| {
            let unseen = unseen.as_ref()?.residual.get(row)?;
            let seen = seen.residual.get(row).filter(|seen| **seen > 0.0)?;
            Some((unseen / seen).sqrt().max(1.0)).filter(|ratio| ratio.is_finite())
        };
        Self(
            (0..model.rows())
                .map(|row| ratio(row).unwrap_or(f64::INFINITY))
                .collect(),
        )
    }
}

/// Returns the errors that parameters promise for a new experiment of the same kind: their errors on
/// the logs, times the ratio of held-out to fitted errors of least squares.
pub(super) fn promise(
    model: &Model,
    system: &System,
    theta: &[f64],
    ratio: &HeldOutRatio,
) -> Vec<JointPrediction> {
    let mut predictions = predictions(model, system, theta);
    for (joint, prediction) in predictions.iter_mut().enumerate() {
        prediction.torque_error_nm *= ratio.0[model.torque_row(joint)];
        if let Some(error) = &mut prediction.deflection_error_rad {
            *error *= ratio.0[joint];
        }
    }
    predictions.retain(|prediction| {
        let errors = [
            Some(prediction.torque_error_nm),
            prediction.deflection_error_rad,
        ];
        errors.into_iter().flatten().all(f64::is_finite)
    });
    predictions
}
