//! Distance of inertial parameters from those of the nearest possible bodies.
//!
//! A body is possible if its mass is positive and if its density nowhere needs to be negative: the
//! second moments of its mass, with the first moments and the mass, form a positive definite matrix.
//!
//! ```text
//! J = [ ½ tr(I) 1 − I   h ]
//!     [ hᵀ              m ]  ≻ 0
//! ```
//!
//! The distance is the root of the least sum of squared differences between the parameters and those of
//! possible bodies, in standard errors. A barrier method finds it: Newton steps minimise
//! `½ |z|² − μ Σ (log det J − tr J / s)`, with μ falling to almost zero and a size s of the bodies
//! that keeps parameters finite which no equation determines.
//!
//! # Source
//!
//! Wensing, Kim and Slotine, "Linear matrix inequalities for physically consistent inertial parameter
//! identification", IEEE Robotics and Automation Letters, 2018. Boyd and Vandenberghe, "Convex
//! optimization", chapter 11.

use sprung_core::linear::{factor, solve};
use sprung_core::spatial::BODY;

use super::Model;

/// First and last value of μ, and its factor from stage to stage. The square of the distance is
/// exact to twice the last value per row of every J.
const LAST_BARRIER: f64 = 0.01;
const BARRIER_STEP: f64 = 0.15;

/// Maximum number of Newton steps per stage; a stage ends when a step would lower the function by less
/// than this multiple of μ.
const MAX_STEPS: usize = 50;
const SMALL_DECREASE: f64 = 1e-2;

/// Part of the expected decrease that a step must reach, and smallest step.
const SUFFICIENT: f64 = 0.1;
const SMALLEST_STEP: f64 = 1e-10;

/// Rows of J.
const ROWS: usize = 4;

/// Entries of J that each inertial parameter of a body changes: row, column, factor. J is symmetric.
const ENTRIES: [&[(usize, usize, f64)]; BODY] = [
    &[(3, 3, 1.0)],
    &[(0, 3, 1.0)],
    &[(1, 3, 1.0)],
    &[(2, 3, 1.0)],
    &[(0, 0, -0.5), (1, 1, 0.5), (2, 2, 0.5)],
    &[(0, 1, -1.0)],
    &[(0, 0, 0.5), (1, 1, -0.5), (2, 2, 0.5)],
    &[(0, 2, -1.0)],
    &[(1, 2, -1.0)],
    &[(0, 0, 0.5), (1, 1, 0.5), (2, 2, -0.5)],
];

impl Model {
    /// Returns the distance of the links' parameters from those of the nearest possible bodies, in
    /// standard errors; `None` if the robot is no tree, no parameter has a standard error, or the
    /// search fails.
    ///
    /// - `theta`: parameters, \[p\].
    /// - `errors`: standard errors, \[p\]. Parameters whose error is zero or infinite do not count.
    #[must_use]
    pub(crate) fn distance_from_bodies(&self, theta: &[f64], errors: &[f64]) -> Option<f64> {
        Problem::new(self, theta, errors)?.distance()
    }
}

/// Equations `A x = b` of the bodies' parameters x, in standard errors.
struct Problem {
    /// Number of bodies; x has their parameters, then the rotor inertias.
    bodies: usize,
    unknowns: usize,
    /// One equation per parameter of theta, \[unknowns\] each, and its right-hand side.
    equations: Vec<(Vec<f64>, f64)>,
    /// Size of the bodies, kg·m².
    size: f64,
}

/// Value of the function with its derivatives.
struct Point {
    value: f64,
    gradient: Vec<f64>,
    /// \[unknowns × unknowns\].
    hessian: Vec<f64>,
}

impl Problem {
    fn new(model: &Model, theta: &[f64], errors: &[f64]) -> Option<Self> {
        let unknowns = model.links()?.standard();
        let columns: Vec<Vec<f64>> = (0..unknowns)
            .map(|index| model.change_by_standard(index))
            .collect();
        let mut size = 1e-3_f64;
        let mut equations = Vec::new();
        for (i, (value, error)) in theta.iter().zip(errors).enumerate() {
            let row: Vec<f64> = columns.iter().map(|column| column[i] / error).collect();
            let counts = *error > 0.0 && error.is_finite() && value.is_finite();
            if counts && row.iter().any(|entry| *entry != 0.0) {
                size = size.max(value.abs());
                equations.push((row, value / error));
            }
        }
        (!equations.is_empty()).then_some(Self {
            bodies: model.joint_count(),
            unknowns,
            equations,
            size,
        })
    }

    fn distance(&self) -> Option<f64> {
        let mut x = vec![0.0; self.unknowns];
        for body in x[..self.bodies * BODY].chunks_mut(BODY) {
            for k in [0, 4, 6, 9] {
                body[k] = self.size;
            }
        }
        x[self.bodies * BODY..].fill(self.size);
        let mut barrier = f64::max(1.0, 0.1 * self.squares(&x));
        loop {
            for _ in 0..MAX_STEPS {
                if !self.step(&mut x, barrier)? {
                    break;
                }
            }
            if barrier < LAST_BARRIER {
                break;
            }
            barrier *= BARRIER_STEP;
        }
        Some(self.squares(&x).sqrt()).filter(|distance| distance.is_finite())
    }

    /// Makes a Newton step. Returns whether another one is worth its while, `None` if there is no step.
    fn step(&self, x: &mut [f64], barrier: f64) -> Option<bool> {
        let n = self.unknowns;
        let here = self.point(x, barrier)?;
        let scale: Vec<f64> = (0..n)
            .map(|i| here.hessian[i * (n + 1)].sqrt().recip())
            .collect();
        let mut factors: Vec<f64> = (0..n * n)
            .map(|at| here.hessian[at] * scale[at / n] * scale[at % n])
            .collect();
        if !factor(&mut factors, n) {
            return None;
        }
        let mut by: Vec<f64> = (here.gradient.iter().zip(&scale))
            .map(|(own, scale)| -own * scale)
            .collect();
        solve(&factors, &mut by);
        let mut decrease = 0.0;
        for ((by, scale), own) in by.iter_mut().zip(&scale).zip(&here.gradient) {
            *by *= scale;
            decrease -= own * *by;
        }
        if decrease.is_nan() {
            return None;
        }
        if decrease < SMALL_DECREASE * barrier {
            return Some(false);
        }
        let mut length = 1.0;
        while length > SMALLEST_STEP {
            let there: Vec<f64> = x.iter().zip(&by).map(|(x, by)| x + length * by).collect();
            let value = self.value(&there, barrier);
            if value.is_some_and(|value| value <= here.value - SUFFICIENT * length * decrease) {
                x.copy_from_slice(&there);
                return Some(true);
            }
            length *= 0.5;
        }
        Some(false)
    }

    fn squares(&self, x: &[f64]) -> f64 {
        (self.equations.iter())
            .map(|(row, right)| (dot(row, x) - right).powi(2))
            .sum()
    }

    /// Returns the value of the function; `None` for impossible bodies.
    fn value(&self, x: &[f64], barrier: f64) -> Option<f64> {
        let (bodies, rotors) = x.split_at(self.bodies * BODY);
        let mut sum = 0.0;
        for body in bodies.chunks(BODY) {
            let (log, _) = inverse(&moments(body))?;
            sum += log - trace(body) / self.size;
        }
        for rotor in rotors {
            if *rotor <= 0.0 {
                return None;
            }
            sum += rotor.ln() - rotor / self.size;
        }
        Some(0.5 * self.squares(x) - barrier * sum)
    }

    fn point(&self, x: &[f64], barrier: f64) -> Option<Point> {
        let n = self.unknowns;
        let mut gradient = vec![0.0; n];
        let mut hessian = vec![0.0; n * n];
        for (row, right) in &self.equations {
            let missed = dot(row, x) - right;
            for (i, own) in row.iter().enumerate().filter(|(_, own)| **own != 0.0) {
                gradient[i] += own * missed;
                for (j, other) in row.iter().enumerate() {
                    hessian[i * n + j] += own * other;
                }
            }
        }
        let (bodies, rotors) = x.split_at(self.bodies * BODY);
        for (at, body) in bodies.chunks(BODY).enumerate() {
            let (_, inverse) = inverse(&moments(body))?;
            let slopes: Vec<[f64; ROWS * ROWS]> = (ENTRIES.iter())
                .map(|entries| product(&inverse, entries))
                .collect();
            for (i, own) in slopes.iter().enumerate() {
                let diagonal: f64 = (0..ROWS).map(|k| own[k * (ROWS + 1)]).sum();
                gradient[at * BODY + i] -= barrier * (diagonal - of_trace(i) / self.size);
                for (j, other) in slopes.iter().enumerate() {
                    let both = (0..ROWS * ROWS).map(|k| own[k] * other[k % ROWS * ROWS + k / ROWS]);
                    hessian[(at * BODY + i) * n + at * BODY + j] += barrier * both.sum::<f64>();
                }
            }
        }
        for (i, rotor) in rotors.iter().enumerate() {
            let at = self.bodies * BODY + i;
            gradient[at] -= barrier * (rotor.recip() - self.size.recip());
            hessian[at * (n + 1)] += barrier / rotor.powi(2);
        }
        Some(Point {
            value: self.value(x, barrier)?,
            gradient,
            hessian,
        })
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Returns J of a body, row by row.
fn moments(body: &[f64]) -> [f64; ROWS * ROWS] {
    let mut moments = [0.0; ROWS * ROWS];
    for (value, entries) in body.iter().zip(ENTRIES) {
        for &(row, column, by) in entries {
            moments[row * ROWS + column] += by * value;
            if row != column {
                moments[column * ROWS + row] += by * value;
            }
        }
    }
    moments
}

/// Returns the trace of J.
fn trace(body: &[f64]) -> f64 {
    (0..BODY).map(|k| of_trace(k) * body[k]).sum()
}

/// Returns the change of the trace of J by a unit of a parameter.
fn of_trace(parameter: usize) -> f64 {
    (ENTRIES[parameter].iter())
        .filter(|(row, column, _)| row == column)
        .map(|(.., by)| by)
        .sum()
}

/// Returns the logarithm of the determinant of J and its inverse; `None` if J is not positive
/// definite.
fn inverse(moments: &[f64; ROWS * ROWS]) -> Option<(f64, [f64; ROWS * ROWS])> {
    let mut factors = *moments;
    if !factor(&mut factors, ROWS) {
        return None;
    }
    let log = -(0..ROWS).map(|k| factors[k * (ROWS + 1)].ln()).sum::<f64>();
    let mut inverse = [0.0; ROWS * ROWS];
    for (k, column) in inverse.chunks_mut(ROWS).enumerate() {
        column[k] = 1.0;
        solve(&factors, column);
    }
    Some((log, inverse))
}

/// Returns the product of a matrix and a symmetric matrix with few entries.
fn product(left: &[f64; ROWS * ROWS], entries: &[(usize, usize, f64)]) -> [f64; ROWS * ROWS] {
    let mut product = [0.0; ROWS * ROWS];
    for &(row, column, by) in entries {
        for i in 0..ROWS {
            product[i * ROWS + column] += by * left[i * ROWS + row];
            if row != column {
                product[i * ROWS + row] += by * left[i * ROWS + column];
            }
        }
    }
    product
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
