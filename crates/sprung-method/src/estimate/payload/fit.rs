//! Least squares of a payload.

use faer::Mat;
use sprung_core::parameters::JointParameter;
use sprung_core::spatial::{BODY, BODY_NAMES, BODY_UNITS};

use super::findings::{about_joints, about_payload};
use crate::estimate::estimators::Numbers;
use crate::estimate::physical::{information, of_equations, widened};
use crate::estimate::possible::inverse;
use crate::estimate::result::{PayloadParameter, PayloadResult};
use crate::estimate::statistics::{NORMAL_95, RIDGE, ROUNDING};
use crate::finding::Finding;
use crate::fit::{Fitted, HoldOut, residual};
use crate::model::{Block, Model, Program, Theta, second_moments};
use crate::regression::System;

/// Logs of a robot with a payload.
pub(in crate::estimate) struct Loaded<'a> {
    /// Name of the payload.
    pub(in crate::estimate) name: &'a str,
    /// Link that carries it, by index.
    pub(in crate::estimate) link: usize,
    /// Names of the logs.
    pub(in crate::estimate) logs: Vec<String>,
    /// Reduced system of the logs.
    pub(in crate::estimate) system: &'a System,
}

/// Estimates a payload; `None` for a robot in closed form, or if the logs determine nothing.
///
/// - `estimator`, `numbers`: estimate of the robot without the payload.
/// - `empty`, `linear`: reduced system of the logs without it, and their least squares. Its standard errors contain the
///   colour of the residuals.
///
/// # Source
///
/// Khalil, Gautier and Lemoine, "Identification of the payload inertial parameters of industrial manipulators", ICRA
/// 2007: the methods with known parameters of the robot and with both estimated together; here the covariance of the
/// robot's parameters joins them.
pub(in crate::estimate) fn payload_of(
    model: &Model,
    loaded: &Loaded<'_>,
    (estimator, numbers): (&str, &Numbers),
    (empty, linear): (&System, &Fitted),
) -> Option<(PayloadResult, Vec<Finding>)> {
    let links = model.links()?;
    let unbiased = information(model, numbers, &without_bias(numbers), empty)?;
    let equations = Numbers::of(linear);
    let of_equations_only = information(model, &equations, &without_bias(&equations), empty)?;
    let columns: Vec<Theta> = (0..BODY)
        .map(|k| model.change_by_standard(loaded.link * BODY + k))
        .collect();
    // The difference of two estimates with equal settings cancels common errors: the same weights, and no constraints.
    let alone = HoldOut::new(model, loaded.system, 1)
        .weighted(linear.weights())
        .fit(|_| true)?;
    let robot = numbers.unconstrained.as_ref().unwrap_or(&numbers.theta);
    // The errors of the loaded logs exceed those by white residuals as much as in the other logs.
    let white = of_equations(model, &alone, loaded.system)?;
    let of_loaded = widened(&white, &of_equations_only.factors, 1.0);
    let solved = solve(
        model,
        (robot, &unbiased.of_errors()),
        (&alone, &of_loaded),
        &columns,
    )?;
    let possible = possible(&solved);
    let name = links.name(loaded.link * BODY);
    let result = PayloadResult {
        name: loaded.name.to_owned(),
        link: name.strip_suffix(".m").unwrap_or(name).to_owned(),
        estimator: estimator.to_owned(),
        logs: loaded.logs.clone(),
        parameters: (0..BODY)
            .map(|k| {
                let estimate = solved.of(k);
                PayloadParameter {
                    name: format!("{}.{}", loaded.name, BODY_NAMES[k]),
                    unit: BODY_UNITS[k].to_owned(),
                    value: estimate.map(|(value, _)| value),
                    standard_error: estimate.map(|(_, error)| error),
                    ci95: estimate.map(|(value, error)| {
                        [-1.0, 1.0].map(|side| value + side * NORMAL_95 * error)
                    }),
                    physical: possible
                        .as_ref()
                        .map(|all| all[k])
                        .filter(|_| estimate.is_some()),
                }
            })
            .collect(),
        centre_of_mass_m: std::array::from_fn(|axis| solved.centre(axis)),
        residual_rms: (residual(model, loaded.system, &alone).iter().enumerate())
            .map(|(row, (rms, _))| (model.row_name(row), *rms))
            .collect(),
    };
    let mut findings = about_payload(&result, solved.distance(possible.as_deref()));
    findings.extend(about_joints(model, empty, loaded.system));
    Some((result, findings))
}

/// The payload's parameters with their covariance.
struct Solved {
    values: Vec<f64>,
    covariance: Mat<f64>,
    /// Whether the logs determine each parameter.
    is_determined: Vec<bool>,
}

impl Solved {
    /// Returns value and standard error of a parameter that the logs determine.
    fn of(&self, parameter: usize) -> Option<(f64, f64)> {
        let both = (
            self.values[parameter],
            self.covariance[(parameter, parameter)].sqrt(),
        );
        let is_finite = both.0.is_finite() && both.1.is_finite();
        (self.is_determined[parameter] && is_finite).then_some(both)
    }

    /// Returns a coordinate of the centre of mass with its standard error, m.
    fn centre(&self, axis: usize) -> Option<(f64, f64)> {
        let at = 1 + axis;
        let ((mass, _), (moment, _)) = (self.of(0)?, self.of(at)?);
        let centre = moment / mass;
        let covariance = |i: usize, j: usize| self.covariance[(i, j)];
        let variance = covariance(at, at) - 2.0 * centre * covariance(0, at)
            + centre * centre * covariance(0, 0);
        let error = variance.max(0.0).sqrt() / mass.abs();
        (centre.is_finite() && error.is_finite()).then_some((centre, error))
    }

    /// Returns the distance of other parameters in standard errors along all parameters.
    fn distance(&self, other: Option<&[f64]>) -> Option<f64> {
        let other = other?;
        let metric = inverse(&self.covariance)?;
        let moved = Mat::from_fn(BODY, 1, |i, _| other[i] - self.values[i]);
        let squares = (moved.transpose() * &metric * &moved)[(0, 0)];
        Some(squares.max(0.0).sqrt())
    }
}

/// Returns the standard errors without bias: logs with and without payload share it, so it cancels in
/// their difference.
fn without_bias(numbers: &Numbers) -> Vec<f64> {
    let parts = numbers.error_parts.iter();
    let errors: Vec<f64> = parts
        .map(|part| part.sampling.hypot(part.between_parts))
        .collect();
    if errors.len() == numbers.errors.len() {
        errors
    } else {
        numbers.errors.clone()
    }
}

/// Returns whether a parameter has a separate value in the loaded logs.
fn has_loaded_value(model: &Model, parameter: usize) -> bool {
    (model.parameters()[parameter].joint).is_some_and(|(kind, _)| {
        matches!(kind, JointParameter::Friction(..) | JointParameter::Preload)
    })
}

/// Solves for the payload, the parameters of the robot, and friction of the loaded logs.
///
/// - `empty`, `loaded`: estimates without and with the payload, each with its information.
/// - `columns`: change of theta by each parameter of the payload.
fn solve(
    model: &Model,
    empty: (&[f64], &Mat<f64>),
    loaded: (&[f64], &Mat<f64>),
    columns: &[Theta],
) -> Option<Solved> {
    let p = empty.0.len();
    let free: Vec<usize> = (0..p)
        .filter(|&i| model.parameters()[i].fixed.is_none())
        .collect();
    let of_empty: Vec<usize> = free
        .iter()
        .copied()
        .filter(|&i| has_loaded_value(model, i))
        .collect();
    let first = free.len() + of_empty.len();
    let n = first + BODY;
    // Change of theta by the unknowns, without and with the payload: theta with the payload, friction
    // without it, and the payload.
    let mut without = Mat::<f64>::zeros(p, n);
    let mut with = Mat::<f64>::zeros(p, n);
    for (at, &i) in free.iter().enumerate() {
        with[(i, at)] = 1.0;
        if !has_loaded_value(model, i) {
            without[(i, at)] = 1.0;
        }
    }
    for (at, &i) in of_empty.iter().enumerate() {
        without[(i, free.len() + at)] = 1.0;
    }
    for (k, column) in columns.iter().enumerate() {
        for (i, by) in column.iter().enumerate() {
            with[(i, first + k)] = *by;
        }
    }
    let mut normal = Mat::<f64>::zeros(n, n);
    let mut right = Mat::<f64>::zeros(n, 1);
    for ((theta, information), change) in [(empty, &without), (loaded, &with)] {
        let theta = Mat::from_fn(p, 1, |i, _| {
            theta[i] - model.parameters()[i].fixed.unwrap_or(0.0)
        });
        let by = change.transpose() * information;
        normal += &by * change;
        right += &by * &theta;
    }
    let diagonal: Vec<f64> = (0..n).map(|i| normal[(i, i)]).collect();
    for (i, entry) in diagonal.iter().enumerate() {
        normal[(i, i)] += if *entry > 0.0 { RIDGE * entry } else { 1.0 };
    }
    let inverse = inverse(&normal)?;
    let solution = &inverse * &right;
    Some(Solved {
        values: (0..BODY).map(|k| solution[(first + k, 0)]).collect(),
        covariance: Mat::from_fn(BODY, BODY, |i, j| inverse[(first + i, first + j)]),
        is_determined: (first..n)
            .map(|i| diagonal[i] > 0.0 && inverse[(i, i)] * diagonal[i] < 1.0 / ROUNDING)
            .collect(),
    })
}

/// Returns the parameters of the nearest body that can exist.
fn possible(solved: &Solved) -> Option<Vec<f64>> {
    let metric = inverse(&solved.covariance)?;
    let program = Program {
        quadratic: (0..BODY * BODY)
            .map(|at| metric[(at / BODY, at % BODY)])
            .collect(),
        linear: (0..BODY)
            .map(|i| (0..BODY).map(|j| metric[(i, j)] * solved.values[j]).sum())
            .collect(),
        blocks: vec![body()],
    };
    let size = solved.values[0].abs().max(1e-3);
    let mut start = [0.0; BODY];
    start[0] = size;
    for k in [4, 6, 9] {
        start[k] = 0.02 * size;
    }
    program.minimise(&start, ROUNDING).ok()
}

fn body() -> Block {
    second_moments(Ok)
}
