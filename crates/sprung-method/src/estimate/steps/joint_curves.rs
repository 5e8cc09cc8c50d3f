//! Friction against velocity and spring torque against deflection, sample by sample: the model, and the part of the
//! measured torque that remains for it.

use sprung_core::chain::JointKind;
use sprung_core::friction::Law;
use sprung_core::parameters::{JointParameter, Side};

use crate::estimate::result::EstimateResult;
use crate::estimate::statistics::NORMAL_95;
use crate::model::Model;
use crate::regression::System;

/// A column of the curves with its values by one estimate.
pub(super) struct JointCurve {
    /// Name with the unit.
    pub(super) name: String,
    pub(super) values: Vec<Option<f64>>,
}

/// Returns the curves of all joints whose friction has a viscous part, and of all springs. All of them belong to the rows
/// of the motors' torques.
///
/// - `theta`: the estimate, \[p\]; `result`: the same with its covariance.
pub(super) fn joint_curves(
    model: &Model,
    theta: &[f64],
    result: &EstimateResult,
    system: &System,
) -> Vec<JointCurve> {
    let errors = Errors::of(model, result);
    (0..model.joint_count())
        .flat_map(|joint| {
            let row = Row::new(model, joint, theta, system);
            let mut curves = row.friction(&errors);
            curves.extend(row.spring());
            curves
        })
        .collect()
}

/// The row of a motor's torque.
struct Row<'a> {
    model: &'a Model,
    joint: usize,
    theta: &'a [f64],
    samples: &'a [Vec<f64>],
    /// Entries of the joint's link row, for the sign of the deflection.
    link: &'a [Vec<f64>],
}

impl<'a> Row<'a> {
    fn new(model: &'a Model, joint: usize, theta: &'a [f64], system: &'a System) -> Self {
        let rows = &system.kept().rows;
        let of = |row: usize| rows.get(row).map_or(&[][..], Vec::as_slice);
        Self {
            model,
            joint,
            theta,
            samples: of(model.torque_row(joint)),
            link: of(joint),
        }
    }

    /// Returns the place of a parameter of the joint in the samples, and its index in theta.
    fn place(&self, kind: JointParameter) -> Option<(usize, usize)> {
        let column = self.model.index(kind, self.joint)?;
        let columns = self.model.row_columns(self.model.torque_row(self.joint));
        Some((columns.iter().position(|&other| other == column)?, column))
    }

    fn places(&self, is_wanted: impl Fn(JointParameter) -> bool) -> Vec<(usize, usize)> {
        let kinds = JointParameter::ALL
            .into_iter()
            .filter(|kind| is_wanted(*kind));
        kinds.filter_map(|kind| self.place(kind)).collect()
    }

    /// Returns the measured torque minus that of the model at each sample.
    fn residual(&self, sample: &[f64]) -> f64 {
        let columns = self.model.row_columns(self.model.torque_row(self.joint));
        let fitted: f64 = (columns.iter().zip(sample))
            .map(|(&column, entry)| self.theta[column] * entry)
            .sum();
        sample.last().copied().unwrap_or_default() - fitted
    }

    fn of(&self, places: &[(usize, usize)], sample: &[f64]) -> f64 {
        let terms = places
            .iter()
            .map(|&(place, column)| self.theta[column] * sample[place]);
        terms.sum()
    }

    fn curve(&self, what: &str, unit: &str, of: impl Fn(&[f64]) -> Option<f64>) -> JointCurve {
        let joint = &self.model.joints()[self.joint];
        JointCurve {
            name: format!("{joint}.{what}_{unit}"),
            values: self.samples.iter().map(|sample| of(sample)).collect(),
        }
    }

    fn units(&self) -> [&'static str; 2] {
        match self.model.kind(self.joint) {
            JointKind::Revolute => ["nm", "rad_per_s"],
            JointKind::Prismatic => ["n", "m_per_s"],
        }
    }

    /// Returns the curves of the motor's friction; none without viscous friction, whose entry is the velocity.
    fn friction(&self, errors: &Errors) -> Vec<JointCurve> {
        let viscous = JointParameter::Friction(Side::Motor, Law::Viscous);
        let Some((velocity, _)) = self.place(viscous) else {
            return Vec::new();
        };
        let places = self.places(|kind| matches!(kind, JointParameter::Friction(Side::Motor, _)));
        let [torque, speed] = self.units();
        let half_width = |sample: &[f64]| {
            let entries: Vec<(usize, f64)> = (places.iter())
                .map(|&(place, column)| (column, sample[place]))
                .collect();
            errors.half_width(&entries)
        };
        vec![
            self.curve("friction_velocity", speed, |sample| Some(sample[velocity])),
            self.curve("friction", torque, |sample| Some(self.of(&places, sample))),
            self.curve("friction_measured", torque, |sample| {
                Some(self.of(&places, sample) + self.residual(sample))
            }),
            self.curve("friction_half_width", torque, half_width),
        ]
    }

    /// Returns the curves of the spring's torque; none for a rigid joint. Their sign is that of the deflection.
    fn spring(&self) -> Vec<JointCurve> {
        let stiffness = self.place(JointParameter::Stiffness);
        let Some((place, column)) = stiffness.filter(|_| self.model.is_flexible(self.joint)) else {
            return Vec::new();
        };
        let columns = self.model.row_columns(self.joint);
        let Some(of_link) = columns.iter().position(|&other| other == column) else {
            return Vec::new();
        };
        let alike: f64 = (self.samples.iter().zip(self.link))
            .map(|(motor, link)| motor[place] * link[of_link])
            .sum();
        let sign = if alike < 0.0 { -1.0 } else { 1.0 };
        let places = self.places(|kind| {
            matches!(
                kind,
                JointParameter::Stiffness
                    | JointParameter::CubicStiffness
                    | JointParameter::Damping
                    | JointParameter::Hysteresis(_)
                    | JointParameter::Preload
            )
        });
        let [torque, _] = self.units();
        vec![
            self.curve("spring", torque, |sample| {
                Some(sign * self.of(&places, sample))
            }),
            self.curve("spring_measured", torque, |sample| {
                Some(sign * (self.of(&places, sample) + self.residual(sample)))
            }),
        ]
    }
}

/// Covariance of the errors of an estimate, by the index in theta.
struct Errors {
    /// Row in the covariance of each parameter; `None` for a parameter without error.
    rows: Vec<Option<usize>>,
    covariance: Vec<Vec<f64>>,
    /// Standard error of each parameter.
    alone: Vec<Option<f64>>,
}

impl Errors {
    fn of(model: &Model, result: &EstimateResult) -> Self {
        let covariance = result.covariance.as_ref();
        let row = |name: &str| {
            covariance?
                .parameters
                .iter()
                .position(|known| known == name)
        };
        let names = || {
            model
                .parameters()
                .iter()
                .map(|parameter| parameter.name.as_str())
        };
        let error = |name: &str| {
            let found = result
                .parameters
                .iter()
                .find(|parameter| parameter.name == name)?;
            if found.fixed {
                Some(0.0)
            } else {
                found.standard_error
            }
        };
        Self {
            rows: names().map(row).collect(),
            covariance: covariance.map_or_else(Vec::new, |covariance| covariance.values.clone()),
            alone: names().map(error).collect(),
        }
    }

    fn covariance(&self, one: usize, other: usize) -> Option<f64> {
        match (self.rows[one], self.rows[other]) {
            (Some(i), Some(j)) => self.covariance.get(i.max(j))?.get(i.min(j)).copied(),
            _ if one == other => Some(self.alone[one]?.powi(2)),
            _ => Some(0.0),
        }
    }

    /// Returns half the width of the 95 % interval of a sum of parameters; `None` if one of them has no error.
    ///
    /// - `entries`: index in theta and coefficient of each.
    fn half_width(&self, entries: &[(usize, f64)]) -> Option<f64> {
        let mut variance = 0.0;
        for &(one, a) in entries {
            for &(other, b) in entries {
                variance += a * b * self.covariance(one, other)?;
            }
        }
        (variance >= 0.0).then(|| NORMAL_95 * variance.sqrt())
    }
}
