//! Converts named values to the parameter vector, and checks whether a robot can have them.

use std::collections::BTreeMap;

use faer::{Mat, Side};
use sprung_core::linear::factor;
use sprung_core::parameters::JointParameter;
use sprung_core::robot::Values;
use sprung_core::spatial::BODY;

use super::links::OFFSET;
use super::parameter::{ModelError, Parameter};
use super::scratch::Scratch;
use super::{
    Model, Theta, TreeLinks, hysteresis_name, play_centre_name, play_name, presliding_name,
    sharpness_name, stribeck_name,
};

/// Link parameters in a message about a mass matrix.
const PARAMETERS_SHOWN: usize = 3;

impl Model {
    /// Returns the vector theta of named values.
    ///
    /// Values of single inertial parameters of the links are combined into the model's base
    /// parameters.
    ///
    /// # Errors
    ///
    /// [`ModelError::UnknownParameter`] for an unknown name, [`ModelError::Missing`] if a parameter
    /// has no value.
    pub fn theta(&self, values: &BTreeMap<String, f64>) -> Result<Theta, ModelError> {
        self.check_names(values)?;
        let links = self.fixed.links.as_ref();
        self.collect(|at, parameter| {
            let is_offset = matches!(parameter.joint, Some((JointParameter::TorqueOffset, _)));
            let given = values.get(&parameter.name).copied().or(parameter.fixed);
            // The offset of a sensor is not a property of the robot.
            let given = given.or(is_offset.then_some(0.0));
            given.or_else(|| {
                let links = links?;
                let n = self.joint_count();
                let index = match parameter.joint {
                    None => links.selected[at],
                    Some((JointParameter::RotorInertia, joint)) => n * BODY + joint,
                    Some((OFFSET, joint)) => links.combined_offset(joint)?,
                    Some(_) => return None,
                };
                links.lumped(index, |k| {
                    (values.get(links.name(k)).copied()).or(links.known.get(&k).copied())
                })
            })
        })
    }

    /// Returns the change of theta, \[p\], for a unit change of a standard parameter of a link in a
    /// tree; zeros for the paper's arm.
    ///
    /// - `standard`: index of the parameter among the links' inertial parameters.
    #[must_use]
    pub fn change_by_standard(&self, standard: usize) -> Theta {
        let n = self.joint_count();
        let unit = |k: usize| Some(f64::from(u8::from(k == standard)));
        let of = |links: &TreeLinks, at: usize, parameter: &Parameter| match parameter.joint {
            None => links.lumped(links.selected[at], unit),
            Some((JointParameter::RotorInertia, joint)) => links.lumped(n * BODY + joint, unit),
            Some(_) => None,
        };
        let links = self.fixed.links.as_ref();
        (self.parameters().iter().enumerate())
            .map(|(at, parameter)| links.and_then(|l| of(l, at, parameter)).unwrap_or(0.0))
            .collect()
    }

    /// Checks that every name is the name of a parameter.
    ///
    /// # Errors
    ///
    /// [`ModelError::UnknownParameter`] for the first unknown name.
    pub fn check_names(&self, values: &BTreeMap<String, f64>) -> Result<(), ModelError> {
        for name in values.keys() {
            let links = self.fixed.links.as_ref();
            let standard = links.is_some_and(|links| links.index_of(name).is_some());
            let shape = (self.joints().iter())
                .flat_map(|joint| {
                    [
                        stribeck_name(joint),
                        presliding_name(joint),
                        hysteresis_name(joint),
                        play_name(joint),
                        play_centre_name(joint),
                        sharpness_name(joint),
                    ]
                })
                .any(|known| *name == known);
            if !standard && !shape {
                self.index_of(name)?;
            }
        }
        Ok(())
    }

    /// Returns the vector theta of the nominal values; friction without a nominal value is zero.
    ///
    /// # Errors
    ///
    /// [`ModelError::Missing`] if an inertia or a stiffness has no value.
    pub fn nominal(&self) -> Result<Theta, ModelError> {
        self.collect(|_, parameter| (parameter.nominal).or(parameter.may_be_zero().then_some(0.0)))
    }

    fn collect(
        &self,
        value: impl Fn(usize, &Parameter) -> Option<f64>,
    ) -> Result<Theta, ModelError> {
        let mut theta = Vec::with_capacity(self.parameters().len());
        let mut names = Vec::new();
        for (at, parameter) in self.parameters().iter().enumerate() {
            theta.push(value(at, parameter).unwrap_or_else(|| {
                names.push(parameter.short().into_owned());
                f64::NAN
            }));
        }
        if names.is_empty() {
            Ok(theta)
        } else {
            Err(ModelError::Missing { names })
        }
    }

    /// Checks that all stiffnesses are positive, because a feedforward divides by them.
    ///
    /// # Errors
    ///
    /// [`ModelError::NotPositive`] if a stiffness is zero or below.
    pub fn check_stiffness(&self, theta: &[f64]) -> Result<(), ModelError> {
        self.check_positive(JointParameter::Stiffness, theta)
    }

    fn check_positive(&self, kind: JointParameter, theta: &[f64]) -> Result<(), ModelError> {
        for (value, parameter) in theta.iter().zip(self.parameters()) {
            let wanted =
                (parameter.joint).is_some_and(|(other, i)| other == kind && self.is_flexible(i));
            if wanted && (value.is_nan() || *value <= 0.0) {
                return Err(ModelError::NotPositive {
                    name: parameter.name.clone(),
                    value: *value,
                    unit: parameter.unit,
                });
            }
        }
        Ok(())
    }

    /// Checks that the inertias are physical, so that a simulation is possible.
    ///
    /// # Errors
    ///
    /// [`ModelError::NotPositive`] for a rotor inertia, [`ModelError::MassMatrix`] if the mass
    /// matrix is not positive definite.
    pub fn check_inertias(&self, theta: &[f64]) -> Result<(), ModelError> {
        self.check_positive(JointParameter::RotorInertia, theta)?;
        let n = self.joint_count();
        let (robot, bodies) = (self.robot(), self.bodies(theta));
        let values = Values {
            theta,
            bodies: &bodies,
        };
        let mut scratch = Scratch::new(n);
        let rows = self.coordinates();
        let mut matrix = vec![0.0; rows * rows];
        for pose in poses(n) {
            let mut workspace = scratch.workspace();
            robot
                .mass_matrix(&values, &pose, &mut workspace, &mut matrix)
                .map_err(ModelError::Length)?;
            if !factor(&mut matrix, rows) {
                return Err(self.mass_matrix_error(theta, &pose));
            }
        }
        Ok(())
    }

    /// Returns the least inertia of the robot, as an eigenvalue of the mass matrix over many poses,
    /// and its standard error for independent errors of the parameters, kg·m² (kg).
    ///
    /// - `errors`: standard errors, \[p\]; infinite if unknown.
    #[must_use]
    pub fn least_inertia(&self, theta: &[f64], errors: &[f64]) -> Option<(f64, f64)> {
        let rows = self.coordinates();
        let matrix = |theta: &[f64], pose: &[f64]| -> Option<Mat<f64>> {
            let bodies = self.bodies(theta);
            let mut scratch = Scratch::new(self.joint_count());
            let mut matrix = vec![0.0; rows * rows];
            let values = Values {
                theta,
                bodies: &bodies,
            };
            let robot = self.robot();
            robot
                .mass_matrix(&values, pose, &mut scratch.workspace(), &mut matrix)
                .ok()?;
            Some(Mat::from_fn(rows, rows, |i, j| matrix[i * rows + j]))
        };
        let mut least: Option<(f64, Vec<f64>, Vec<f64>)> = None;
        for pose in poses(self.joint_count()) {
            let eigen = matrix(theta, &pose)?.self_adjoint_eigen(Side::Lower).ok()?;
            let value = eigen.S()[0];
            if least.as_ref().is_none_or(|(before, ..)| value < *before) {
                let direction = (0..rows).map(|i| eigen.U()[(i, 0)]).collect();
                least = Some((value, pose, direction));
            }
        }
        let (value, pose, direction) = least?;
        // The mass matrix is linear in the parameters.
        let mut variance = 0.0;
        for (i, error) in errors.iter().enumerate().filter(|(_, error)| **error > 0.0) {
            let mut unit = vec![0.0; theta.len()];
            unit[i] = 1.0;
            let matrix = matrix(&unit, &pose)?;
            let slope: f64 = (0..rows)
                .flat_map(|i| (0..rows).map(move |j| (i, j)))
                .map(|(i, j)| direction[i] * matrix[(i, j)] * direction[j])
                .sum();
            if slope != 0.0 {
                variance += (slope * error).powi(2);
            }
        }
        Some((value, variance.sqrt()))
    }

    fn mass_matrix_error(&self, theta: &[f64], pose: &[f64]) -> ModelError {
        let shown: Vec<String> = (theta.iter().zip(self.parameters()))
            .filter(|(_, p)| p.joint.is_none())
            .take(PARAMETERS_SHOWN)
            .map(|(value, p)| format!("{} = {value:.4e} {}", p.short(), p.unit))
            .collect();
        let shown = match &shown[..] {
            [] => "all zero".to_owned(),
            shown => shown.join(", "),
        };
        let more = match &self.fixed.links {
            Some(links) if links.selected.len() > PARAMETERS_SHOWN => ", …",
            _ => "",
        };
        let angles: Vec<String> = pose.iter().map(|q| format!("{q:.2}")).collect();
        ModelError::MassMatrix {
            values: shown + more,
            pose: format!(" at q = [{}]", angles.join(", ")),
        }
    }
}

/// Poses at which the mass matrix is checked: all joints at zero, each joint at π, and many other
/// poses.
fn poses(n: usize) -> impl Iterator<Item = Vec<f64>> {
    const OTHER_POSES: usize = 64;
    let turned = (0..n).map(move |i| {
        let mut pose = vec![0.0; n];
        pose[i] = std::f64::consts::PI;
        pose
    });
    // Multiples of the golden ratio distribute each joint's angles evenly and independently.
    let spread = (1..=OTHER_POSES).map(move |k| {
        (0..n)
            .map(|i| {
                let part = (k as f64 * 0.618_033_988_749_895 * (1.0 + i as f64 * 0.37)).fract();
                std::f64::consts::TAU * part
            })
            .collect()
    });
    std::iter::once(vec![0.0; n]).chain(turned).chain(spread)
}
