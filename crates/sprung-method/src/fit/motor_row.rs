//! Least squares on the motor row of one flexible joint.

use faer::Mat;
use sprung_core::parameters::JointParameter;

use super::jackknife::{influences, scatter};
use super::residual::unweighted;
use super::unknowns::Free;
use crate::model::Model;
use crate::regression::{System, SystemPart, Triangle, solve};

/// Solution of the motor row of one flexible joint.
///
/// Its right-hand side is the motor torque, which fixes the scale of the parameters. In the stacked
/// system the link rows have no right-hand side, so their errors reduce the scale.
#[derive(Clone, Debug)]
pub struct MotorRow {
    /// The joint.
    pub joint: usize,
    /// Indices in theta of the row's unknowns.
    pub columns: Vec<usize>,
    /// Values of the unknowns.
    pub values: Vec<f64>,
    /// Standard errors of the unknowns.
    pub standard_error: Vec<f64>,
    /// Standard errors of the differences between the stacked estimate and `values`.
    pub difference_error: Vec<f64>,
    /// Squared ratio of two lengths: the part of the spring torque that no other column of the row
    /// explains, over the row's residual. `None` if the stiffness is known.
    pub scale_number: Option<f64>,
    /// Whether the row determines each unknown.
    pub identifiable: Vec<bool>,
    /// Condition number without column scaling.
    pub condition_number: f64,
    /// Root mean square of the residual over that of the torque.
    pub relative_residual: f64,
}

/// Scale number below which noise of the link rows may shrink links and springs together.
pub(crate) const SAFE_SCALE: f64 = 20.0;

impl MotorRow {
    /// Returns the stiffness as if all noise of the row were noise of the deflection, which shrinks a stiffness; `None` if the
    /// row has too little noise for this.
    pub(crate) fn stiffness_of_noisy_deflection(&self, model: &Model) -> Option<f64> {
        let number = self.scale_number.filter(|number| *number < SAFE_SCALE)?;
        let column = model.index(JointParameter::Stiffness, self.joint)?;
        let at = self.columns.iter().position(|other| *other == column)?;
        Some(self.values[at] * (1.0 + 1.0 / number))
    }
}

/// Factors of a system without its known parameters.
pub(super) struct Reduced<'a> {
    pub(super) free: &'a Free,
    /// Factor of each row.
    pub(super) whole: &'a [Triangle],
    /// Factors of each row, segment by segment.
    pub(super) groups: &'a [Vec<Triangle>],
    /// Change of each unknown of the stacked system when a segment is left out, \[p × groups\].
    pub(super) stacked: &'a Mat<f64>,
}

/// Solves the motor row of a joint alone; `None` if a number is not finite.
pub(super) fn motor_row(
    model: &Model,
    joint: usize,
    system: &System,
    reduced: &Reduced<'_>,
) -> Option<MotorRow> {
    let Reduced {
        free,
        whole,
        groups,
        stacked,
    } = *reduced;
    let row = model.torque_row(joint);
    let unknowns = &free.columns[row];
    let local: Vec<usize> = (0..unknowns.len()).collect();
    let part = SystemPart {
        columns: &local,
        factor: &whole[row],
    };
    let solution = solve(&[part], unknowns.len())?;
    let row_factors: Vec<Vec<Triangle>> = groups.iter().map(|g| vec![g[row].clone()]).collect();
    let alone = influences(&solution, std::slice::from_ref(&local), &row_factors);
    let more = Mat::from_fn(unknowns.len(), groups.len(), |i, g| {
        stacked[(unknowns[i], g)] - alone[(i, g)]
    });
    let residual = whole[row].residual_length(&solution.x);
    let spring = unknowns.iter().position(|&unknown| {
        let of = model.parameters()[free.unknowns[unknown]].joint;
        of == Some((JointParameter::Stiffness, joint))
    });
    let values = values_of_row(model, row, free, &solution.x);
    Some(MotorRow {
        joint,
        difference_error: scatter(&more),
        scale_number: spring
            .map(|at| solution.x[at].powi(2) / (solution.inverse[(at, at)] * residual.powi(2))),
        columns: (unknowns.iter())
            .map(|&unknown| free.unknowns[unknown])
            .collect(),
        standard_error: scatter(&alone),
        relative_residual: unweighted(system, row, &values)
            .unwrap_or_else(|| residual / whole[row].rhs_norm()),
        values: solution.x,
        identifiable: solution.identifiable,
        condition_number: solution.condition_number,
    })
}

/// Returns the parameters of all entries of a row, including known parameters.
///
/// - `found`: values of the row's unknowns.
fn values_of_row(model: &Model, row: usize, free: &Free, found: &[f64]) -> Vec<f64> {
    let mut found = found.iter();
    (model.row_columns(row).iter())
        .map(|&column| match free.known[column] {
            Some(value) => value,
            None => found.next().copied().unwrap_or(0.0),
        })
        .collect()
}
