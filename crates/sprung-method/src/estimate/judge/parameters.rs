//! Findings about single parameters: weakly excited, collinear, impossible friction.

use crate::estimate::result::{EstimateResult, ParameterEstimate};
use crate::estimate::statistics::UNKNOWN_RELATIVE_ERROR;
use crate::finding::{Finding, Severity};
use crate::model::{Model, Parameter, short};
use crate::numbers::in_percent;

/// A parameter with a larger relative standard error is reported as weakly excited.
const WEAK_RELATIVE_ERROR: f64 = 0.15;

/// Ratio of a parameter's torque to the residual of its row. Below this ratio a bias may be as
/// large as the value, and the standard errors do not contain this bias.
const LITTLE_TORQUE_OVER_RESIDUAL: f64 = 3.0;

/// Condition number with scaled columns above which the collinear parameters are named.
const COLLINEAR_CONDITION: f64 = 100.0;

/// Relative error above which a message gives no number.
const LARGEST_LISTED: f64 = 10.0;

/// Maximum number of parameters that a message lists.
const MAX_LISTED_PARAMETERS: usize = 8;

/// Reports parameters with large relative errors. Their intervals are valid, and the promise contains
/// their effect on the prediction, so this is a warning only for a stiffness or a rotor inertia that
/// is hardly known at all.
pub(super) fn weak(model: &Model, result: &EstimateResult, findings: &mut Vec<Finding>) {
    let share = |p: &ParameterEstimate| Some(p.standard_error? / p.value?.abs());
    let is_vital = |known: &Parameter| known.joint.is_some_and(|(kind, _)| kind.is_vital());
    let weak: Vec<(&ParameterEstimate, &Parameter)> = (result.parameters.iter())
        .zip(model.parameters())
        // An interval that ends at zero already shows the uncertainty. Offsets and preloads may be zero, so their
        // relative error has no meaning.
        .filter(|(p, known)| match known.joint {
            Some((kind, _)) if kind.is_of_curve() => false,
            Some((kind, joint)) if p.one_sided => kind.is_vital() && model.is_flexible(joint),
            Some((kind, _)) if kind.is_friction() => p.value.is_none_or(|value| value >= 0.0),
            Some(_) => is_vital(known),
            None => true,
        })
        .filter(|(p, _)| share(p).is_some_and(|share| share > WEAK_RELATIVE_ERROR))
        .collect();
    let (unknown, uncertain): (Vec<_>, Vec<_>) = (weak.into_iter()).partition(|(p, known)| {
        is_vital(known) && share(p).is_some_and(|share| share > UNKNOWN_RELATIVE_ERROR)
    });
    for (severity, group) in [(Severity::Warning, unknown), (Severity::Info, uncertain)] {
        let group: Vec<&ParameterEstimate> = group.into_iter().map(|(p, _)| p).collect();
        if group.is_empty() {
            continue;
        }
        let list = list(&group, |p| relative(share(p).unwrap_or(0.0)));
        findings.push(
            Finding::new(
                severity,
                "weakly-excited",
                format!("the log excites some parameters weakly; relative standard errors: {list}"),
                "record larger amplitudes or a longer log, with motion that excites these \
                 parameters",
            )
            .about(group.iter().map(|p| p.name.clone())),
        );
    }
}

/// Returns a relative error in percent; the error of a value that is nearly zero has no number.
fn relative(error: f64) -> String {
    if error > LARGEST_LISTED {
        format!("more than {:.0} %", in_percent(LARGEST_LISTED))
    } else {
        format!("{:.0} %", in_percent(error))
    }
}

/// Reports parameters whose torque is small compared with the residual of their row.
pub(super) fn little_torque(model: &Model, result: &EstimateResult, findings: &mut Vec<Finding>) {
    let little: Vec<&ParameterEstimate> = (result.parameters.iter())
        .zip(model.parameters())
        .filter(|(p, known)| {
            // Offsets and preloads may be zero.
            let counts = known.joint.is_none_or(|(kind, _)| {
                (kind.is_vital() || kind.is_friction()) && !kind.is_of_curve()
            });
            counts
                && p.torque_over_residual
                    .is_some_and(|ratio| ratio < LITTLE_TORQUE_OVER_RESIDUAL)
        })
        .map(|(p, _)| p)
        .collect();
    if little.is_empty() || result.motor_rows.is_empty() && model.tree().is_none() {
        return;
    }
    let list = list(&little, |p| {
        format!("{:.1} times", p.torque_over_residual.unwrap_or(0.0))
    });
    findings.push(
        Finding::new(
            Severity::Info,
            "little-torque",
            format!(
                "the torque of some parameters is hardly larger than the residual of their rows \
                 ({list}): their bias may be as large as the value, and the standard errors do not \
                 show it"
            ),
            "use higher accelerations or velocities of these joints, or finer encoders",
        )
        .about(little.iter().map(|p| p.name.clone())),
    );
}

/// Returns `name value, name value, …`.
pub(super) fn list(
    parameters: &[&ParameterEstimate],
    value: impl Fn(&ParameterEstimate) -> String,
) -> String {
    listed((parameters.iter()).map(|p| format!("{} {}", short(&p.name), value(p))))
}

/// Joins the first words of a list and adds the number of words left out.
pub(super) fn listed(words: impl ExactSizeIterator<Item = String>) -> String {
    let more = words.len().saturating_sub(MAX_LISTED_PARAMETERS);
    let mut shown = words
        .take(MAX_LISTED_PARAMETERS)
        .collect::<Vec<String>>()
        .join(", ");
    if more > 0 {
        shown = format!("{shown} and {more} more");
    }
    shown
}

pub(super) fn collinear(
    model: &Model,
    result: &EstimateResult,
    weakest: &[f64],
    findings: &mut Vec<Finding>,
) {
    let Some(condition) = result
        .condition_number_scaled
        .filter(|c| *c > COLLINEAR_CONDITION)
    else {
        return;
    };
    if result.rank < result.unknowns {
        return;
    }
    let names: Vec<String> = (model.parameters().iter().zip(weakest))
        .filter(|(_, part)| **part > 0.2)
        .map(|(parameter, _)| parameter.name.clone())
        .collect();
    findings.push(
        Finding::new(
            // The intervals contain the uncertainty.
            Severity::Info,
            "collinear",
            format!(
                "the columns of {} are nearly collinear in this log (condition number \
                 {condition:.0} after scaling): their separate values are far less certain than a \
                 combination of them",
                listed(names.iter().map(|name| short(name).into_owned()))
            ),
            "use a trajectory with more frequencies, with the joints moving independently",
        )
        .about(names),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_relative_error_of_nearly_zero_has_no_number() {
        assert_eq!(relative(0.354), "35 %");
        assert_eq!(relative(1.0e10), "more than 1000 %");
    }
}
