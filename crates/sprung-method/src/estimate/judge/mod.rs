//! Judgement of a result: findings about its parameters.

mod applied;
mod at_rest;
mod decide;
mod delay_hold_out;
mod existence;
mod gravity;
mod measured_effects;
mod of_joint;
mod parameters;
mod promise;
mod reasons;
mod routes;
mod scale;
mod stability;
mod unpredicted;

use crate::estimate::statistics::{LARGE_SHARE, SMALL_SHARE};
use crate::numbers::in_percent;
use sprung_core::parameters::JointParameter;

use self::existence::impossible_robot;
pub(super) use applied::applied;
pub(super) use at_rest::at_rest;
pub(super) use decide::decide;
pub(super) use delay_hold_out::with_held_out_delay;
pub(crate) use gravity::{tilt_is_possible, tilted};
pub(super) use measured_effects::after_estimation;
pub(super) use promise::promise;
pub use promise::{percent, predictions};
pub(super) use unpredicted::unpredicted;

use self::of_joint::{motor_row, of};
use self::parameters::{collinear, listed, little_torque, weak};
use self::routes::routes_disagree;
use self::scale::{scale_collapse, stiffness_disagrees};
use self::stability::{cutoff_drift, parts_disagree, shared_bias};
use crate::check::{UNEXPLAINED, beyond_resolution};
use crate::estimate::estimators::least_squares::Linear;
use crate::estimate::result::{EstimateResult, ParameterEstimate};
use crate::finding::{Finding, Severity};
use crate::log::Channels;
use crate::model::{Model, short};
use crate::prepare::Sweep;

/// A model that leaves more than this fraction of a joint's torque unexplained does not predict it.
const NOT_PREDICTED: f64 = 0.5;

/// Returns the findings about a result.
///
/// - `linear`: result of least squares; `sweep`: its estimates with other cut-offs.
/// - `channels`: the columns, for their names.
#[must_use]
pub(crate) fn judge(
    model: &Model,
    result: &EstimateResult,
    linear: &Linear<'_>,
    sweep: Option<&Sweep>,
    channels: &Channels,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    unidentifiable(model, result, &mut findings);
    for (joint, name) in model.joints().iter().enumerate() {
        scale(model, result, joint, name, &mut findings);
        unexplained(model, result, joint, name, &mut findings);
    }
    if result.refined().is_none() {
        // Noise does not shrink an estimate by likelihood.
        scale_collapse(model, result, &mut findings);
    }
    stiffness_disagrees(model, result, &linear.fitted, &mut findings);
    findings.extend(routes_disagree(model, result, &linear.fitted));
    findings.extend(no_promise(model, result));
    findings.extend(impossible_robot(model, result, linear, channels));
    weak(model, result, &mut findings);
    if result.refined().is_none() {
        // The standard errors of the likelihood already contain this uncertainty.
        little_torque(model, result, &mut findings);
    }
    collinear(
        model,
        result,
        &linear.fitted.excitation.weakest_direction,
        &mut findings,
    );
    if result.has_linear_values() {
        findings.extend(sweep.and_then(|sweep| cutoff_drift(model, result, sweep)));
        findings.extend(shared_bias(result));
    }
    // A refinement compares several logs itself.
    let is_refined = result.refined().is_some();
    if result.has_linear_values() || is_refined && !linear.parts.are_logs {
        findings.extend(parts_disagree(model, linear));
    }
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    findings
}

fn unidentifiable(model: &Model, result: &EstimateResult, findings: &mut Vec<Finding>) {
    let unidentifiable: Vec<(usize, &ParameterEstimate)> = (result.parameters.iter().enumerate())
        .filter(|(_, p)| !p.identifiable)
        .collect();
    if unidentifiable.is_empty() {
        return;
    }
    let names: Vec<String> = unidentifiable.iter().map(|(_, p)| p.name.clone()).collect();
    let vital = (unidentifiable.iter()).any(|&(i, _)| {
        let kind = model.parameters()[i].joint.map(|(kind, _)| kind);
        kind.map_or(model.tree().is_none(), JointParameter::is_vital)
    });
    findings.push(
        Finding::new(
            if vital {
                Severity::Serious
            } else {
                Severity::Warning
            },
            "not-identifiable",
            format!(
                "the log does not determine {} (rank {} of {}): the motion does not excite them, \
                 or excites only a combination of them",
                listed(names.iter().map(|name| short(name).into_owned())),
                result.rank,
                result.unknowns
            ),
            "record a log in which these joints move on their own, with accelerations and with \
             reversals of direction",
        )
        .about(names),
    );
}

/// Compares the stacked stiffness with that of the motor row alone.
fn scale(
    model: &Model,
    result: &EstimateResult,
    joint: usize,
    name: &str,
    findings: &mut Vec<Finding>,
) {
    let Some(stacked) = of(model, result, JointParameter::Stiffness, joint) else {
        return;
    };
    let alone = motor_row(model, result, joint)
        .and_then(|row| row.parameters.iter().find(|p| p.name == stacked.name));
    let (Some(value), Some(alone)) = (stacked.value, alone) else {
        return;
    };
    let (Some(reference), Some(error)) = (alone.value, alone.standard_error) else {
        return;
    };
    let error = error.hypot(stacked.standard_error.unwrap_or(0.0));
    if result.refined().is_some() {
        // Noise does not shrink an estimate by likelihood. `stiffness_disagrees` compares it.
        return;
    }
    let gap = reference - value;
    let sure = gap > LARGE_SHARE * reference || gap > 2.0 * error;
    if value > 0.0 && gap > SMALL_SHARE * reference && sure {
        findings.push(
            Finding::new(
                Severity::Warning,
                "stacked-below-motor-rows",
                format!(
                    "{name}: the stacked estimate of the stiffness, {value:.4} {}, lies {:.0} % \
                     below that of the motor row alone, {reference:.4}. The link rows have no \
                     right-hand side, so their noise reduces the common scale of links and springs",
                    stacked.unit,
                    in_percent(gap / reference)
                ),
                "prefer the stiffness of estimator = \"prediction-error\", which noise does not shrink, or \
                 that of the motor row; look for delays and for noise of the link positions",
            )
            .about([stacked.name.clone()]),
        );
    }
}

/// Reports joints without a promise: parts of the log do not determine the parameters that the other
/// parts need.
fn no_promise(model: &Model, result: &EstimateResult) -> Option<Finding> {
    let promised = |joint: &String| result.promise.iter().any(|promise| promise.joint == *joint);
    let without: Vec<&str> = (model.joints().iter())
        .filter(|joint| !promised(joint))
        .map(String::as_str)
        .collect();
    (!without.is_empty()).then(|| {
        Finding::new(
            Severity::Warning,
            "no-promise",
            format!(
                "the log does not show how well the model predicts {} in a new experiment: without \
                 one eighth of the log, the rest does not determine the parameters",
                without.join(", ")
            ),
            "record a longer log in which all joints move all the time",
        )
    })
}

fn unexplained(
    model: &Model,
    result: &EstimateResult,
    joint: usize,
    name: &str,
    findings: &mut Vec<Finding>,
) {
    let row = model.row_name(model.torque_row(joint));
    let Some(relative) = result.relative_residual.get(&row) else {
        return;
    };
    let share = result.resolution_share.get(&row).unwrap_or(0.0);
    let missed = beyond_resolution(relative, share);
    if missed > UNEXPLAINED {
        findings.push(Finding::new(
            if missed > NOT_PREDICTED {
                Severity::Serious
            } else {
                Severity::Warning
            },
            "poor-fit",
            format!(
                "{name}: the residual of the motor row is {:.0} % of its torque (root mean \
                 squares): the model does not explain this log",
                in_percent(relative)
            ),
            "look at the fit over time: it shows a delay, a missing friction law or an offset of \
             the torque",
        ));
    }
}
