//! Fits the torque row of a joint alone.

use sprung_core::parameters::JointParameter;

use super::excerpt::Excerpt;
use crate::model::Model;
use crate::regression::{Reading, Reduction, SystemPart, Triangle, solve};

/// Figures of a joint's torque row, for comparing assumptions about the log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MotorRowFit {
    /// Stiffness, N·m/rad (N/m); `None` for a rigid joint.
    pub stiffness: Option<f64>,
    /// Whether stiffness, rotor inertia and frictions are all positive.
    pub plausible: bool,
    /// Root mean square of the residual over that of the torque.
    pub relative_residual: f64,
}

/// Least-squares fit of the torque row of one joint.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RowFit {
    /// Indices in theta of the row's parameters.
    columns: Vec<usize>,
    /// Values of these parameters.
    x: Vec<f64>,
    /// Diagonal of `(A^T A)^-1`.
    inverse: Vec<f64>,
    /// Sum of the squared residuals, N²·m².
    pub(crate) squares: f64,
    /// Sum of the squared torques, N²·m².
    pub(crate) torque: f64,
}

/// A parameter of a joint in the fit of its row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OfRow {
    pub(crate) kind: JointParameter,
    pub(crate) value: f64,
    /// Standard error.
    pub(crate) error: f64,
}

impl RowFit {
    fn new(model: &Model, row: usize, factor: &Triangle) -> Option<Self> {
        let columns = model.row_columns(row);
        let local: Vec<usize> = (0..columns.len()).collect();
        let part = SystemPart {
            columns: &local,
            factor,
        };
        let solution = solve(&[part], columns.len())?;
        Some(Self {
            columns: columns.to_vec(),
            inverse: (0..columns.len())
                .map(|i| solution.inverse[(i, i)])
                .collect(),
            squares: factor.residual(&solution.x).iter().map(|r| r * r).sum(),
            torque: factor.rhs_norm().powi(2),
            x: solution.x,
        })
    }

    /// Returns the root mean square of the residual over that of the torque.
    pub(crate) fn relative_residual(&self) -> f64 {
        (self.squares / self.torque).sqrt()
    }

    /// Returns indices in theta and their values.
    pub(crate) fn values(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.columns.iter().copied().zip(self.x.iter().copied())
    }

    /// Returns the joints' parameters.
    ///
    /// - `independent`: number of independent residuals.
    pub(crate) fn of_joints(&self, model: &Model, independent: f64) -> Vec<OfRow> {
        (self.columns.iter().enumerate())
            .filter_map(|(i, &column)| {
                let (kind, _) = model.parameters()[column].joint?;
                let error = (self.squares * self.inverse[i] / independent).sqrt();
                Some(OfRow {
                    kind,
                    value: self.x[i],
                    error,
                })
            })
            .collect()
    }

    /// Returns the figures of the fit.
    pub(crate) fn short(&self, model: &Model) -> MotorRowFit {
        let mut fit = MotorRowFit {
            stiffness: None,
            plausible: true,
            relative_residual: self.relative_residual(),
        };
        for OfRow { kind, value, .. } in self.of_joints(model, 1.0) {
            if kind == JointParameter::Stiffness {
                fit.stiffness = Some(value);
            }
            if (kind.is_vital() || kind.is_friction()) && value <= 0.0 {
                fit.plausible = false;
            }
        }
        fit
    }
}

/// Fits the torque rows of some joints of an excerpt, each alone; `None` if the excerpt is too
/// short for the filters or the filters do not fit its period.
pub(crate) fn fit_rows(
    excerpt: &Excerpt,
    reading: &Reading,
    joints: &[usize],
) -> Option<Vec<RowFit>> {
    let model = reading.model();
    let rows: Vec<usize> = joints.iter().map(|&j| model.torque_row(j)).collect();
    let empty = Reduction::of_rows(model, &rows).without_samples();
    let signals = excerpt.smoothed(reading)?.thinned(reading);
    let whole = signals.reduce_by(empty, reading)?.whole()?;
    (rows.iter().zip(&whole))
        .map(|(&row, factor)| RowFit::new(model, row, factor))
        .collect()
}

/// Fits the torque rows of all joints, each alone; `None` if a number is not finite.
///
/// - `whole`: one factor of all samples for each row.
pub(crate) fn fit_all_rows(model: &Model, whole: &[Triangle]) -> Option<Vec<RowFit>> {
    (0..model.joint_count())
        .map(|joint| model.torque_row(joint))
        .map(|row| RowFit::new(model, row, &whole[row]))
        .collect()
}

/// Returns the number of independent filtered residuals of an excerpt: residuals are correlated
/// over about 2/λ.
pub(crate) fn independent(excerpt: &Excerpt, reading: &Reading) -> f64 {
    (excerpt.duration() * reading.filter_cutoff() / 2.0).max(1.0)
}
