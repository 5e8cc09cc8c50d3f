//! What an estimate leaves of the equations, and what each parameter stands for in them.

use crate::model::Model;
use crate::regression::System;

/// Returns the residual of a row over its right-hand side, root mean squares of
/// the samples that are kept, which have no weights: a model that does not
/// explain its log must not hide behind them. Nothing if all count alike.
///
/// - `values`: parameters of the row's entries.
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

/// Returns root mean squares of the residual and of the right-hand side of
/// each row, N·m; of weighted samples if they are.
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

/// The torque that a parameter stands for in a log.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TorqueOf {
    /// Root mean square of its column times its value, N·m (N); of a parameter
    /// of two rows, where it is larger.
    pub rms: f64,
    /// Its share of the largest such torque of that row.
    pub share: f64,
    /// The same over the residual of a row, in the row where that is most.
    pub over_residual: f64,
}

/// Returns what each parameter stands for in the log.
#[must_use]
pub fn torques(model: &Model, system: &System, theta: &[f64]) -> Vec<TorqueOf> {
    let residuals = residual(model, system, theta);
    let mut torques = vec![TorqueOf::default(); theta.len()];
    for (row, factor) in system.whole().unwrap_or_default().iter().enumerate() {
        let columns = model.row_columns(row);
        let scale = 1.0 / system.weight(row).max(1.0).sqrt();
        let own: Vec<f64> = (columns.iter().enumerate())
            .map(|(j, &column)| scale * factor.column_norm(j) * theta[column].abs())
            .collect();
        let largest = own.iter().copied().fold(0.0, f64::max);
        for (&column, rms) in columns.iter().zip(own) {
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
