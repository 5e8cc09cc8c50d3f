//! The search for the robot that fits a log best among those that can exist.

use faer::Mat;
use faer::linalg::solvers::Solve;

use super::robots::{Robots, must_be_positive};
use crate::estimate::statistics::ROUNDING;
use crate::model::{NoSolution, Program, Theta};

/// The robot that fits a log best among those that can exist.
pub(in crate::estimate) struct Possible {
    /// Unknowns of [`Robots`].
    pub(in crate::estimate) x: Vec<f64>,
    /// Parameters, \[p\].
    pub(in crate::estimate) theta: Theta,
    /// Second derivatives of the log's part of the function, \[unknowns × unknowns\].
    pub(in crate::estimate) of_log: Vec<f64>,
    /// Second derivatives of the whole function, \[unknowns × unknowns\].
    pub(in crate::estimate) of_all: Option<Vec<f64>>,
}

/// The squared residuals of a log as a program over the robots that can exist.
pub(super) struct Search {
    pub(super) program: Program,
    pub(super) start: Vec<f64>,
    /// Second derivatives of the log's part of the function, \[unknowns × unknowns\].
    of_log: Vec<f64>,
}

impl Robots<'_> {
    /// Returns the robot that minimises `½ θᵀ H θ − gᵀ θ`.
    ///
    /// - `information`: H, \[p × p\]; `gradient`: g, \[p\].
    /// - `near`: parameters near the minimum, \[p\].
    ///
    /// # Errors
    ///
    /// [`NoSolution`] if the given values and limits contradict each other.
    pub(in crate::estimate) fn best(
        &self,
        information: &Mat<f64>,
        gradient: &[f64],
        near: &[f64],
    ) -> Result<Possible, NoSolution> {
        let search = self.search(information, gradient, near);
        let x = search.program.minimise(&search.start, ROUNDING)?;
        Ok(Possible {
            theta: self.theta(&x),
            of_all: search.program.hessian(&x),
            of_log: search.of_log,
            x,
        })
    }

    /// Returns the robot that is nearest to parameters in a metric.
    ///
    /// - `information`: the metric, \[p × p\]; `theta`: parameters, \[p\].
    ///
    /// # Errors
    ///
    /// [`NoSolution`] as of [`Robots::best`].
    pub(in crate::estimate) fn nearest(
        &self,
        information: &Mat<f64>,
        theta: &[f64],
    ) -> Result<Possible, NoSolution> {
        self.best(information, &product(information, theta), theta)
    }

    /// Returns the robot with some parameters if one can exist, else the nearest one in a metric.
    ///
    /// - `information`: the metric, \[p × p\]; `theta`: parameters, \[p\].
    ///
    /// # Errors
    ///
    /// [`NoSolution`] as of [`Robots::best`].
    pub(in crate::estimate) fn robot_of(
        &self,
        information: &Mat<f64>,
        theta: &[f64],
    ) -> Result<Possible, NoSolution> {
        let search = self.search(information, &product(information, theta), theta);
        let nearest = search.program.minimise(&search.start, ROUNDING)?;
        let exact = self.reached(&search, &nearest, theta);
        let theta = match &exact {
            Some(_) => theta.to_vec(),
            None => self.theta(&nearest),
        };
        let x = exact.unwrap_or(nearest);
        Ok(Possible {
            theta,
            of_all: search.program.hessian(&x),
            of_log: search.of_log,
            x,
        })
    }

    /// Returns whether parameters are those of a robot that can exist and is in the middle of such robots, in a metric.
    /// Parameters near the border may be reported as outside.
    pub(in crate::estimate) fn contains(&self, information: &Mat<f64>, theta: &[f64]) -> bool {
        let search = self.search(information, &product(information, theta), theta);
        let middle = (search.program).minimise(&search.start, search.program.rows() as f64);
        middle.is_ok_and(|middle| self.reached(&search, &middle, theta).is_some())
    }

    /// Returns the robot with some parameters at the end of the shortest way from another robot; `None` if it cannot
    /// exist.
    ///
    /// - `x`: unknowns of the other robot. The second derivatives of the function with the barrier are the metric.
    fn reached(&self, search: &Search, x: &[f64], theta: &[f64]) -> Option<Vec<f64>> {
        let (n, p) = (self.columns.len(), self.constant.len());
        let hessian = search.program.hessian_with_barrier(x, 1.0)?;
        let start = self.theta(x);
        let scale: Vec<f64> = (0..n)
            .map(|i| hessian[i * (n + 1)].sqrt().recip())
            .collect();
        let scaled = Mat::from_fn(n, n, |i, j| hessian[i * n + j] * scale[i] * scale[j]);
        let factor = scaled.llt(faer::Side::Lower).ok()?;
        let right = Mat::from_fn(n, p, |i, j| scale[i] * self.columns[i][j]);
        let moves = factor.solve(&right);
        let product = right.transpose() * &moves;
        let moved = Mat::from_fn(p, 1, |i, _| theta[i] - start[i]);
        let by = &moves * product.lblt(faer::Side::Lower).solve(&moved);
        let end: Vec<f64> = (0..n).map(|i| x[i] + scale[i] * by[(i, 0)]).collect();
        let is_near = |(a, b): (&f64, &f64)| (a - b).abs() <= ROUNDING * (1.0 + b.abs());
        let is_there = self.theta(&end).iter().zip(theta).all(is_near);
        (is_there && search.program.is_inside(&end)).then_some(end)
    }

    /// Returns the program of [`Robots::best`].
    pub(super) fn search(&self, information: &Mat<f64>, gradient: &[f64], near: &[f64]) -> Search {
        let (n, p) = (self.columns.len(), self.constant.len());
        let t = Mat::from_fn(p, n, |i, j| self.columns[j][i]);
        let by = information * &t;
        let quadratic = t.transpose() * &by;
        let constant = Mat::from_fn(p, 1, |i, _| self.constant[i]);
        let rest = Mat::from_fn(p, 1, |i, _| gradient[i]) - information * &constant;
        let linear = t.transpose() * &rest;
        let of_log: Vec<f64> = (0..n * n)
            .map(|at| {
                let (i, j) = (at / n, at % n);
                f64::midpoint(quadratic[(i, j)], quadratic[(j, i)])
            })
            .collect();
        let mut program = self.prior.clone();
        for (entry, more) in program.quadratic.iter_mut().zip(&of_log) {
            *entry += more;
        }
        for (i, entry) in program.linear.iter_mut().enumerate() {
            *entry += linear[(i, 0)];
        }
        let mut start = self.start.clone();
        for (at, &index) in self.others.iter().enumerate() {
            let unknown = self.standard.len() + at;
            let diagonal = of_log[unknown * (n + 1)];
            let (ridge, scale) = if diagonal > 0.0 {
                (ROUNDING * diagonal, diagonal.sqrt().recip())
            } else {
                (ROUNDING, 1.0)
            };
            program.quadratic[unknown * (n + 1)] += ridge;
            program.linear[unknown] += ridge * near[index];
            start[unknown] = near[index];
            if must_be_positive(&self.model.parameters()[index]) {
                start[unknown] = near[index].max(1e-3 * scale);
            }
        }
        Search {
            program,
            start,
            of_log,
        }
    }
}

/// Returns the product of a matrix and a vector.
pub(super) fn product(matrix: &Mat<f64>, vector: &[f64]) -> Vec<f64> {
    let column = Mat::from_fn(vector.len(), 1, |i, _| vector[i]);
    let product = matrix * &column;
    (0..matrix.nrows()).map(|i| product[(i, 0)]).collect()
}

/// Returns the squared distance of two parameter vectors in a metric.
pub(in crate::estimate) fn squared_distance(metric: &Mat<f64>, a: &[f64], b: &[f64]) -> f64 {
    let moved: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    let by = product(metric, &moved);
    moved.iter().zip(&by).map(|(a, b)| a * b).sum()
}
