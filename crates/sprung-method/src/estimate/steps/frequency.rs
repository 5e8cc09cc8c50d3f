//! The frequency response of the log beside that of the first result.

use super::basis::Basis;
use crate::description::Estimator;
use crate::estimate::estimators::{Found, Numbers};
use crate::estimate::result::EstimateResult;
use crate::finding::Finding;
use crate::fit::Fitted;
use crate::frequency::{
    FrequencyResponse, Identified, SpringFromMotor, about_springs, frequency_response,
    resonances_disagree, springs_from_motor,
};

/// Returns the frequency responses of the log and of the first result, and adds the finding about
/// their disagreement to this result.
pub(super) fn in_frequency(
    basis: &Basis<'_>,
    estimates: &[(Estimator, Found)],
    results: &mut [EstimateResult],
) -> Option<FrequencyResponse> {
    let ((_, found), result) = estimates.first().zip(results.first_mut())?;
    let model = basis.ready.prepared.reading().model();
    let identified = Identified {
        model,
        theta: &found.numbers.theta,
        moves: &moves(&basis.linear.fitted, &found.numbers),
    };
    let response = frequency_response(&basis.read.record, &identified)?;
    result.warnings.extend(resonances_disagree(
        &response,
        &basis.ready.prepared.names().join(", "),
    ));
    (result.warnings).sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    Some(response)
}

/// Returns the springs from the motors, if the settings request them, and findings about them.
pub(super) fn springs_of_motors(basis: &Basis<'_>) -> (Vec<SpringFromMotor>, Vec<Finding>) {
    let reading = basis.ready.prepared.reading();
    if !reading.settings().springs_from_motor {
        return (Vec::new(), Vec::new());
    }
    let springs = springs_from_motor(&basis.read.record, reading.model());
    let names = basis.ready.prepared.names().join(", ");
    let findings = about_springs(&springs, reading.model(), &names);
    (springs, findings)
}

/// Returns the jackknife changes of least squares, scaled to the standard errors of the result: the
/// correlation of its parameters is that of least squares.
fn moves(fitted: &Fitted, numbers: &Numbers) -> Vec<Vec<f64>> {
    (fitted.moves.iter().enumerate())
        .map(|(i, movement)| {
            let scale = numbers.errors[i] / fitted.sampling_error[i];
            let scale = if scale.is_finite() { scale } else { 0.0 };
            movement.iter().map(|x| scale * x).collect()
        })
        .collect()
}
