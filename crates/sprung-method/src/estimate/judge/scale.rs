//! Whether the common scale of links and springs can be trusted.

use crate::estimate::statistics::{CERTAIN_SIGMAS, SIGNIFICANT_SIGMAS, SMALL_SHARE};
use crate::numbers::in_percent;
use sprung_core::parameters::JointParameter;

use crate::estimate::result::{EstimateResult, MotorRowResult};
use crate::finding::{Finding, Severity};
use crate::fit::{Fitted, SAFE_SCALE};
use crate::model::Model;

/// Scale number ρ below which row weights that follow the residuals shrink links and springs to zero. Above it they shrink
/// them by a fraction 1/ρ.
const COLLAPSED_SCALE: f64 = 8.0;

/// Reports the joints whose torque contains too little of their spring's torque. It is a warning if
/// the motor row alone does not confirm the stiffness.
pub(super) fn scale_collapse(model: &Model, result: &EstimateResult, findings: &mut Vec<Finding>) {
    for row in &result.motor_rows {
        let Some(number) = row.scale_number.filter(|number| *number < SAFE_SCALE) else {
            continue;
        };
        let is_confirmed = difference(model, result, row).is_some_and(|found| {
            let limit = SMALL_SHARE * found.alone.abs();
            SIGNIFICANT_SIGMAS * found.error <= limit && found.gap().abs() <= limit
        });
        let shrinks = match number {
            number if number < COLLAPSED_SCALE => 1.0,
            number => 1.0 / number,
        };
        let name = stiffness(model, &row.joint);
        let parameter = name.as_ref().and_then(|name| result.parameter(name));
        let matters = parameter
            .and_then(|parameter| Some(parameter.standard_error? / parameter.value?.abs()));
        let matters = matters.is_none_or(|relative| shrinks > SIGNIFICANT_SIGMAS * relative);
        findings.push(
            Finding::new(
                if is_confirmed || !matters {
                    Severity::Info
                } else {
                    Severity::Warning
                },
                "scale-collapse",
                format!(
                    "{}: the spring torque that only the spring explains is {:.1} times the \
                     residual of the motor row (squares: {number:.1}, {SAFE_SCALE} is safe). Link \
                     rows have no right-hand side, so noise shrinks links and springs together \
                     without larger residuals{}",
                    row.joint,
                    number.sqrt(),
                    if is_confirmed {
                        ". The motor row alone confirms the stiffness"
                    } else {
                        ""
                    }
                ),
                "compare with motor_rows and cross_checks; record finer positions, or a motion \
                 with larger spring deflections",
            )
            .about(name),
        );
    }
}

/// The stiffness of a joint by all rows and by its motor row alone.
struct Difference {
    name: String,
    unit: String,
    all: f64,
    alone: f64,
    /// Standard error of the difference.
    error: f64,
}

impl Difference {
    fn gap(&self) -> f64 {
        self.all - self.alone
    }
}

/// Returns the stiffness of a joint by all rows and by its motor row alone; `None` if one of them or
/// the standard error is unknown.
fn difference(model: &Model, result: &EstimateResult, row: &MotorRowResult) -> Option<Difference> {
    let name = stiffness(model, &row.joint)?;
    let all = result.parameter(&name)?;
    let alone = row.parameters.iter().find(|p| p.name == name)?;
    // The error of the refinement is nearly independent of the error of least squares.
    let error = match result.refined() {
        Some(_) => (all.standard_error?).hypot(alone.standard_error?),
        None => row.stiffness_difference_standard_error?,
    };
    Some(Difference {
        unit: all.unit.clone(),
        all: all.value?,
        alone: alone.value?,
        error,
        name,
    })
}

/// Reports joints whose stiffness differs significantly from the stiffness of the motor row alone.
/// The fit of the motor row alone is the first stage of the two-stage route.
///
/// - `linear`: result of least squares, whose bias is in the motor row too.
pub(super) fn stiffness_disagrees(
    model: &Model,
    result: &EstimateResult,
    linear: &Fitted,
    findings: &mut Vec<Finding>,
) {
    for row in &result.motor_rows {
        let Some(mut found) = difference(model, result, row) else {
            continue;
        };
        let below = |f: &Finding| {
            f.code == "stacked-below-motor-rows" && f.parameters.contains(&found.name)
        };
        if findings.iter().any(below) {
            continue;
        }
        let whose = match result.refined() {
            Some(_) => {
                let index = model.index_of(&found.name);
                found.error = found.error.hypot(index.map_or(0.0, |i| linear.bias[i]));
                "refined stiffness"
            }
            None => "stiffness of all rows together",
        };
        let (gap, error) = (found.gap(), found.error);
        if gap.abs() <= SIGNIFICANT_SIGMAS * error || gap == 0.0 {
            continue;
        }
        let is_large = gap.abs() > SMALL_SHARE * found.alone.abs();
        let severity = if is_large || gap.abs() > CERTAIN_SIGMAS * error {
            Severity::Warning
        } else {
            Severity::Info
        };
        findings.push(
            Finding::new(
                severity,
                "stiffness-disagrees",
                format!(
                    "{}: the {whose} is {:.4} {}, that of the motor row alone by least squares \
                     {:.4}: they differ by {:.1} %, {:.1} standard errors of the difference. An \
                     error of the model or the noise of a position biases one of them",
                    row.joint,
                    found.all,
                    found.unit,
                    found.alone,
                    in_percent(gap / found.alone),
                    gap.abs() / error
                ),
                "compare with cross_checks; a delay, a missing friction law or an encoder offset \
                 changes one value more than the other",
            )
            .about([found.name]),
        );
    }
}

/// Returns the name of a joint's stiffness.
fn stiffness(model: &Model, joint: &str) -> Option<String> {
    let at = model.joints().iter().position(|name| name == joint)?;
    let index = model.index(JointParameter::Stiffness, at)?;
    Some(model.parameters()[index].name.clone())
}
