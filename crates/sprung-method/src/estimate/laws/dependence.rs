//! Friction parameters beside residual laws.

use faer::Mat;
use faer::linalg::solvers::Solve;
use sprung_core::friction::Family;
use sprung_core::parameters::{JointParameter, Side};

use crate::estimate::result::ModelDependence;
use crate::model::Model;
use crate::regression::{System, Triangle};

/// Returns the friction parameters of all sides with residual laws, raw and projected.
///
/// Residual laws explain friction that the other laws of their side could explain too, so the raw
/// parameters depend on the choice of the residual laws. The projection is the least-squares fit of
/// the friction of the side, residual laws included, by its other laws along the motion.
pub(in crate::estimate) fn dependence(
    model: &Model,
    system: &System,
    theta: &[f64],
) -> Vec<ModelDependence> {
    let sides = (0..model.joint_count()).flat_map(|joint| {
        [
            (joint, Side::Link, joint),
            (joint, Side::Motor, model.torque_row(joint)),
        ]
    });
    let sides: Vec<Columns> = sides
        .map(|(joint, side, row)| Columns::new(model, joint, side, row))
        .filter(|columns| !columns.residual.is_empty())
        .collect();
    if sides.is_empty() {
        return Vec::new();
    }
    let Some(whole) = system.whole() else {
        return Vec::new();
    };
    sides
        .iter()
        .filter_map(|columns| columns.projected(model, &whole[columns.row], theta))
        .flatten()
        .collect()
}

/// Columns of one row: positions in the row and indices in theta.
struct Columns {
    row: usize,
    residual: Vec<(usize, usize)>,
    others: Vec<(usize, usize)>,
}

impl Columns {
    fn new(model: &Model, joint: usize, side: Side, row: usize) -> Self {
        let mut found = Self {
            row,
            residual: Vec::new(),
            others: Vec::new(),
        };
        for (place, &column) in model.row_columns(row).iter().enumerate() {
            let parameter = &model.parameters()[column];
            let Some((JointParameter::Friction(of, law), own)) = parameter.joint else {
                continue;
            };
            if (of, own) != (side, joint) {
                continue;
            }
            if Family::Residual.laws().contains(&law) {
                found.residual.push((place, column));
            } else if parameter.fixed.is_none() {
                found.others.push((place, column));
            }
        }
        found
    }

    /// Returns the parameters of the other laws; `None` if the log does not tell these laws apart.
    fn projected(
        &self,
        model: &Model,
        factor: &Triangle,
        theta: &[f64],
    ) -> Option<Vec<ModelDependence>> {
        let product = |i: usize, j: usize| -> f64 {
            (0..=i.min(j))
                .map(|k| factor.entry(k, i) * factor.entry(k, j))
                .sum()
        };
        let count = self.others.len();
        let length: Vec<f64> = (self.others.iter())
            .map(|&(place, _)| product(place, place).sqrt())
            .collect();
        let gram = Mat::from_fn(count, count, |i, j| {
            product(self.others[i].0, self.others[j].0) / (length[i] * length[j])
        });
        let rhs = Mat::from_fn(count, 1, |i, _| {
            let explained = self.residual.iter();
            let explained =
                explained.map(|&(place, column)| product(self.others[i].0, place) * theta[column]);
            explained.sum::<f64>() / length[i]
        });
        let moved = gram.llt(faer::Side::Lower).ok()?.solve(&rhs);
        let parameters = (self.others.iter().enumerate()).map(|(i, &(_, column))| {
            let parameter = &model.parameters()[column];
            let difference = moved[(i, 0)] / length[i];
            ModelDependence {
                name: parameter.name.clone(),
                unit: parameter.unit.to_owned(),
                raw: theta[column],
                projected: theta[column] + difference,
                difference,
            }
        });
        Some(parameters.collect())
    }
}
