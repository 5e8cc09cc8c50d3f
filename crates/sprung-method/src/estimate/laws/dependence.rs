//! Friction parameters beside laws that simulators lack.

use faer::Mat;
use faer::linalg::solvers::Solve;
use sprung_core::friction::Law;
use sprung_core::parameters::{JointParameter, Side};

use crate::estimate::result::ModelDependence;
use crate::model::Model;
use crate::regression::{System, Triangle};

/// Returns the viscous and Coulomb friction of all sides with further laws, raw and projected.
///
/// Further laws explain friction that viscous and Coulomb friction could explain too, so the raw parameters depend on
/// the choice of these laws, and a simulator without them needs other values. The projection is the least-squares fit
/// of the friction of the side, further laws included, by viscous and Coulomb friction along the motion.
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
        .filter(|columns| !columns.further.is_empty())
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

/// Returns whether simulators lack a law whose torque resembles viscous or Coulomb friction.
fn is_further(law: Law) -> bool {
    match law {
        Law::Stribeck
        | Law::Quadratic
        | Law::Load
        | Law::Presliding1
        | Law::Presliding2
        | Law::Presliding3
        | Law::Presliding4
        | Law::Presliding5
        | Law::Presliding6 => true,
        Law::Viscous
        | Law::ViscousPositive
        | Law::ViscousNegative
        | Law::Coulomb
        | Law::CoulombPositive
        | Law::CoulombNegative
        | Law::Offset => false,
    }
}

/// Columns of one row: positions in the row and indices in theta.
struct Columns {
    row: usize,
    further: Vec<(usize, usize)>,
    others: Vec<(usize, usize)>,
}

impl Columns {
    fn new(model: &Model, joint: usize, side: Side, row: usize) -> Self {
        let mut found = Self {
            row,
            further: Vec::new(),
            others: Vec::new(),
        };
        for (place, &column) in model.row_columns(row).iter().enumerate() {
            let parameter = &model.parameters()[column];
            let Some((JointParameter::Friction(of, law), other)) = parameter.joint else {
                continue;
            };
            if (of, other) != (side, joint) {
                continue;
            }
            if is_further(law) {
                found.further.push((place, column));
            } else if law != Law::Offset && parameter.fixed.is_none() {
                found.others.push((place, column));
            }
        }
        found
    }

    /// Returns the parameters of the other laws; `None` if the log does not separate these laws.
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
            let explained = self.further.iter();
            let explained =
                explained.map(|&(place, column)| product(self.others[i].0, place) * theta[column]);
            explained.sum::<f64>() / length[i]
        });
        let factor_of_gram = gram.llt(faer::Side::Lower).ok()?;
        let moved = factor_of_gram.solve(&rhs);
        let by_law = factor_of_gram.solve(&Mat::from_fn(count, self.further.len(), |i, j| {
            product(self.others[i].0, self.further[j].0) / length[i]
        }));
        let parameters = (self.others.iter().enumerate()).map(|(i, &(_, column))| {
            let parameter = &model.parameters()[column];
            let difference = moved[(i, 0)] / length[i];
            ModelDependence {
                name: parameter.name.clone(),
                unit: parameter.unit.to_owned(),
                raw: theta[column],
                projected: theta[column] + difference,
                difference,
                weights: (self.further.iter().enumerate())
                    .map(|(j, &(_, column))| {
                        let name = model.parameters()[column].name.clone();
                        (name, by_law[(i, j)] / length[i])
                    })
                    .collect(),
            }
        });
        Some(parameters.collect())
    }
}
