//! Errors of a parameter vector along a measured motion: of the motor torque and of the spring's
//! deflection.

use sprung_core::parameters::JointParameter;

use super::residual::residual;
use crate::model::Model;
use crate::regression::System;

/// Errors of the filtered equations of a joint, root mean squares over all samples. Friction at rest
/// may have any value between its bounds, so only the part of an error beyond these bounds counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct JointFit {
    /// Filtered motor torque, N·m (N).
    pub(crate) torque: f64,
    /// Residual of the torque row, N·m (N).
    pub(crate) torque_error: f64,
    /// Filtered deflection of the spring and the residual of the link row over the stiffness, rad
    /// (m); `None` without a spring of positive stiffness.
    pub(crate) deflection: Option<(f64, f64)>,
}

/// Returns the errors of each joint; `None` for a system without samples.
///
/// - `theta`: parameters, \[p\].
pub(crate) fn joint_fits(model: &Model, system: &System, theta: &[f64]) -> Option<Vec<JointFit>> {
    let rows = residual(model, system, theta);
    let fits = (0..model.joint_count()).map(|joint| {
        let torque_row = model.torque_row(joint);
        let (torque, torque_error) = row_fit(model, system, theta, &rows, torque_row, None)?;
        let spring = model.index(JointParameter::Stiffness, joint);
        let stiffness = spring.filter(|&k| theta[k] > 0.0 && joint != torque_row);
        let deflection = stiffness.and_then(|k| {
            let (deflection, error) = row_fit(model, system, theta, &rows, joint, Some(k))?;
            Some((deflection, error / theta[k]))
        });
        Some(JointFit {
            torque,
            torque_error,
            deflection,
        })
    });
    fits.collect()
}

/// Returns the root mean squares of a reference and of the residual of a row. With weights both come from the kept
/// samples, because weights could mask an error.
///
/// - `rows`: residuals of all samples; `column`: the parameter whose entry is the reference; the
///   right-hand side without it.
fn row_fit(
    model: &Model,
    system: &System,
    theta: &[f64],
    rows: &[(f64, f64)],
    row: usize,
    column: Option<usize>,
) -> Option<(f64, f64)> {
    let kept = system.kept();
    let samples = kept.rows.get(row)?;
    let columns = model.row_columns(row);
    let place = match column {
        Some(column) => columns.iter().position(|&c| c == column)?,
        None => columns.len(),
    };
    let bounds = kept.bound.get(row).map_or(&[][..], Vec::as_slice);
    let (mut reference, mut all, mut beyond) = (0.0, 0.0, 0.0);
    for (k, sample) in samples.iter().enumerate() {
        let fitted: f64 = columns.iter().zip(sample).map(|(&c, y)| theta[c] * y).sum();
        let error = (fitted - sample.last()?).abs();
        let bound = bounds.get(k).copied().unwrap_or(0.0);
        reference += sample[place].powi(2);
        all += error.powi(2);
        beyond += (error - bound).max(0.0).powi(2);
    }
    let count = samples.len().max(1) as f64;
    if system.is_weighted(row) {
        return Some(((reference / count).sqrt(), (beyond / count).sqrt()));
    }
    let (residual, rhs) = rows[row];
    let share = if all > 0.0 {
        (beyond / all).sqrt()
    } else {
        1.0
    };
    let reference = if column.is_some() {
        (reference / count).sqrt()
    } else {
        rhs
    };
    Some((reference, residual * share))
}
