//! Findings about the stability of least squares: between parts of the logs, and over cut-offs.

use super::parameters::listed;
use crate::estimate::estimators::least_squares::Linear;
use crate::estimate::result::EstimateResult;
use crate::estimate::statistics::between_parts;
use crate::estimate::statistics::kind_of_change;
use crate::estimate::statistics::{
    CERTAIN_SIGMAS, FALSE_ALARM_PROBABILITY, LARGE_SHARE, SMALL_SHARE,
};
use crate::finding::{Finding, Severity};
use crate::model::Model;
use crate::prepare::Sweep;

/// Parts agree if their scatter has at least this probability.
const AGREEMENT_PROBABILITY: f64 = 0.05;

/// Lowest cut-off at which estimates are compared, as a fraction of the cut-off in use.
const LOWEST_COMPARED_CUTOFF: f64 = 0.49;

/// Reports the parameters that change between parts of the logs by more than their standard errors
/// allow.
pub(super) fn parts_disagree(model: &Model, linear: &Linear<'_>) -> Option<Finding> {
    let unknowns = linear.fitted.excitation.unknowns.max(1) as f64;
    let mut changes = Vec::new();
    let mut names = Vec::new();
    let mut disagreeing = Vec::new();
    let mut severity = Severity::Info;
    let mut count = 0;
    for (i, parameter) in model.parameters().iter().enumerate() {
        if (parameter.joint).is_some_and(|(kind, _)| kind.is_of_curve()) {
            continue;
        }
        let Some(values) = linear.parts.cautious(i) else {
            continue;
        };
        let Some(found) = between_parts(&values) else {
            continue;
        };
        if found.probability >= FALSE_ALARM_PROBABILITY / unknowns {
            continue;
        }
        let deviation = found.variance.sqrt();
        if deviation > LARGE_SHARE * linear.fitted.theta[i].abs()
            && deviation > linear.fitted.bias[i]
            && (linear.parts.are_logs || most_parts_disagree(&values))
            && (parameter.joint).is_none_or(|(kind, _)| kind.is_vital() || kind.is_friction())
        {
            severity = Severity::Warning;
        }
        let values = linear.parts.of(i).unwrap_or_default();
        count = count.max(values.len());
        let each: Vec<String> = (values.iter())
            .map(|(x, error)| format!("{x:.4} ± {error:.2e}"))
            .collect();
        changes.push(format!(
            "{} ({} {})",
            parameter.short(),
            each.join(", "),
            parameter.unit
        ));
        names.push(parameter.name.clone());
        disagreeing.push(i);
    }
    if changes.is_empty() {
        return None;
    }
    let (code, what) = match (linear.parts.are_logs, count) {
        (true, _) => ("logs-disagree", "logs"),
        (false, 2) => ("parts-disagree", "halves of the log"),
        (false, _) => ("parts-disagree", "quarters of the log"),
    };
    let kind = if linear.parts.are_logs {
        kind_of_change(model, &disagreeing)
    } else {
        ""
    };
    Some(
        Finding::new(
            severity,
            code,
            format!(
                "estimates by least squares from the {what} differ by more than their standard \
                 errors allow: {}. One set of parameters does not describe all parts.{kind}",
                listed(changes.into_iter())
            ),
            "make sure that the robot and its payload stay the same; parameters that change with \
             the motion mean that the model lacks an effect. The intervals of least squares \
             contain the change",
        )
        .about(names),
    )
}

/// Returns whether parts disagree without each one of them, too. A quarter in which a joint hardly moves
/// may have an estimate far from all others.
fn most_parts_disagree(values: &[(f64, f64)]) -> bool {
    let without = |left_out: usize| {
        let others = values.iter().enumerate().filter(|(i, _)| *i != left_out);
        others.map(|(_, value)| *value).collect::<Vec<_>>()
    };
    values.len() < 3
        || (0..values.len())
            .filter_map(|left_out| between_parts(&without(left_out)))
            .all(|found| found.probability < AGREEMENT_PROBABILITY)
}

/// Reports the parameters that change with the cut-off of the positions by more than their
/// intervals and the scatter of the change over the parts of the log allow.
pub(super) fn cutoff_drift(
    model: &Model,
    result: &EstimateResult,
    sweep: &Sweep,
) -> Option<Finding> {
    let chosen = &sweep.points[sweep.chosen];
    let compared = (sweep.points.iter())
        .filter(|point| point.cutoff_hz >= LOWEST_COMPARED_CUTOFF * chosen.cutoff_hz);
    let mut drifts = Vec::new();
    let mut names = Vec::new();
    let mut severity = Severity::Info;
    for (i, estimate) in result.parameters.iter().enumerate() {
        let of_joint = model.parameters()[i].joint;
        let of_curve = of_joint.is_some_and(|(kind, _)| kind.is_of_curve());
        let Some([low, high]) = estimate.ci95.filter(|_| !estimate.fixed && !of_curve) else {
            continue;
        };
        let change = |theta: &[f64]| (theta[i] - chosen.theta[i]).abs();
        let Some(farthest) = (compared.clone())
            .max_by(|a, b| change(&a.theta).total_cmp(&change(&b.theta)))
            .filter(|point| {
                let by_chance = point.change_by_chance(chosen, i);
                change(&point.theta) > by_chance.hypot(0.5 * (high - low))
            })
        else {
            continue;
        };
        let error = estimate.standard_error.unwrap_or(f64::INFINITY);
        let (drift, value) = (change(&farthest.theta), chosen.theta[i].abs());
        if drift > LARGE_SHARE * value
            || drift > CERTAIN_SIGMAS * error && drift > SMALL_SHARE * value
        {
            severity = Severity::Warning;
        }
        drifts.push(format!(
            "{} {:.4} {unit} at {:.3} Hz, {:.4} {unit} at {:.3} Hz",
            model.parameters()[i].short(),
            chosen.theta[i],
            chosen.cutoff_hz,
            farthest.theta[i],
            farthest.cutoff_hz,
            unit = estimate.unit
        ));
        names.push(estimate.name.clone());
    }
    (!drifts.is_empty()).then(|| {
        Finding::new(
            severity,
            "cutoff-drift",
            format!(
                "some estimates by least squares change with the cut-off of the positions by more \
                 than their intervals: {}",
                listed(drifts.into_iter())
            ),
            "the model lacks an effect in this band, for example an elasticity or a torque ripple, \
             or the positions are noisy; look at the sweep of cut-offs in the report",
        )
        .about(names)
    })
}

/// Reports the parameters whose estimated bias exceeds their sampling error.
pub(super) fn shared_bias(result: &EstimateResult) -> Option<Finding> {
    let biased: Vec<_> = (result.parameters.iter())
        .filter_map(|p| Some((p, p.error_parts?)))
        .filter(|(_, parts)| parts.bias > parts.sampling)
        .collect();
    (!biased.is_empty()).then(|| {
        let list =
            (biased.iter()).map(|(p, parts)| format!("{} {:.1e} {}", p.name, parts.bias, p.unit));
        Finding::new(
            Severity::Info,
            "bias-dominates",
            format!(
                "a longer log does not improve {} of {} estimates by least squares: their bias, \
                 estimated from cross-checks and from neighbouring cut-offs, exceeds their \
                 sampling error ({}). The standard errors contain it",
                biased.len(),
                result.unknowns,
                listed(list)
            ),
            "use the prediction-error estimator, or finer encoders",
        )
        .about(biased.iter().map(|(p, _)| p.name.clone()))
    })
}
