//! Whether the common scale of links and springs can be trusted.

use sprung_core::parameters::JointParameter;

use crate::estimate::result::EstimateResult;
use crate::finding::{Finding, Severity};
use crate::model::Model;

/// Scale number ρ below which noise of the link rows may shrink links and springs together. Row
/// weights that follow the residuals shrink them to zero if ρ is below 8, and by a fraction 1/ρ if
/// it is above.
const SAFE_SCALE: f64 = 20.0;

/// Maximum difference of the stacked stiffness from that of the motor row, in standard errors.
const SIGNIFICANT_SIGMAS: f64 = 3.0;

/// A significant difference above this fraction of the stiffness, or above this number of standard
/// errors, is a warning. A smaller one is an information.
const STIFFNESS_SHARE_THAT_MATTERS: f64 = 0.05;
const CONTRADICTION_SIGMAS: f64 = 5.0;

/// Reports the joints whose torque contains too little of their spring's torque.
pub(super) fn scale_collapse(model: &Model, result: &EstimateResult, findings: &mut Vec<Finding>) {
    for row in &result.motor_rows {
        let Some(number) = row.scale_number.filter(|number| *number < SAFE_SCALE) else {
            continue;
        };
        findings.push(
            Finding::new(
                Severity::Warning,
                "scale-collapse",
                format!(
                    "{}: the spring torque that only the spring explains is {:.1} times the \
                     residual of the motor row (squares: {number:.1}, {SAFE_SCALE} is safe). Link \
                     rows have no right-hand side, so noise shrinks links and springs together \
                     without larger residuals",
                    row.joint,
                    number.sqrt()
                ),
                "compare with motor_rows and cross_checks; record finer positions, or a motion \
                 with larger spring deflections",
            )
            .about(stiffness(model, &row.joint)),
        );
    }
}

/// Reports joints whose stiffness differs significantly from the stiffness of the motor row alone.
/// The fit of the motor row alone is the first stage of the two-stage route.
pub(super) fn stiffness_disagrees(
    model: &Model,
    result: &EstimateResult,
    findings: &mut Vec<Finding>,
) {
    for row in &result.motor_rows {
        let Some(name) = stiffness(model, &row.joint) else {
            continue;
        };
        let below =
            |f: &Finding| f.code == "stacked-below-motor-rows" && f.parameters.contains(&name);
        if findings.iter().any(below) {
            continue;
        }
        let stacked = result.parameter(&name);
        let alone = row.parameters.iter().find(|p| p.name == name);
        let (Some(stacked), Some(alone)) = (stacked, alone) else {
            continue;
        };
        let (Some(x), Some(reference)) = (stacked.value, alone.value) else {
            continue;
        };
        // The error of the refinement is nearly independent of the error of least squares.
        let (whose, error) = match result.refined() {
            Some(_) => (
                "refined stiffness",
                (stacked.standard_error.zip(alone.standard_error)).map(|(a, b)| a.hypot(b)),
            ),
            None => (
                "stiffness of all rows together",
                row.stiffness_difference_standard_error,
            ),
        };
        let Some(error) = error else {
            continue;
        };
        let gap = x - reference;
        if gap.abs() <= SIGNIFICANT_SIGMAS * error || gap == 0.0 {
            continue;
        }
        let is_large = gap.abs() > STIFFNESS_SHARE_THAT_MATTERS * reference.abs();
        let severity = if is_large || gap.abs() > CONTRADICTION_SIGMAS * error {
            Severity::Warning
        } else {
            Severity::Info
        };
        findings.push(
            Finding::new(
                severity,
                "stiffness-disagrees",
                format!(
                    "{}: the {whose} is {x:.4} {}, that of the motor row alone by least squares \
                     {reference:.4}: they differ by {:.1} %, {:.1} standard errors of the \
                     difference. An error of the model or the noise of a position biases one of \
                     them",
                    row.joint,
                    stacked.unit,
                    100.0 * gap / reference,
                    gap.abs() / error
                ),
                "compare with cross_checks; a delay, a missing friction law or an encoder offset \
                 changes one value more than the other",
            )
            .about([name]),
        );
    }
}

/// Returns the name of a joint's stiffness.
fn stiffness(model: &Model, joint: &str) -> Option<String> {
    let at = model.joints().iter().position(|name| name == joint)?;
    let index = model.index(JointParameter::Stiffness, at)?;
    Some(model.parameters()[index].name.clone())
}
