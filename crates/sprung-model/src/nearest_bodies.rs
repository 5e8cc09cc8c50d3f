//! Distance of inertial parameters from those of the nearest possible bodies.
//!
//! The distance is the root of the least sum of squared differences between the parameters and those of
//! possible bodies ([`super::second_moments`]), in standard errors.

use sprung_core::spatial::BODY;

use super::Model;
use super::convex::{Block, Program};
use super::second_moments::second_moments;

/// Largest difference of half the squared distance from the least one.
const GAP: f64 = 0.1;

impl Model {
    /// Returns the distance of the links' parameters from those of the nearest possible bodies, in
    /// standard errors; `None` if the robot is no tree, no parameter has a standard error, or the
    /// search fails.
    ///
    /// - `theta`: parameters, \[p\].
    /// - `errors`: standard errors, \[p\]. Parameters whose error is zero or infinite do not count.
    #[must_use]
    pub fn distance_from_bodies(&self, theta: &[f64], errors: &[f64]) -> Option<f64> {
        let unknowns = self.links()?.standard();
        let bodies = self.joint_count() * BODY;
        let columns: Vec<Vec<f64>> = (0..unknowns)
            .map(|index| self.change_by_standard(index))
            .collect();
        let mut size = 1e-3_f64;
        // One equation per parameter of theta, in standard errors.
        let mut equations: Vec<(Vec<f64>, f64)> = Vec::new();
        for (i, (value, error)) in theta.iter().zip(errors).enumerate() {
            let row: Vec<f64> = columns.iter().map(|column| column[i] / error).collect();
            let counts = *error > 0.0 && error.is_finite() && value.is_finite();
            if counts && row.iter().any(|entry| *entry != 0.0) {
                size = size.max(value.abs());
                equations.push((row, value / error));
            }
        }
        if equations.is_empty() {
            return None;
        }
        let mut program = Program {
            quadratic: vec![0.0; unknowns * unknowns],
            linear: vec![0.0; unknowns],
            blocks: (0..bodies)
                .step_by(BODY)
                .map(|first| second_moments(|k| Ok(first + k)))
                .chain((bodies..unknowns).map(|rotor| Block::scalar(0.0, [(rotor, 1.0)])))
                .collect(),
        };
        for block in &mut program.blocks {
            block.size = size;
        }
        for (row, right) in &equations {
            for (i, entry) in row.iter().enumerate().filter(|(_, entry)| **entry != 0.0) {
                program.linear[i] += entry * right;
                for (j, other) in row.iter().enumerate() {
                    program.quadratic[i * unknowns + j] += entry * other;
                }
            }
        }
        let start: Vec<f64> = (0..unknowns)
            .map(|i| match i % BODY {
                1..=3 | 5 | 7 | 8 if i < bodies => 0.0,
                _ => size,
            })
            .collect();
        let x = program.minimise(&start, GAP).ok()?;
        let squares: f64 = (equations.iter())
            .map(|(row, right)| {
                let fitted: f64 = row.iter().zip(&x).map(|(a, b)| a * b).sum();
                (fitted - right).powi(2)
            })
            .sum();
        Some(squares.sqrt()).filter(|distance| distance.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::description::{no_files, read};

    fn arm() -> (Model, Vec<f64>) {
        let text = r#"
            format = 1
            [robot]
            name = "arm"
            dh_modified = [{}, { alpha_deg = 90.0, a_m = 0.3 }, { a_m = 0.4 }]
            [[robot.joint]]
            name = "a"
            [[robot.joint]]
            name = "b"
            [[robot.joint]]
            name = "c"
        "#;
        let experiment = read("arm", text, &[], &mut no_files).unwrap();
        let model = Model::new(&experiment).unwrap();
        // Rods of 2 kg with their masses at 0.15 m.
        let rod = [2.0, 0.3, 0.0, 0.0, 0.004, 0.0, 0.06, 0.0, 0.0, 0.06];
        let links = model.links().unwrap();
        let mut values: BTreeMap<String, f64> = (0..3 * BODY)
            .map(|index| (links.name(index).to_owned(), rod[index % BODY]))
            .collect();
        for parameter in model.parameters().iter().filter(|p| p.joint.is_some()) {
            values.insert(parameter.name.clone(), 0.1);
        }
        let theta = model.theta(&values).unwrap();
        (model, theta)
    }

    #[test]
    fn parameters_of_bodies_are_possible_and_a_negative_inertia_is_not() {
        let (model, mut theta) = arm();
        let errors = vec![1e-3; theta.len()];
        let distance = model.distance_from_bodies(&theta, &errors).unwrap();
        assert!(distance < 0.2, "{distance}");
        // Only positive inertias are possible, and other parameters do not help.
        let last = model.index_of("link3.izz").unwrap();
        theta[last] = -0.02;
        let distance = model.distance_from_bodies(&theta, &errors).unwrap();
        assert!(distance > 20.0, "{distance}");
        // A parameter without an error does not count.
        let mut unknown = errors;
        unknown[last] = f64::INFINITY;
        let distance = model.distance_from_bodies(&theta, &unknown).unwrap();
        assert!(distance < 0.2, "{distance}");
    }

    #[test]
    fn a_wheel_is_as_far_as_its_inertia_is_negative() {
        let text = "format = 1\n[robot]\nname = \"wheel\"\ndh_modified = [{}]\n[[robot.joint]]\nname = \"a\"\n";
        let experiment = read("wheel", text, &[], &mut no_files).unwrap();
        let model = Model::new(&experiment).unwrap();
        let theta: Vec<f64> = (model.parameters().iter())
            .map(|parameter| {
                if parameter.name == "link1.izz" {
                    -0.5
                } else {
                    1.0
                }
            })
            .collect();
        let distance = model.distance_from_bodies(&theta, &vec![0.1; theta.len()]);
        let distance = distance.unwrap();
        assert!((distance - 5.0).abs() < 0.1, "{distance}");
        let known = model.distance_from_bodies(&theta, &vec![0.0; theta.len()]);
        assert_eq!(known, None);
    }
}
