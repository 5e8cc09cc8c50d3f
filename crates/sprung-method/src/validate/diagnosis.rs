//! The smallest change of the robot between two logs that explains a broken promise.

use sprung_core::parameters::JointParameter;
use sprung_core::spatial::{BODY, BODY_NAMES, BODY_UNITS};

use super::proof::{JointProof, PROMISE_TOLERANCE};
use crate::check::UNEXPLAINED;
use crate::estimate::{JointPrediction, predictions};
use crate::fit::{Direction, Steps, steps_along};
use crate::model::Model;
use crate::regression::System;

/// A change explains a broken promise if it removes at least this share of the squared errors beyond
/// the promise.
const EXPLAINED_SHARE: f64 = 0.8;

/// Largest error after a change, over the promised one. A change may also amplify noise: a larger
/// inertia amplifies that of accelerations.
const RESTORED: f64 = 2.0;

/// Changes are equally good if the products of their squared errors, over all quantities, differ by
/// less than this factor; that with the fewest unknowns is chosen.
const EQUALLY_GOOD: f64 = 1.3;

/// Number of standard errors above which a step counts as a change.
const SIGNIFICANT_SIGMAS: f64 = 2.0;

/// Change of the robot between identification and validation.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Kind {
    /// Friction and torque offset of one joint, or of all joints.
    Friction(Option<usize>),
    /// Inertial parameters of the last link: the joint that carries it; `None` for all links of a
    /// robot in closed form.
    Payload(Option<usize>),
    /// Stiffness of a joint.
    Stiffness(usize),
    /// Scale of a joint's logged torque.
    TorqueScale(usize),
}

/// Value that changed, with its standard error.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Step {
    /// Name of the parameter; empty for the scale of a torque.
    pub(super) name: String,
    pub(super) unit: &'static str,
    /// Value in the parameter set; `None` if only the change is known.
    pub(super) before: Option<f64>,
    pub(super) change: f64,
    pub(super) error: f64,
}

/// A change that explains a broken promise.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Change {
    pub(super) kind: Kind,
    /// Significant steps, the most significant first.
    pub(super) steps: Vec<Step>,
    /// Errors of each joint with the change.
    pub(super) after: Vec<JointPrediction>,
    unknowns: usize,
    // Sum of the logarithms of the squared errors, relative to the promised ones.
    misfit: f64,
}

/// Returns the smallest change that restores the prediction; `None` if no change does.
///
/// - `theta`: parameters of the set, \[p\]; `proofs`: their errors on the log, joint by joint.
///
/// Each change is fitted by least squares with all other parameters fixed. Rows count relative to
/// their promised errors.
pub(super) fn smallest_change(
    model: &Model,
    system: &System,
    theta: &[f64],
    proofs: &[JointProof],
) -> Option<Change> {
    let promised: Vec<Promised> = proofs.iter().map(Promised::of).collect();
    let before: Vec<JointPrediction> = predictions(model, system, theta);
    let excess = excess(&before, &promised);
    let changes: Vec<Change> = kinds(model)
        .into_iter()
        .filter_map(|kind| tried(model, system, theta, &promised, kind))
        .filter(|change| {
            let left = ratios(&change.after, &promised);
            left.iter().all(|ratio| *ratio <= RESTORED)
                && !change.steps.is_empty()
                && self::excess(&change.after, &promised) <= (1.0 - EXPLAINED_SHARE) * excess
        })
        .collect();
    let least = (changes.iter())
        .map(|change| change.misfit)
        .fold(f64::INFINITY, f64::min);
    (changes.into_iter())
        .filter(|change| change.misfit <= least + EQUALLY_GOOD.ln())
        .min_by_key(|change| change.unknowns)
}

/// Promised errors of a joint; without a promise those at which a prediction is poor.
struct Promised {
    torque: f64,
    deflection: Option<f64>,
}

impl Promised {
    fn of(proof: &JointProof) -> Self {
        let poor = |value: f64| UNEXPLAINED / PROMISE_TOLERANCE * value;
        Self {
            torque: proof
                .torque_promised_nm
                .unwrap_or_else(|| poor(proof.torque_nm)),
            deflection: (proof.deflection_promised_rad).or(proof.deflection_rad.map(poor)),
        }
    }
}

/// Returns the errors over the promised errors.
fn ratios(errors: &[JointPrediction], promised: &[Promised]) -> Vec<f64> {
    (errors.iter().zip(promised))
        .flat_map(|(errors, promised)| {
            let deflection = errors.deflection_error_rad.zip(promised.deflection);
            [
                Some(errors.torque_error_nm / promised.torque),
                deflection.map(|(error, promised)| error / promised),
            ]
        })
        .flatten()
        .filter(|ratio| ratio.is_finite())
        .collect()
}

/// Returns the sum of the squared errors beyond the promised ones, relative to these.
fn excess(errors: &[JointPrediction], promised: &[Promised]) -> f64 {
    let ratios = ratios(errors, promised).into_iter();
    ratios.map(|ratio| (ratio * ratio - 1.0).max(0.0)).sum()
}

/// Returns the kinds of changes that are possible.
fn kinds(model: &Model) -> Vec<Kind> {
    let n = model.joint_count();
    let scales = (0..n).map(Kind::TorqueScale);
    let friction = (0..n).map(|joint| Kind::Friction(Some(joint)));
    let springs = (0..n)
        .filter(|&joint| model.is_flexible(joint))
        .map(Kind::Stiffness);
    let mut kinds: Vec<Kind> = scales.chain(springs).chain(friction).collect();
    if n > 1 {
        kinds.push(Kind::Friction(None));
    }
    match model.tree() {
        None => kinds.push(Kind::Payload(None)),
        Some(tree) => {
            let carries = |joint: usize| tree.joints.iter().any(|j| j.parent == Some(joint));
            let last = (0..n).filter(|&joint| !carries(joint));
            kinds.extend(last.map(|joint| Kind::Payload(Some(joint))));
        }
    }
    kinds
}

/// An unknown of a change.
struct Unknown {
    direction: Direction,
    name: String,
    unit: &'static str,
    before: Option<f64>,
}

/// Returns the unknowns of a kind of change.
fn unknowns(model: &Model, theta: &[f64], kind: &Kind) -> Vec<Unknown> {
    let parameter = |i: usize| {
        let mut change = vec![0.0; theta.len()];
        change[i] = 1.0;
        Unknown {
            direction: Direction::Parameters(change),
            name: model.parameters()[i].short().into_owned(),
            unit: model.parameters()[i].unit,
            before: Some(theta[i]),
        }
    };
    let those = |is_chosen: &dyn Fn(Option<(JointParameter, usize)>) -> bool| -> Vec<Unknown> {
        (0..theta.len())
            .filter(|&i| is_chosen(model.parameters()[i].joint))
            .map(parameter)
            .collect()
    };
    match *kind {
        Kind::Friction(one) => those(&|joint| match joint {
            Some((JointParameter::Friction(..), joint)) => one.is_none_or(|one| one == joint),
            _ => false,
        }),
        Kind::Stiffness(joint) => {
            those(&|parameter| parameter == Some((JointParameter::Stiffness, joint)))
        }
        Kind::Payload(None) => those(&|joint| joint.is_none()),
        Kind::Payload(Some(joint)) => (0..BODY)
            .map(|k| {
                let link = model.tree().and_then(|tree| tree.links.get(joint));
                Unknown {
                    direction: Direction::Parameters(model.change_by_standard(joint * BODY + k)),
                    name: format!("{}.{}", link.map_or("", String::as_str), BODY_NAMES[k]),
                    unit: BODY_UNITS[k],
                    before: None,
                }
            })
            .filter(|unknown| match &unknown.direction {
                Direction::Parameters(change) => change.iter().any(|x| *x != 0.0),
                Direction::Torque(_) => true,
            })
            .collect(),
        Kind::TorqueScale(joint) => vec![Unknown {
            direction: Direction::Torque(model.torque_row(joint)),
            name: String::new(),
            unit: "",
            before: Some(1.0),
        }],
    }
}

/// Fits a change; `None` if the log does not determine it.
fn tried(
    model: &Model,
    system: &System,
    theta: &[f64],
    promised: &[Promised],
    kind: Kind,
) -> Option<Change> {
    let unknowns = unknowns(model, theta, &kind);
    if unknowns.is_empty() {
        return None;
    }
    let directions: Vec<Direction> = (unknowns.iter())
        .map(|unknown| unknown.direction.clone())
        .collect();
    let scales = scales(model, theta, promised);
    let fitted = steps_along(model, system, theta, &directions, &scales)?;
    let after = errors_after(model, system, theta, &kind, &directions, &fitted)?;
    // The likelihood of rows with unknown noise.
    let misfit = ratios(&after, promised).iter().map(|r| 2.0 * r.ln()).sum();
    let significance = |step: &Step| (step.change / step.error).abs();
    let mut steps: Vec<Step> = (unknowns.into_iter().enumerate())
        .map(|(i, unknown)| Step {
            name: unknown.name,
            unit: unknown.unit,
            before: unknown.before,
            change: fitted.sizes[i],
            error: fitted.errors[i],
        })
        .filter(|step| significance(step) > SIGNIFICANT_SIGMAS)
        .collect();
    steps.sort_by(|a, b| significance(b).total_cmp(&significance(a)));
    Some(Change {
        kind,
        steps,
        after,
        unknowns: directions.len(),
        misfit,
    })
}

/// Returns the promised error of each row's residual, N·m (N).
fn scales(model: &Model, theta: &[f64], promised: &[Promised]) -> Vec<f64> {
    let scale = |row: usize| {
        let joint = model.joint_of(row);
        let stiffness = model.index(JointParameter::Stiffness, joint);
        let of_link = promised[joint].deflection.zip(stiffness);
        match of_link.filter(|_| row != model.torque_row(joint)) {
            Some((error, k)) => error * theta[k].abs(),
            None => promised[joint].torque,
        }
    };
    (0..model.rows())
        .map(|row| Some(scale(row)).filter(|s| *s > 0.0).unwrap_or(1.0))
        .collect()
}

/// Returns the errors with a fitted change; `None` if it is impossible.
fn errors_after(
    model: &Model,
    system: &System,
    theta: &[f64],
    kind: &Kind,
    directions: &[Direction],
    fitted: &Steps,
) -> Option<Vec<JointPrediction>> {
    if let Kind::TorqueScale(joint) = *kind {
        let gain = 1.0 + fitted.sizes[0];
        if gain <= 0.0 {
            return None;
        }
        // In the units of the log: A theta - g b = g (A (theta / g) - b).
        let divided: Vec<f64> = theta.iter().map(|value| value / gain).collect();
        let scaled = predictions(model, system, &divided);
        let mut after = predictions(model, system, theta);
        after.get_mut(joint)?.torque_error_nm = scaled.get(joint)?.torque_error_nm;
        return Some(after);
    }
    let mut moved = theta.to_vec();
    for (direction, size) in directions.iter().zip(&fitted.sizes) {
        if let Direction::Parameters(change) = direction {
            for (value, change) in moved.iter_mut().zip(change) {
                *value += size * change;
            }
        }
    }
    Some(predictions(model, system, &moved))
}
