//! Columns of nuisance parameters that a regression takes as known.

use sprung_core::drives::Term;
use sprung_core::friction::{Law, Shape};
use sprung_core::parameters::{JointParameter, Side};

use crate::model::Model;
use crate::regression::Probe;

/// Sharpness of a nuisance column of sharper friction relative to that of the model.
pub(super) const SHARPER: f64 = 2.0;

/// Sharpness of a nuisance column of blunter friction relative to that of the model.
pub(super) const BLUNTER: f64 = 0.5;

/// Returns the columns of Coulomb friction of another sharpness, one group for each side of a joint with Coulomb friction.
/// A group has one parameter.
///
/// - `terms`: of the rows; `ratio`: of the sharpness to that of the model.
pub(super) fn sharpness_columns(
    model: &Model,
    joint: usize,
    terms: &[Term],
    ratio: f64,
) -> Vec<Vec<Probe>> {
    let shape = Shape {
        sharpness: ratio * model.sharpness(joint),
        ..*model.shape(joint)
    };
    let of_side = |side: Side| {
        let kind = JointParameter::Friction(side, Law::Coulomb);
        model.index(kind, joint)?;
        let of_kind = (terms.iter()).filter(|term| term.joint == joint && term.what == kind);
        Some(of_kind.map(|term| Probe::Term(*term, shape)).collect())
    };
    [Side::Motor, Side::Link]
        .into_iter()
        .filter_map(of_side)
        .collect()
}
