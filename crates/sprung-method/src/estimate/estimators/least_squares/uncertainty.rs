//! Errors of least squares beyond the disagreement of segments: changes between parts of the logs,
//! and the bias that all segments share.

use sprung_core::parameters::JointParameter;

use super::cross_checks::Route;
use super::parts::Parts;
use crate::estimate::statistics::between_parts;
use crate::fit::Fitted;
use crate::model::Theta;
use crate::prepare::{CUTOFF_STEP, Prepared, Sweep};

/// Power of the cut-off with which the variance of a velocity grows, and with it the bias by noise
/// of the regressor.
const NOISE_POWER: i32 = 3;

/// Power of the cut-off with which smearing by the position filter falls.
const SMEARING_POWER: i32 = 2;

/// Returns a fit whose standard errors contain the changes between parts and the bias.
///
/// The bias is the root of the sum of five squares: the change to the farthest cross-check, the change by estimated
/// nuisance parameters, what the errors of delays that were found add, the change to the next higher cut-off, and the
/// change to the next lower one. The last two are extrapolated to zero noise and zero smearing. So a parameter with one of
/// these errors is within two standard errors
/// of its true value, as long as the error obeys these powers of the cut-off. A stiffness has one more cross-check: its
/// value if all noise is that of the deflection.
pub(crate) fn widened(
    prepared: &Prepared,
    fitted: Fitted,
    (routes, nuisances): (&[(Route, Theta)], Option<&[f64]>),
    parts: &Parts,
) -> Fitted {
    let model = prepared.reading().model();
    let sweep = prepared.sweep();
    let of = |i: usize| -> (f64, f64) {
        if !fitted.identifiable[i] || model.parameters()[i].fixed.is_some() {
            return (0.0, 0.0);
        }
        let by_deflection = (fitted.motor_rows.iter())
            .filter(|row| model.index(JointParameter::Stiffness, row.joint) == Some(i))
            .filter_map(|row| row.stiffness_of_noisy_deflection(model));
        let farthest = (routes.iter().map(|(_, theta)| theta[i]))
            .chain(by_deflection)
            .map(|other| (other - fitted.theta[i]).abs())
            .fold(0.0, f64::max);
        let bias = farthest.hypot(sweep.map_or(0.0, |sweep| bias_by_filter(sweep, i)));
        let finite = |x: f64| if x.is_finite() { x } else { 0.0 };
        (finite(between(parts, i)), finite(bias))
    };
    let all = 0..model.parameters().len();
    let (mut between, mut bias): (Vec<f64>, Vec<f64>) = all.clone().map(of).unzip();
    for i in all.clone() {
        // Parts do not estimate changes with covariates. The error of such a change over that of its
        // friction parameter is the reciprocal of the covariate's spread.
        if let Some(friction) = model
            .friction_of_change(i)
            .filter(|_| parts.of(i).is_none())
        {
            let errors = &fitted.sampling_error;
            if errors[friction] > 0.0 {
                let ratio = errors[i] / errors[friction];
                between[i] = between[i].hypot(ratio * between[friction]);
                bias[i] = bias[i].hypot(ratio * bias[friction]);
            }
        }
    }
    // Nuisance parameters are the same for all values of a covariate, so changes with covariates do not inherit their bias.
    let doubt: Vec<f64> = prepared.doubt().iter().map(|doubt| doubt.by_all).collect();
    for changes in nuisances.into_iter().chain([doubt.as_slice()]) {
        for i in all.clone() {
            if fitted.identifiable[i] && changes[i].is_finite() {
                bias[i] = bias[i].hypot(changes[i]);
            }
        }
    }
    fitted.widen(between, bias)
}

/// Returns the bias of a parameter by noise and by smearing, from the neighbouring cut-offs.
fn bias_by_filter(sweep: &Sweep, index: usize) -> f64 {
    let chosen = sweep.points[sweep.chosen].theta[index];
    let change = |point: Option<usize>, power: i32| {
        let point = point.and_then(|point| sweep.points.get(point));
        // The bias at one cut-off is this fraction of its change by one step.
        let share = 1.0 / (CUTOFF_STEP.powi(power) - 1.0);
        point.map_or(0.0, |point| share * (point.theta[index] - chosen))
    };
    let noise = change(Some(sweep.chosen + 1), NOISE_POWER);
    let smearing = change(sweep.chosen.checked_sub(1), SMEARING_POWER);
    noise.hypot(smearing)
}

/// Returns the deviation of a parameter between parts beyond their sampling errors.
fn between(parts: &Parts, index: usize) -> f64 {
    (parts.cautious(index))
        .and_then(|values| between_parts(&values))
        .map_or(0.0, |found| found.standard_error())
}
