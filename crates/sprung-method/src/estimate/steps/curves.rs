//! Parameters over time, and measured and predicted right-hand sides, as curves.

use sprung_core::chain::JointKind;
use sprung_core::parameters::JointParameter;

use super::joint_curves::{JointCurve, joint_curves};
use crate::curves::{CurveSet, Curves};
use crate::description::Estimator;
use crate::estimate::result::EstimateResult;
use crate::fit::trace;
use crate::model::{Model, Theta};
use crate::regression::System;

/// Returns the parameters over time; those of least squares if no estimator has a trace.
pub(super) fn over_time(model: &Model, system: &System, mut traces: Vec<CurveSet>) -> Curves {
    if traces.is_empty() {
        let points = trace(model, system).collect();
        traces.push(trace_of(model, Estimator::LeastSquares, points));
    }
    Curves {
        columns: model.parameters().iter().map(|p| p.name.clone()).collect(),
        sets: traces,
    }
}

/// Returns the trace of an estimator.
pub(super) fn trace_of(
    model: &Model,
    estimator: Estimator,
    points: Vec<(f64, Option<Theta>)>,
) -> CurveSet {
    let mut set = CurveSet {
        label: estimator.name().to_owned(),
        time: Vec::new(),
        values: vec![Vec::new(); model.parameters().len()],
    };
    for (time, theta) in points {
        set.time.push(time);
        for (i, values) in set.values.iter_mut().enumerate() {
            values.push(theta.as_ref().map(|theta| theta[i]));
        }
    }
    set
}

/// Returns the filtered right-hand sides and the filtered deflections of the springs: measured, and
/// computed with each estimate; and the friction and the spring of each joint by the first estimate.
pub(super) fn fit_curves<'a>(
    model: &Model,
    thetas: impl IntoIterator<Item = (Estimator, &'a Theta)>,
    first: Option<&EstimateResult>,
    system: &System,
) -> Curves {
    let kept = system.kept();
    let springs: Vec<Spring> = (0..model.joint_count())
        .filter_map(|joint| Spring::of(model, joint))
        .collect();
    let rows = |of: &dyn Fn(usize, &[f64]) -> f64| -> Vec<Vec<Option<f64>>> {
        (kept.rows.iter().enumerate())
            .map(|(row, samples)| samples.iter().map(|sample| Some(of(row, sample))).collect())
            .collect()
    };
    let deflections = |of: &dyn Fn(&Spring, &[f64]) -> Option<f64>| -> Vec<Vec<Option<f64>>> {
        (springs.iter())
            .map(|spring| {
                kept.rows[spring.joint]
                    .iter()
                    .map(|sample| of(spring, sample))
                    .collect()
            })
            .collect()
    };
    let set = |label: &str, mut values: Vec<_>, more| {
        values.extend(more);
        CurveSet {
            label: label.to_owned(),
            time: kept.time.clone(),
            values,
        }
    };
    let measured = rows(&|_, sample| sample.last().copied().unwrap_or_default());
    let deflected = deflections(&|spring, sample| Some(sample[spring.place]));
    let mut sets = vec![set("measured", measured, deflected)];
    let mut of_joints = Vec::new();
    for (estimator, theta) in thetas {
        if let Some(first) = first.filter(|result| result.estimator == estimator.name()) {
            of_joints = joint_curves(model, theta, first, system);
        }
        let fitted = |row: usize, sample: &[f64]| -> f64 {
            let columns = model.row_columns(row).iter().zip(sample);
            columns.map(|(&column, entry)| theta[column] * entry).sum()
        };
        // The link's equation solved for the deflection.
        let deflected = deflections(&|spring, sample| {
            let stiffness = Some(theta[spring.column]).filter(|k| *k > 0.0)?;
            let residual = fitted(spring.joint, sample) - sample.last()?;
            Some(sample[spring.place] - residual / stiffness)
        });
        sets.push(set(estimator.name(), rows(&fitted), deflected));
    }
    let mut columns: Vec<String> = (0..model.rows()).map(|row| model.row_name(row)).collect();
    columns.extend(springs.iter().map(|spring| spring.name.clone()));
    for JointCurve { name, values } in of_joints {
        columns.push(name);
        for set in &mut sets {
            let is_first = first.is_some_and(|result| result.estimator == set.label);
            set.values.push(if is_first {
                values.clone()
            } else {
                vec![None; kept.time.len()]
            });
        }
    }
    Curves { columns, sets }
}

/// The spring of a flexible joint.
struct Spring {
    joint: usize,
    /// Index of the stiffness in theta, and of its entry in the samples of the link row.
    column: usize,
    place: usize,
    /// Name of the deflection, with its unit.
    name: String,
}

impl Spring {
    /// Returns the spring of a joint; `None` for a rigid joint.
    fn of(model: &Model, joint: usize) -> Option<Self> {
        let column = model.index(JointParameter::Stiffness, joint)?;
        (joint != model.torque_row(joint)).then_some(())?;
        let unit = match model.kind(joint) {
            JointKind::Revolute => "rad",
            JointKind::Prismatic => "m",
        };
        Some(Self {
            joint,
            column,
            place: model.row_columns(joint).iter().position(|&c| c == column)?,
            name: format!("{}.deflection_{unit}", model.joints()[joint]),
        })
    }
}
