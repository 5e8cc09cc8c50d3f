//! A torque sensor in a joint as a sensor of the deflection.
//!
//! The measurement is the torque over a fixed stiffness `k_0`, so it has the unit of a position and
//! the constant entries of a deflection in H. The difference between its expectation and `H x` depends on
//! the state and the parameters:
//!
//! ```text
//! y = tau_s / k_0        expectation (k e + k_3 e³ + d ė − preload + offset) / k_0,   H x = e
//! ```

use sprung_core::covariate::Covariate;
use sprung_core::drives::{Drive, Term};
use sprung_core::parameters::JointParameter;

use crate::model::Model;

/// The torque of a joint's spring, over a fixed stiffness.
#[derive(Clone, Debug)]
pub(in super::super) struct SpringReading {
    /// Coordinates of link and motor.
    link: usize,
    motor: usize,
    /// `k_0`, N·m/rad (N/m).
    pub(super) stiffness: f64,
    /// Terms of the spring's torque and of the sensor.
    terms: Vec<Term>,
    model: Model,
}

/// A state, and the time of a measurement before it.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct StateAt<'s> {
    /// \[3 rows\] or \[2 rows\].
    pub(super) x: &'s [f64],
    /// Number of coordinates.
    pub(super) rows: usize,
    /// s.
    pub(super) age: f64,
}

impl SpringReading {
    /// - `stiffness`: N·m/rad (N/m).
    pub(super) fn new(model: &Model, joint: usize, stiffness: f64) -> Self {
        let of_reading =
            |kind: JointParameter| kind.is_of_spring() || kind == JointParameter::TorqueOffset;
        Self {
            link: joint,
            motor: model.robot().motor_coordinate(joint),
            stiffness,
            terms: (JointParameter::ALL
                .into_iter()
                .filter(|kind| of_reading(*kind)))
            .filter_map(|what| {
                Some(Term {
                    row: 0,
                    entry: 0,
                    column: model.index(what, joint)?,
                    what,
                    joint,
                    gain: 1.0,
                })
            })
            .collect(),
            model: model.clone(),
        }
    }

    /// Returns the same reading with the terms of another model.
    pub(super) fn of_model(&self, model: &Model) -> Self {
        Self::new(model, self.link, self.stiffness)
    }

    /// Returns coordinates and weights of the deflection.
    pub(super) fn coordinates(&self) -> Vec<(usize, f64)> {
        vec![(self.link, -1.0), (self.motor, 1.0)]
    }

    /// Returns deflection and its rate at the time of a measurement.
    ///
    fn drive(&self, at: &StateAt<'_>) -> Drive {
        let StateAt { x, rows, age } = *at;
        let deflection_rate = x[rows + self.motor] - x[rows + self.link];
        Drive {
            deflection: x[self.motor] - x[self.link] - age * deflection_rate,
            deflection_rate,
            link_velocity: x[rows + self.link],
            motor_velocity: x[rows + self.motor],
            excess: [0.0; Covariate::COUNT],
            elements: None,
        }
    }

    /// Returns the expectation minus `H x`, rad (m).
    ///
    /// - `value`: value of a parameter by its index in theta.
    pub(in super::super) fn beyond(&self, at: &StateAt<'_>, value: impl Fn(usize) -> f64) -> f64 {
        let drive = self.drive(at);
        let shape = self.model.shape(self.link);
        let torque: f64 = (self.terms.iter())
            .map(|term| value(term.column) * term.rest(&drive, shape))
            .sum();
        torque / self.stiffness - drive.deflection
    }

    /// Returns the derivatives of [`SpringReading::beyond`] by states, and visits those by parameters.
    pub(in super::super) fn slopes(
        &self,
        at: &StateAt<'_>,
        value: impl Fn(usize) -> f64,
        mut visit: impl FnMut(usize, f64),
    ) -> [(usize, f64); 4] {
        let drive = self.drive(at);
        let shape = self.model.shape(self.link);
        let (mut by_deflection, mut by_rate) = (0.0, 0.0);
        for term in &self.terms {
            visit(term.column, term.rest(&drive, shape) / self.stiffness);
            let slopes = term.slopes(&drive, shape);
            by_deflection += value(term.column) * slopes.deflection / self.stiffness;
            by_rate += value(term.column) * slopes.deflection_rate / self.stiffness;
        }
        let StateAt { rows, age, .. } = *at;
        by_deflection -= 1.0;
        by_rate -= age * by_deflection;
        [
            (self.link, -by_deflection),
            (self.motor, by_deflection),
            (rows + self.link, -by_rate),
            (rows + self.motor, by_rate),
        ]
    }
}
