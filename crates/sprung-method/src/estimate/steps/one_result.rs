//! The result of one estimator in the form of the files.

use sprung_core::friction::Scale;
use sprung_core::parameters::JointParameter;

use crate::description::{Estimator, Joint, Physical};
use crate::estimate::estimators::least_squares::{Linear, Route};
use crate::estimate::estimators::{Criterion, Numbers};
use crate::estimate::judge::promise;
use crate::estimate::laws::dependence;
use crate::estimate::physical::{Bodies, bodies_of, covariance, information, limits, physical};
use crate::estimate::possible::{Limits, has_sum};
use crate::estimate::result::{
    CrossCheckResult, Decision, EncoderOffsetResult, EstimateResult, MotorRowResult,
    ParameterEstimate, Verdict,
};
use crate::fit::{Fitted, MotorRow, relative_residuals, residual, torques};
use crate::model::{Model, Parameter, Theta};
use crate::named::Named;
use crate::regression::System;

/// Distance from a bound at which the search for robots that can exist ends, relative to the interval.
const SEARCH_ACCURACY: f64 = 1e-4;

/// Distance of a robot from an estimate below which it is that of the estimate, in standard errors.
const MAX_DISTANCE_OF_SAME: f64 = 1e-3;

/// Returns the result of an estimator, without findings.
pub(super) fn result_of(
    model: &Model,
    (estimator, settings): (Estimator, &Physical),
    found: &Numbers,
    linear: &Linear<'_>,
    system: &System,
) -> EstimateResult {
    let fitted = &linear.fitted;
    let information = information(model, found, &found.errors, system);
    let about = (information.as_ref(), system);
    // A constrained estimate is that of a robot that can exist; its bodies are its own.
    let constrained = linear.possible.as_ref().zip(found.unconstrained.as_deref());
    let bodies = match constrained {
        Some((possible, _)) => bodies_of(&possible.robots, settings, found, about),
        None => physical(model, settings, found, about),
    };
    let limits = (constrained.zip(information.as_ref()))
        .and_then(|(constrained, information)| limits(constrained, found, information));
    let theta = &value_of(
        model,
        found,
        constrained.is_some(),
        (&bodies, limits.as_deref()),
    );
    let beside = Beside {
        unconstrained: constrained.map(|(_, theta)| theta),
        physical: (bodies.theta.as_deref()).filter(|_| constrained.is_none()),
        limits: limits.as_deref(),
    };
    let parameters = parameters(model, system, (theta, found), &beside);
    let encoder_offsets = encoder_offsets(model, &parameters);
    let rows = residual(model, system, theta);
    let named = |i: usize| model.row_name(i);
    let (motor_rows, cross_checks) = if found.criterion.stands_beside_equations() {
        (
            motor_rows(model, fitted),
            other_routes(model, &linear.routes),
        )
    } else {
        (Vec::new(), Vec::new())
    };
    EstimateResult {
        estimator: estimator.name().to_owned(),
        verdict: Verdict::Good,
        decision: Decision::default(),
        promise: promise(model, system, theta, &linear.held_out),
        rank: fitted.excitation.rank,
        unknowns: fitted.excitation.unknowns,
        condition_number: finite(fitted.excitation.condition_number),
        condition_number_scaled: finite(fitted.excitation.condition_number_scaled),
        parameters,
        covariance: (information.as_ref())
            .and_then(|information| covariance(model, found, information, limits.as_deref())),
        encoder_offsets,
        stribeck_velocity: stribeck_velocities(model, &found.criterion),
        coulomb_sharpness: sharpnesses(model, &found.criterion),
        presliding_width: of_joints(model, |joint| model.presliding_width(joint)),
        hysteresis_width: of_joints(model, |joint| model.hysteresis_width(joint)),
        play_half_width: of_joints(model, |joint| Some(model.play(joint)?[0])),
        play_centre: of_joints(model, |joint| Some(model.play(joint)?[1])),
        friction_speed: (linear.speeds.iter().enumerate())
            .filter(|(joint, _)| constrained.is_some() && has_sum(model, *joint))
            .map(|(joint, speed)| (model.joints()[joint].clone(), *speed))
            .collect(),
        dependence: dependence(model, system, theta),
        physical: bodies.result,
        standard_parameters: bodies.standard,
        motor_rows,
        refinement: found.criterion.refinement().cloned(),
        cross_checks,
        parts: if found.criterion.stands_beside_equations() {
            linear.parts.described()
        } else {
            Vec::new()
        },
        residual_rms: (rows.iter().enumerate())
            .map(|(i, (rms, _))| (named(i), *rms))
            .collect(),
        relative_residual: (relative_residuals(model, system, theta).iter().enumerate())
            .filter_map(|(i, relative)| Some((named(i), (*relative)?)))
            .collect(),
        resolution_share: (rows.iter().enumerate())
            .filter_map(|(i, _)| Some((named(i), system.kept().transition_share(i)?)))
            .collect(),
        warnings: bodies.findings,
        elapsed_s: found.elapsed,
    }
}

/// Values beside the estimate.
struct Beside<'a> {
    /// Estimate without constraints, \[p\]; `None` if there are no constraints.
    unconstrained: Option<&'a [f64]>,
    /// Values of a robot that can exist, \[p\], beside an estimate without constraints.
    physical: Option<&'a [f64]>,
    /// Intervals of robots that can exist, \[p\].
    limits: Option<&'a [Option<Limits>]>,
}

/// Returns the values of an estimate, \[p\]: those of a robot that can exist if there are constraints.
fn value_of(
    model: &Model,
    found: &Numbers,
    is_constrained: bool,
    (bodies, limits): (&Bodies, Option<&[Option<Limits>]>),
) -> Theta {
    if !is_constrained {
        return found.theta.clone();
    }
    let is_moved = (bodies.result.as_ref())
        .is_some_and(|result| result.moved_standard_errors > MAX_DISTANCE_OF_SAME);
    let theta = bodies.theta.as_ref().filter(|_| is_moved);
    without_rounding(model, theta.unwrap_or(&found.theta), limits)
}

/// Returns the parameters of an estimate in the form of the files.
fn parameters(
    model: &Model,
    system: &System,
    (theta, found): (&[f64], &Numbers),
    beside: &Beside<'_>,
) -> Vec<ParameterEstimate> {
    let torques = torques(model, system, theta);
    let described = |(i, parameter): (usize, &Parameter)| {
        let (known, error) = (found.identifiable[i], found.errors[i]);
        let mut estimate = estimate(
            parameter,
            known.then_some(theta[i]),
            Some(error).filter(|e| known && e.is_finite() && parameter.fixed.is_none()),
            found.interval,
        );
        if known {
            let torque = torques[i];
            estimate.torque_rms_nm = finite(torque.rms);
            estimate.torque_share = finite(torque.share);
            estimate.torque_over_residual = finite(torque.over_residual);
            estimate.unconstrained = beside.unconstrained.map(|theta| theta[i]);
            estimate.physical = beside.physical.map(|theta| theta[i]);
        }
        if let Some(limits) = beside.limits.and_then(|limits| limits[i]) {
            estimate.ci95 = Some(limits.ends);
            estimate.one_sided = limits.is_one_sided;
            estimate.standard_error = finite(limits.standard_error(found.interval));
        }
        if estimate.standard_error.is_some() {
            estimate.error_parts = found.error_parts.get(i).copied();
        }
        estimate
    };
    model
        .parameters()
        .iter()
        .enumerate()
        .map(described)
        .collect()
}

/// Returns parameters with friction of zero where it lies at its bound, up to the accuracy of the search.
fn without_rounding(model: &Model, theta: &[f64], limits: Option<&[Option<Limits>]>) -> Theta {
    let of = |(i, value): (usize, &f64)| {
        let most = limits
            .and_then(|limits| limits[i])
            .map_or(0.0, |limits| limits.ends[1]);
        let is_zero = model.parameters()[i].is_friction() && value.abs() < SEARCH_ACCURACY * most;
        if is_zero { 0.0 } else { *value }
    };
    theta.iter().enumerate().map(of).collect()
}

fn motor_rows(model: &Model, fitted: &Fitted) -> Vec<MotorRowResult> {
    (fitted.motor_rows.iter())
        .map(|row| describe_motor_row(model, row, fitted.interval))
        .collect()
}

/// Returns the parameters by other methods for the same equations.
fn other_routes(model: &Model, routes: &[(Route, Theta)]) -> Vec<CrossCheckResult> {
    (routes.iter())
        .map(|(route, theta)| CrossCheckResult {
            method: route.name().to_owned(),
            values: (model.parameters().iter().zip(theta))
                .map(|(parameter, value)| (parameter.name.clone(), *value))
                .collect(),
        })
        .collect()
}

/// Returns the offset of each link encoder from its motor encoder: minus the preload over the
/// stiffness.
fn encoder_offsets(model: &Model, parameters: &[ParameterEstimate]) -> Vec<EncoderOffsetResult> {
    (model.joints().iter().enumerate())
        .filter_map(|(joint, name)| {
            let preload = &parameters[model.index(JointParameter::Preload, joint)?];
            let stiffness = &parameters[model.index(JointParameter::Stiffness, joint)?];
            let (p, k) = (preload.value?, stiffness.value?);
            Some(EncoderOffsetResult {
                joint: name.clone(),
                offset_rad: finite(-p / k)?,
                standard_error_rad: preload.standard_error.and_then(|e| finite(e / k.abs())),
            })
        })
        .collect()
}

/// Returns the Stribeck velocities of the joints that have Stribeck friction: those of a refinement
/// that is used, else those of the model.
fn stribeck_velocities(model: &Model, criterion: &Criterion) -> Named {
    let used = criterion.refinement().filter(|refinement| refinement.used);
    let refined = |name: &str| {
        let mut all = used?.stribeck_velocities.iter();
        Some(all.find(|velocity| velocity.joint == name)?.velocity)
    };
    (model.joints().iter().enumerate())
        .filter(|(joint, _)| model.has_law(Scale::Stribeck, *joint))
        .map(|(joint, name)| {
            let velocity = refined(name).unwrap_or(model.stribeck_velocity(joint));
            (name.clone(), velocity)
        })
        .collect()
}

/// Returns the sharpness of Coulomb friction that was estimated: that of a refinement that is used, else that of the model
/// if a refinement has changed it.
fn sharpnesses(model: &Model, criterion: &Criterion) -> Named {
    let used = criterion.refinement().filter(|refinement| refinement.used);
    let value = |joint: usize| {
        let mut refined = used.iter().flat_map(|refinement| &refinement.sharpnesses);
        let refined = refined.find(|sharpness| sharpness.joint == model.joints()[joint]);
        let is_changed = |sharpness: &f64| sharpness.to_bits() != Joint::USUAL_SHARPNESS.to_bits();
        let in_model = Some(model.sharpness(joint)).filter(is_changed);
        refined.map(|refined| refined.sharpness).or(in_model)
    };
    (model.open_sharpness().iter())
        .filter_map(|&joint| Some((model.joints()[joint].clone(), value(joint)?)))
        .collect()
}

/// Returns the values of the joints that have them.
fn of_joints(model: &Model, value: impl Fn(usize) -> Option<f64>) -> Named {
    (model.joints().iter().enumerate())
        .filter_map(|(joint, name)| Some((name.clone(), value(joint)?)))
        .collect()
}

fn describe_motor_row(model: &Model, row: &MotorRow, interval: f64) -> MotorRowResult {
    MotorRowResult {
        joint: model.joints()[row.joint].clone(),
        parameters: (row.columns.iter().enumerate())
            .map(|(i, &column)| {
                let parameter = &model.parameters()[column];
                let known = row.identifiable[i];
                estimate(
                    parameter,
                    known.then_some(row.values[i]),
                    finite(row.standard_error[i]).filter(|_| known),
                    interval,
                )
            })
            .collect(),
        condition_number: finite(row.condition_number),
        relative_residual: finite(row.relative_residual),
        scale_number: row.scale_number.and_then(finite),
        stiffness_difference_standard_error: (row.columns.iter())
            .position(|&column| {
                model.parameters()[column].joint == Some((JointParameter::Stiffness, row.joint))
            })
            .and_then(|at| finite(row.difference_error[at])),
    }
}

fn estimate(
    parameter: &Parameter,
    value: Option<f64>,
    standard_error: Option<f64>,
    interval: f64,
) -> ParameterEstimate {
    let half = standard_error.and_then(|error| finite(interval * error));
    ParameterEstimate {
        name: parameter.name.clone(),
        symbol: parameter.symbol.clone(),
        unit: parameter.unit.to_owned(),
        value,
        standard_error,
        error_parts: None,
        ci95: value.zip(half).map(|(v, h)| [v - h, v + h]),
        one_sided: false,
        unconstrained: None,
        physical: None,
        sum_with: None,
        nominal: parameter.nominal,
        identifiable: value.is_some(),
        fixed: parameter.fixed.is_some(),
        torque_rms_nm: None,
        torque_share: None,
        torque_over_residual: None,
    }
}

fn finite(value: f64) -> Option<f64> {
    Some(value).filter(|v| v.is_finite())
}
