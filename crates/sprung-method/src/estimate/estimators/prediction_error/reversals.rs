//! Nearness of each row's Coulomb friction to a reversal.
//!
//! The law tanh(β v) is wrong where friction reverses, so white noise of the torque may be larger
//! there. Away from reversals this noise vanishes, and the law explains the steady friction.

use sprung_core::friction::Conditions;
use sprung_core::parameters::{JointParameter, Side};

use crate::estimate::statistics::SATURATED_ARGUMENT;
use crate::model::Model;

/// The same as a share of the joint's root mean square velocity.
const REVERSAL_SHARE: f64 = 0.1;

/// Arbitrary conditions: a jump of the law does not depend on them.
const MOVING: Conditions = Conditions {
    velocity: 1.0,
    deflection: 1.0,
    presliding: Some([1.0; _]),
};

/// A velocity whose friction acts on a row.
#[derive(Clone, Debug, PartialEq)]
struct Reversal {
    /// Coordinates and their weights; their velocities add up to that of the friction.
    coordinates: Vec<(usize, f64)>,
    /// `1 / v_t`, s/rad (s/m).
    inverse_velocity: f64,
}

impl Reversal {
    /// Returns `exp(−(v/v_t)²)`, where v is the velocity at mid-step.
    fn weight(&self, before: &[f64], after: &[f64]) -> f64 {
        let parts = self.coordinates.iter();
        let velocity: f64 = (parts)
            .map(|&(at, weight)| 0.5 * weight * (before[at] + after[at]))
            .sum();
        (-(velocity * self.inverse_velocity).powi(2)).exp()
    }
}

/// The velocities whose Coulomb friction acts on each row.
#[derive(Clone, Debug, Default)]
pub(super) struct Reversals {
    rows: Vec<Vec<Reversal>>,
}

impl Reversals {
    /// - `speeds`: root mean square velocity of each joint, rad/s (m/s), \[n\].
    pub(super) fn new(model: &Model, speeds: &[f64]) -> Self {
        let robot = model.robot();
        let joints = robot.joints();
        let mut rows: Vec<Vec<Reversal>> = vec![Vec::new(); model.coordinates()];
        for term in robot.terms {
            let JointParameter::Friction(side, law) = term.what else {
                continue;
            };
            let shape = &robot.shapes[term.joint];
            // Only laws that jump at zero velocity reverse suddenly.
            if law.jump(&MOVING, shape).is_none() {
                continue;
            }
            let coordinates = match side {
                Side::Link => vec![(term.joint, 1.0)],
                Side::Motor => (0..joints)
                    .map(|joint| {
                        (
                            robot.motor_coordinate(joint),
                            robot.ratio(term.joint, joint),
                        )
                    })
                    .filter(|(_, ratio)| *ratio != 0.0)
                    .collect(),
            };
            let reversal = Reversal {
                coordinates,
                inverse_velocity: (SATURATED_ARGUMENT / shape.sharpness)
                    .max(REVERSAL_SHARE * speeds[term.joint])
                    .recip(),
            };
            if !rows[term.row].contains(&reversal) {
                rows[term.row].push(reversal);
            }
        }
        Self { rows }
    }

    /// Returns whether each row has Coulomb friction, \[rows\].
    pub(super) fn rows(&self) -> Vec<bool> {
        self.rows
            .iter()
            .map(|reversals| !reversals.is_empty())
            .collect()
    }

    /// Writes nearness of each row's friction to a reversal during a period: 1 at zero velocity, 0
    /// far from it, \[rows\]. Of several velocities the nearest one counts.
    ///
    /// - `before`, `after`: velocities of the coordinates at both ends of the period, \[rows\].
    pub(super) fn write(&self, before: &[f64], after: &[f64], weights: &mut [f64]) {
        for (weight, reversals) in weights.iter_mut().zip(&self.rows) {
            let each = reversals
                .iter()
                .map(|reversal| reversal.weight(before, after));
            *weight = each.fold(0.0, f64::max);
        }
    }
}
