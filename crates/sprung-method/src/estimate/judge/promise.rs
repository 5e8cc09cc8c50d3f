//! The prediction error that a result promises for a new experiment of the same kind.

use crate::estimate::estimators::least_squares::HeldOut;
use crate::estimate::result::JointPrediction;
use crate::fit::{JointFit, joint_fits};
use crate::model::Model;
use crate::numbers::in_percent;
use crate::regression::System;

/// Fractions above which a factor is easier to read than a percentage, and above which its size is irrelevant.
const FACTOR: f64 = 10.0;
const LARGE_FACTOR: f64 = 1000.0;

/// Returns the errors of a joint in the form of the results.
fn prediction(joint: &str, fit: &JointFit) -> JointPrediction {
    JointPrediction {
        joint: joint.to_owned(),
        torque_nm: fit.torque,
        torque_error_nm: fit.torque_error,
        deflection_rad: fit.deflection.map(|(deflection, _)| deflection),
        deflection_error_rad: fit.deflection.map(|(_, error)| error),
    }
}

/// Returns a fraction in percent with two significant digits, but at most three decimals; as a factor from 10 on.
#[must_use]
pub fn percent(fraction: f64) -> String {
    if fraction.abs() >= LARGE_FACTOR {
        return format!("over {LARGE_FACTOR} times");
    }
    if fraction.abs() >= FACTOR {
        return format!("{fraction:.0} times");
    }
    let percent = in_percent(fraction);
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
pub fn predictions(model: &Model, system: &System, theta: &[f64]) -> Vec<JointPrediction> {
    let fits = joint_fits(model, system, theta).unwrap_or_default();
    (model.joints().iter().zip(&fits))
        .map(|(joint, fit)| prediction(joint, fit))
        .collect()
}

/// Returns the errors that parameters promise for a new experiment of the same kind: their errors on
/// the logs, times the ratio of held-out to fitted errors of least squares.
pub(in crate::estimate) fn promise(
    model: &Model,
    system: &System,
    theta: &[f64],
    held_out: &HeldOut,
) -> Vec<JointPrediction> {
    let mut predictions = predictions(model, system, theta);
    for (joint, prediction) in predictions.iter_mut().enumerate() {
        prediction.torque_error_nm *= held_out.ratio(model.torque_row(joint));
        if let Some(error) = &mut prediction.deflection_error_rad {
            *error *= held_out.ratio(joint);
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
