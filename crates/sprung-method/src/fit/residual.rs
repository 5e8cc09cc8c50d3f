//! Residuals of the equations, and the torque of each parameter.

use crate::model::Model;
use crate::regression::System;

/// Returns the root mean square of a row's residual over that of its right-hand side, both from the
/// kept samples. They have no weights, because weights could mask a model that does not explain its
/// log. `None` if the system has no weights.
///
/// - `values`: parameters of all entries of the row.
pub(crate) fn unweighted(system: &System, row: usize, values: &[f64]) -> Option<f64> {
    let kept = system.kept();
    if kept.variance.get(row)?.is_empty() {
        return None;
    }
    let (mut left, mut all) = (0.0, 0.0);
    for sample in &kept.rows[row] {
        let rhs = sample.last()?;
        let fitted: f64 = sample.iter().zip(values).map(|(y, x)| y * x).sum();
        left += (fitted - rhs).powi(2);
        all += rhs.powi(2);
    }
    (all > 0.0).then(|| (left / all).sqrt())
}

/// Returns the root mean squares of the residual and of the right-hand side of each row, N·m (N).
/// If the system has weights, both are weighted.
#[must_use]
pub fn residual(model: &Model, system: &System, theta: &[f64]) -> Vec<(f64, f64)> {
    system
        .whole()
        .unwrap_or_default()
        .iter()
        .enumerate()
        .map(|(row, factor)| {
            let scale = 1.0 / system.weight(row).max(1.0).sqrt();
            let x: Vec<f64> = model.row_columns(row).iter().map(|&c| theta[c]).collect();
            let squares: f64 = factor.residual(&x).iter().map(|r| r * r).sum();
            (scale * squares.sqrt(), scale * factor.rhs_norm())
        })
        .collect()
}

/// Returns the residual of each row over its right-hand side, without weights if the kept samples allow; `None` for rows
/// without right-hand side.
#[must_use]
pub fn relative_residuals(model: &Model, system: &System, theta: &[f64]) -> Vec<Option<f64>> {
    (residual(model, system, theta).into_iter().enumerate())
        .map(|(row, (rms, rhs))| {
            let values: Vec<f64> = model.row_columns(row).iter().map(|&c| theta[c]).collect();
            (rhs > 0.0).then(|| unweighted(system, row, &values).unwrap_or(rms / rhs))
        })
        .collect()
}

/// Torque of one parameter in a log.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TorqueOf {
    /// Root mean square of the parameter's column times its value, N·m (N). A parameter in two rows
    /// has the larger of its two torques here.
    pub rms: f64,
    /// `rms` over the largest `rms` of all parameters in the same row.
    pub share: f64,
    /// Root mean square of the torque over that of the row's residual, in the row where this ratio
    /// is largest.
    pub over_residual: f64,
}

/// Returns the torque of each parameter in the log, \[p\].
#[must_use]
pub fn torques(model: &Model, system: &System, theta: &[f64]) -> Vec<TorqueOf> {
    let residuals = residual(model, system, theta);
    let mut torques = vec![TorqueOf::default(); theta.len()];
    for (row, factor) in system.whole().unwrap_or_default().iter().enumerate() {
        let columns = model.row_columns(row);
        let scale = 1.0 / system.weight(row).max(1.0).sqrt();
        let sizes: Vec<f64> = (columns.iter().enumerate())
            .map(|(j, &column)| scale * factor.column_norm(j) * theta[column].abs())
            .collect();
        let largest = sizes.iter().copied().fold(0.0, f64::max);
        for (&column, rms) in columns.iter().zip(sizes) {
            let torque = &mut torques[column];
            torque.over_residual = torque.over_residual.max(rms / residuals[row].0);
            if rms > torque.rms {
                torque.rms = rms;
                torque.share = rms / largest;
            }
        }
    }
    torques
}
