//! Columns of nuisance parameters that a regression takes as known.

use sprung_core::drives::Term;
use sprung_core::friction::{Law, Shape};
use sprung_core::parameters::{JointParameter, Side};

use crate::model::Model;
use crate::regression::Probe;

/// Sharpness of a nuisance column of sharper friction relative to that of the model.
pub(super) const SHARPER: f64 = 2.0;

/// Column of Coulomb friction of another sharpness, of one side of a joint.
pub(super) struct SharpnessColumn {
    /// Index in theta of the Coulomb friction of this side.
    pub(super) friction: usize,
    /// Entries of the column in all rows.
    pub(super) probes: Vec<Probe>,
}

/// Returns the columns of Coulomb friction of another sharpness, one for each side of a joint with Coulomb friction.
///
/// The friction at high velocities is the sum of a column's coefficient and of the parameter.
///
/// - `terms`: of the rows; `ratio`: of the sharpness to that of the model.
pub(super) fn sharpness_columns(
    model: &Model,
    joint: usize,
    terms: &[Term],
    ratio: f64,
) -> Vec<SharpnessColumn> {
    let shape = Shape {
        sharpness: ratio * model.sharpness(joint),
        ..*model.shape(joint)
    };
    let of_side = |side: Side| {
        let kind = JointParameter::Friction(side, Law::Coulomb);
        let friction = model.index(kind, joint)?;
        let of_kind = (terms.iter()).filter(|term| term.joint == joint && term.what == kind);
        let probes = of_kind.map(|term| Probe::Term(*term, shape)).collect();
        Some(SharpnessColumn { friction, probes })
    };
    [Side::Motor, Side::Link]
        .into_iter()
        .filter_map(of_side)
        .collect()
}
