//! Friction of which the logs show only the sum with a constant torque, because the joint moved in one direction.

use sprung_core::friction::Law;
use sprung_core::parameters::{JointParameter, Side};

use crate::estimate::result::EstimateResult;
use crate::finding::{Finding, Severity};
use crate::fit::fit_values;
use crate::model::Model;
use crate::regression::{System, Triangle};

/// Part of a constant torque's column that Coulomb friction must leave over if the logs are to tell both apart. A joint
/// that stands still for a ten thousandth of a log leaves as much.
const APART: f64 = 0.01;

/// A sum of two parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sum {
    /// The parameter that stands for the sum.
    kept: usize,
    /// The parameter that is zero.
    zero: usize,
    /// Whether the sum is a difference.
    is_difference: bool,
}

/// Coulomb friction and constant torques of the same joint and side that the logs do not tell apart.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::estimate) struct Sums(Vec<Sum>);

impl Sums {
    /// Finds them in the equations of all logs.
    pub(in crate::estimate) fn new(model: &Model, system: &System) -> Self {
        let Some(rows) = system.whole() else {
            return Self::default();
        };
        let is_open = |at: &usize| model.known(*at).is_none();
        let parameter = |side, law, joint| {
            model
                .index(JointParameter::Friction(side, law), joint)
                .filter(is_open)
        };
        let of_joint = |(side, joint): (Side, usize)| {
            let offset = parameter(side, Law::Offset, joint)?;
            let coulomb = [Law::Coulomb, Law::CoulombPositive, Law::CoulombNegative];
            let mut coulomb = coulomb
                .iter()
                .filter_map(|&law| parameter(side, law, joint));
            coulomb.find_map(|coulomb| {
                let is_difference = are_opposite(model, &rows, [coulomb, offset])?;
                let fitted = fit_values(&model.with_fixed(&[(offset, 0.0)]), system)?;
                // No friction is negative, but a sum with a constant torque may be.
                let (kept, zero) = if fitted[coulomb] < 0.0 {
                    (offset, coulomb)
                } else {
                    (coulomb, offset)
                };
                Some(Sum {
                    kept,
                    zero,
                    is_difference,
                })
            })
        };
        let joints = 0..model.joint_count();
        let places = joints.flat_map(|joint| [(Side::Link, joint), (Side::Motor, joint)]);
        Self(places.filter_map(of_joint).collect())
    }

    /// Returns the model in which one parameter stands for each sum; `None` without sums.
    pub(in crate::estimate) fn settled(&self, model: &Model) -> Option<Model> {
        let zeros: Vec<(usize, f64)> = self.0.iter().map(|sum| (sum.zero, 0.0)).collect();
        (!zeros.is_empty()).then(|| model.with_fixed(&zeros))
    }

    /// Writes the other parameter of each sum into a result.
    pub(in crate::estimate) fn complete(&self, result: &mut EstimateResult) {
        for sum in &self.0 {
            let zero = result.parameters[sum.zero].name.clone();
            result.parameters[sum.kept].sum_with = Some(format!("{} {zero}", self::sign(sum)));
        }
    }

    /// Returns a finding about each sum.
    pub(in crate::estimate) fn findings(&self, model: &Model) -> Vec<Finding> {
        let name = |at: usize| &model.parameters()[at].name;
        let about = |sum: &Sum| {
            let (kept, zero) = (name(sum.kept), name(sum.zero));
            let joint = model.parameters()[sum.kept].joint;
            let joint = joint.map_or("", |(_, joint)| model.joints()[joint].as_str());
            Finding::new(
                Severity::Info,
                "sum-only",
                format!(
                    "{joint} moved in one direction only, so the log shows the sum {kept} {} {zero}. The value of {kept} is \
                     this sum, and {zero} is zero; the other direction is not predicted",
                    self::sign(sum)
                ),
                &format!("for both values record a log in which {joint} reverses"),
            )
            .about([kept.clone(), zero.clone()])
        };
        self.0.iter().map(about).collect()
    }
}

fn sign(sum: &Sum) -> char {
    if sum.is_difference { '-' } else { '+' }
}

/// Returns whether two columns have opposite signs, if they are the same up to a factor in all rows that contain one of them.
fn are_opposite(model: &Model, rows: &[Triangle], parameters: [usize; 2]) -> Option<bool> {
    let mut common = None;
    for (row, factor) in rows.iter().enumerate() {
        let columns = model.row_columns(row);
        let place = |parameter: usize| columns.iter().position(|&column| column == parameter);
        let [first, second] = match parameters.map(place) {
            [None, None] => continue,
            [first, second] => [first?, second?],
        };
        let dot = |a: usize, b: usize| -> f64 {
            (0..=a.min(b))
                .map(|i| factor.entry(i, a) * factor.entry(i, b))
                .sum()
        };
        let cosine = dot(first, second) / (dot(first, first) * dot(second, second)).sqrt();
        let is_same = 1.0 - cosine * cosine < APART * APART;
        if !is_same || common.is_some_and(|common| common != (cosine < 0.0)) {
            return None;
        }
        common = Some(cosine < 0.0);
    }
    common
}
