//! Fits all link equations of an excerpt together, and each alone.
//!
//! The link equation of a joint contains the torque that accelerates and carries the links: the
//! motor torque of a rigid joint, the spring torque of a flexible joint. The motor row gives the
//! spring, so the spring torque is a known right-hand side. Each equation is divided by the length
//! of its right-hand side, so that small joints count as much as large ones.

use sprung_core::parameters::JointParameter;

use super::excerpt::Excerpt;
use crate::model::Model;
use crate::regression::{Reading, SystemPart, Triangle, solve, solve_quickly};

/// Factor between the torques of the log and those of the nominal bodies by inaccurate nominal
/// values.
pub(crate) const INACCURATE_FACTOR: f64 = 3.0;

/// Smallest part of the bodies' torque (squares) that the nominal bodies must explain before their
/// scale counts, and smallest distance of the scale from zero in standard errors.
const MIN_EXPLAINED_BY_NOMINAL: f64 = 0.5;
const SCALE_SIGMAS: f64 = 5.0;

/// The link equation of a joint.
pub(crate) struct LinkRow {
    /// Joint, from 0.
    pub(crate) joint: usize,
    /// Indices in theta of the unknowns.
    columns: Vec<usize>,
    factor: Triangle,
}

/// The link equations of an excerpt.
pub(crate) struct LinkRows {
    pub(crate) rows: Vec<LinkRow>,
    /// Whether all springs are positive.
    pub(crate) plausible: bool,
}

/// Torque of the nominal bodies in the link equation of a joint.
pub(crate) struct BodyScale {
    /// Joint, from 0.
    pub(crate) joint: usize,
    /// Torque of the log over that of the nominal bodies.
    pub(crate) scale: f64,
    /// Standard error of the scale for one independent residual.
    pub(crate) error: f64,
    /// Root mean squares of the residuals over that of the right-hand side: without bodies, with the
    /// scaled nominal bodies, with free bodies.
    pub(crate) left: [f64; 3],
}

impl LinkRows {
    /// Returns the link equations of some joints; `None` if the excerpt is too short for the filters
    /// or a number is not finite.
    pub(crate) fn new(excerpt: &Excerpt, reading: &Reading, joints: &[usize]) -> Option<Self> {
        let whole = excerpt.reduce_thinned(reading)?.whole()?;
        Self::of(reading.model(), &whole, joints)
    }

    /// Returns the link equations of some joints; `None` if a number is not finite.
    ///
    /// - `whole`: one factor of all samples for each row.
    pub(crate) fn of(model: &Model, whole: &[Triangle], joints: &[usize]) -> Option<Self> {
        let mut known: Vec<Option<f64>> = model.parameters().iter().map(|p| p.fixed).collect();
        let mut plausible = true;
        for joint in (0..model.joint_count()).filter(|&joint| model.is_flexible(joint)) {
            let row = model.torque_row(joint);
            let x = alone(&whole[row])?;
            for (&column, value) in model.row_columns(row).iter().zip(x) {
                if is_of_spring(model, column) && known[column].is_none() {
                    known[column] = Some(value);
                }
            }
            let stiffness = model.index(JointParameter::Stiffness, joint);
            plausible &= stiffness.and_then(|i| known[i]).is_none_or(|k| k > 0.0);
        }
        let rows = (joints.iter())
            .filter_map(|&joint| {
                let known_values: Vec<Option<f64>> = (model.row_columns(joint).iter())
                    .map(|&column| known[column])
                    .collect();
                let factor = whole[joint].with_known(&known_values);
                let size = factor.rhs_norm();
                (size > 0.0 && size.is_finite()).then(|| LinkRow {
                    joint,
                    columns: (model.row_columns(joint).iter().copied())
                        .filter(|&column| known[column].is_none())
                        .collect(),
                    factor: factor.scaled(1.0 / size),
                })
            })
            .collect();
        Some(Self { rows, plausible })
    }

    /// Returns the unexplained part of each right-hand side by all equations together (root mean
    /// squares); `None` if a number is not finite.
    pub(crate) fn together(&self, model: &Model) -> Option<Vec<f64>> {
        let parts: Vec<SystemPart<'_>> = (self.rows.iter())
            .map(|row| SystemPart {
                columns: &row.columns,
                factor: &row.factor,
            })
            .collect();
        let unknowns = model.parameters().len();
        let x = match solve_quickly(&parts, unknowns) {
            Some(x) => x,
            None => solve(&parts, unknowns)?.x,
        };
        let left = |row: &LinkRow| {
            let values: Vec<f64> = row.columns.iter().map(|&column| x[column]).collect();
            row.factor.residual_length(&values)
        };
        Some(self.rows.iter().map(left).collect())
    }

    /// Returns the unexplained part of each right-hand side by its equation alone.
    pub(crate) fn each(&self) -> Vec<f64> {
        (self.rows.iter())
            .map(|row| alone(&row.factor).map_or(f64::NAN, |x| row.factor.residual_length(&x)))
            .collect()
    }

    /// Returns the unexplained part of each right-hand side by friction and rotor alone.
    pub(crate) fn without_bodies(&self, model: &Model) -> Vec<f64> {
        let left = |row: &LinkRow| {
            let reduced = row.reduced(model, None);
            alone(&reduced).map_or(f64::NAN, |x| reduced.residual_length(&x))
        };
        self.rows.iter().map(left).collect()
    }

    /// Compares each right-hand side with the torque of the nominal bodies.
    ///
    /// - `nominal`: values of the link parameters in theta, \[p\].
    pub(crate) fn scales(&self, model: &Model, nominal: &[f64]) -> Vec<BodyScale> {
        (self.rows.iter())
            .filter_map(|row| row.scale(model, nominal))
            .collect()
    }
}

impl BodyScale {
    /// Returns whether the log determines the scale.
    ///
    /// - `independent`: number of independent residuals.
    pub(crate) fn is_determined(&self, independent: f64) -> bool {
        let [without, with, free] = self.left.map(|left| left * left);
        self.scale > SCALE_SIGMAS * self.error / independent.sqrt()
            && without - with > MIN_EXPLAINED_BY_NOMINAL * (without - free)
    }
}

impl LinkRow {
    /// Returns the equation with the torque of given bodies as its last unknown column instead of one
    /// column for each link parameter; friction and rotor keep their columns.
    ///
    /// - `bodies`: values of the link parameters in theta, \[p\]; `None` for no bodies.
    fn reduced(&self, model: &Model, bodies: Option<&[f64]>) -> Triangle {
        let (m, factor) = (self.columns.len(), &self.factor);
        let is_body = |column: usize| model.parameters()[column].joint.is_none();
        let times = |i: usize, value: &dyn Fn(usize) -> f64| -> f64 {
            (0..m)
                .map(|j| factor.entry(i, j) * value(self.columns[j]))
                .sum()
        };
        let rotor = model.rotor_in_links(self.joint);
        let of_rotor = |column: usize| -> f64 {
            (rotor.iter().filter(|(other, _)| *other == column))
                .map(|(_, share)| share)
                .sum()
        };
        let frictions: Vec<usize> = (0..m).filter(|&j| !is_body(self.columns[j])).collect();
        let lines: Vec<Vec<f64>> = (0..=m)
            .map(|i| {
                let mut entries: Vec<f64> =
                    (frictions.iter()).map(|&j| factor.entry(i, j)).collect();
                if !rotor.is_empty() {
                    entries.push(times(i, &of_rotor));
                }
                if let Some(bodies) = bodies {
                    entries.push(times(i, &|column| bodies[column]));
                }
                entries.push(factor.entry(i, m));
                entries
            })
            .collect();
        Triangle::of_lines(&lines)
    }

    fn scale(&self, model: &Model, nominal: &[f64]) -> Option<BodyScale> {
        let reduced = self.reduced(model, Some(nominal));
        let unknowns: Vec<usize> = (0..reduced.unknowns()).collect();
        let part = SystemPart {
            columns: &unknowns,
            factor: &reduced,
        };
        let solution = solve(&[part], unknowns.len())?;
        let last = unknowns.len() - 1;
        let left = reduced.residual_length(&solution.x);
        let scale = solution.x[last];
        // This entry is the length of the last column without the part that the others explain.
        let without = left.hypot(reduced.entry(last, last) * scale);
        Some(BodyScale {
            joint: self.joint,
            scale,
            error: left * solution.inverse[(last, last)].max(0.0).sqrt(),
            left: [
                without,
                left,
                self.factor.residual_length(&alone(&self.factor)?),
            ],
        })
    }
}

/// Returns the least-squares solution of one equation.
fn alone(factor: &Triangle) -> Option<Vec<f64>> {
    let local: Vec<usize> = (0..factor.unknowns()).collect();
    let part = SystemPart {
        columns: &local,
        factor,
    };
    Some(solve(&[part], local.len())?.x)
}

fn is_of_spring(model: &Model, column: usize) -> bool {
    (model.parameters()[column].joint).is_some_and(|(kind, _)| kind.is_of_spring())
}
