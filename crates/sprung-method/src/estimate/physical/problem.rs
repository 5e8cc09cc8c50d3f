//! The convex program of an estimate.

use faer::Mat;
use sprung_core::parameters::JointParameter;
use sprung_core::spatial::BODY;

use super::bodies::Bodies;
use super::information::{Information, inverse};
use super::prior::{BodyPrior, add_prior, impossible, priors};
use crate::description::{Distance, Physical};
use crate::estimate::estimators::Numbers;
use crate::estimate::result::{Decided, PhysicalResult, StandardParameter};
use crate::estimate::statistics::{LARGE_SHARE, ROUNDING};
use crate::finding::{Finding, Severity};
use crate::fit::residual;
use crate::model::{
    Block, Model, NoSolution, Parameter, Program, Theta, TreeLinks, second_moments,
};
use crate::regression::System;

/// Returns possible bodies with possible drives near an estimate.
///
/// - `information`: information about theta; `None` if the log gives none.
pub(in crate::estimate) fn physical(
    model: &Model,
    settings: &Physical,
    numbers: &Numbers,
    (information, system): (Option<&Information>, &System),
) -> Bodies {
    let mut bodies = Bodies {
        theta: None,
        standard: Vec::new(),
        result: None,
        findings: Vec::new(),
    };
    let Some(Information {
        matrix: information,
        ..
    }) = information
    else {
        return bodies;
    };
    let problem = Problem::new(model, settings, numbers, information);
    let impossible = model
        .links()
        .map_or_else(Vec::new, |links| impossible(model, links));
    bodies.findings.extend(about_nominal(&impossible));
    let x = match problem.program.minimise(&problem.start, ROUNDING) {
        Ok(x) => x,
        Err(reason) => {
            bodies.findings.push(problem.none(reason));
            return bodies;
        }
    };
    let theta = problem.theta(&x);
    let moved = Mat::from_fn(theta.len(), 1, |i, _| theta[i] - numbers.theta[i]);
    let squares = (moved.transpose() * information * &moved)[(0, 0)];
    bodies.standard = problem.standard(&x);
    bodies.result = Some(PhysicalResult {
        prior: if problem.priors.iter().any(|own| own.is_nominal) {
            "nominal"
        } else {
            "none"
        }
        .to_owned(),
        distance: match settings.distance {
            Distance::Entropic => "entropic",
            Distance::Euclidean => "euclidean",
        }
        .to_owned(),
        prior_error: settings.prior_error,
        moved_standard_errors: squares.max(0.0).sqrt(),
        residual_ratio: (residual(model, system, &theta).iter())
            .zip(residual(model, system, &numbers.theta))
            .enumerate()
            .filter(|(row, (_, (own, _)))| model.is_torque_row(*row) && *own > 0.0)
            .map(|(row, ((possible, _), (own, _)))| (model.row_name(row), possible / own))
            .collect(),
        impossible_nominal: impossible,
    });
    bodies.theta = Some(theta);
    bodies
}

/// The program with the meaning of its unknowns.
struct Problem<'a> {
    model: &'a Model,
    program: Program,
    start: Vec<f64>,
    /// What each block of the program says, as the subject of a sentence.
    subjects: Vec<String>,
    /// Standard index of each of the first unknowns; the others are parameters of theta.
    standard: Vec<usize>,
    /// Prior of each link, then of each rotor; empty for a robot in closed form.
    priors: Vec<BodyPrior>,
    /// Change of theta by each unknown, \[p\] each.
    columns: Vec<Theta>,
    /// Theta without the unknowns.
    constant: Theta,
    /// Second derivatives of the squared distance from the estimate, \[unknowns × unknowns\].
    of_log: Vec<f64>,
}

impl<'a> Problem<'a> {
    fn new(
        model: &'a Model,
        settings: &Physical,
        numbers: &Numbers,
        information: &Mat<f64>,
    ) -> Self {
        let p = numbers.theta.len();
        let links = model.links();
        let standard: Vec<usize> = links.map_or_else(Vec::new, |links| {
            let all = 0..links.standard();
            all.filter(|index| !links.known.contains_key(index))
                .collect()
        });
        let is_other = |(_, own): &(usize, &Parameter)| {
            let of_bodies = match own.joint {
                None | Some((JointParameter::RotorInertia, _)) => links.is_some(),
                Some(_) => false,
            };
            own.fixed.is_none() && !of_bodies
        };
        let others: Vec<usize> = (model.parameters().iter().enumerate())
            .filter(is_other)
            .map(|(i, _)| i)
            .collect();
        let mut columns: Vec<Theta> = (standard.iter())
            .map(|&index| model.change_by_standard(index))
            .collect();
        columns.extend(others.iter().map(|&i| {
            let mut unit = vec![0.0; p];
            unit[i] = 1.0;
            unit
        }));
        let constant: Theta = (model.parameters().iter())
            .map(|own| own.fixed.unwrap_or(0.0))
            .collect();
        let (of_log, linear) = normal(&columns, &constant, numbers, information);
        let mut problem = Self {
            model,
            program: Program {
                quadratic: of_log.clone(),
                linear,
                blocks: Vec::new(),
            },
            start: vec![0.0; columns.len()],
            subjects: Vec::new(),
            standard,
            priors: Vec::new(),
            columns,
            constant,
            of_log,
        };
        if let Some(links) = links {
            problem.add_bodies(links, settings, numbers);
            problem.add_masses(links, settings);
        } else {
            problem.add_planar(&others);
        }
        problem.add_drives(&others, numbers);
        problem
    }

    /// Adds the bodies and rotors of a tree with their priors.
    fn add_bodies(&mut self, links: &TreeLinks, settings: &Physical, numbers: &Numbers) {
        let n = self.model.joint_count();
        let size = (numbers.theta.iter().zip(self.model.parameters()))
            .filter(|(_, own)| own.joint.is_none())
            .fold(1e-3_f64, |max, (value, _)| max.max(value.abs()));
        self.priors = priors(self.model, links, settings, size);
        let unknown = |index: usize| self.standard.binary_search(&index).ok();
        let known = |index: usize| links.known.get(&index).copied().unwrap_or(0.0);
        let mut added = Vec::new();
        for (at, prior) in self.priors.iter().enumerate() {
            let (first, count) = match at.checked_sub(n) {
                None => (at * BODY, BODY),
                Some(joint) => (n * BODY + joint, 1),
            };
            let unknowns: Vec<Option<usize>> = (first..first + count).map(unknown).collect();
            if unknowns.iter().all(Option::is_none) {
                continue;
            }
            let mut block = if count == BODY {
                second_moments(|k| unknowns[k].ok_or_else(|| known(first + k)))
            } else {
                Block::scalar(0.0, unknowns[0].map(|own| (own, 1.0)))
            };
            for (own, value) in unknowns.iter().zip(&prior.values) {
                if let Some(own) = own {
                    self.start[*own] = *value;
                }
            }
            let name = links.name(first);
            let subject = if count == BODY {
                let link = name.strip_suffix(".m").unwrap_or(name);
                format!("the second moments of the mass of {link}")
            } else {
                name.to_owned()
            };
            add_prior(&mut self.program, &mut block, prior, &unknowns, settings);
            added.push((block, subject));
        }
        for (block, subject) in added {
            self.program.blocks.push(block);
            self.subjects.push(subject);
        }
    }

    /// Adds the limits of masses.
    fn add_masses(&mut self, links: &TreeLinks, settings: &Physical) {
        let n = self.model.joint_count();
        let mut limits: Vec<(String, Vec<usize>, [f64; 2])> = Vec::new();
        if let Some(limit) = settings.total_mass_kg {
            limits.push((
                "the total mass".to_owned(),
                (0..n).map(|link| link * BODY).collect(),
                limit,
            ));
        }
        for (name, limit) in &settings.mass_kg {
            let of = |link: &usize| links.name(link * BODY).strip_suffix(".m") == Some(name);
            let masses = (0..n).filter(of).map(|link| link * BODY).collect();
            limits.push((format!("the mass of {name}"), masses, *limit));
        }
        for (subject, masses, [least, largest]) in limits {
            let known: f64 = masses
                .iter()
                .filter_map(|index| links.known.get(index))
                .sum();
            let unknowns: Vec<usize> = (masses.iter())
                .filter_map(|index| self.standard.binary_search(index).ok())
                .collect();
            let terms = |by: f64| unknowns.iter().map(move |&own| (own, by));
            self.program
                .blocks
                .push(Block::scalar(known - least, terms(1.0)));
            self.subjects.push(format!("{subject} above {least} kg"));
            self.program
                .blocks
                .push(Block::scalar(largest - known, terms(-1.0)));
            self.subjects.push(format!("{subject} below {largest} kg"));
        }
    }

    /// Adds the bodies of the paper's arm: `theta1 - theta3` and `theta3` are inertias of two bodies
    /// that `theta2` couples.
    fn add_planar(&mut self, others: &[usize]) {
        let unknown = |index: usize| others.iter().position(|own| *own == index);
        let entries: [Vec<(usize, usize, f64)>; 3] = [
            vec![(0, 0, 1.0)],
            vec![(0, 1, 1.0)],
            vec![(0, 0, -1.0), (1, 1, 1.0)],
        ];
        let mut block = Block::new(2, Vec::new());
        for (index, own) in entries.into_iter().enumerate() {
            match unknown(index) {
                Some(unknown) => block.terms.push((unknown, own)),
                None => block.add_constant(&own, self.constant[index]),
            }
        }
        if !block.terms.is_empty() {
            self.program.blocks.push(block);
            self.subjects.push("the inertia of the links".to_owned());
        }
    }

    /// Adds the parameters that are no part of bodies: positive stiffnesses, and friction that takes
    /// energy.
    fn add_drives(&mut self, others: &[usize], numbers: &Numbers) {
        let n = self.columns.len();
        for (at, &index) in others.iter().enumerate() {
            let unknown = self.standard.len() + at;
            let parameter = &self.model.parameters()[index];
            let value = numbers.theta[index];
            let own = self.of_log[unknown * (n + 1)];
            let ridge = ROUNDING * if own > 0.0 { own } else { 1.0 };
            self.program.quadratic[unknown * (n + 1)] += ridge;
            self.program.linear[unknown] += ridge * value;
            self.start[unknown] = value;
            let is_positive = parameter.joint.is_some_and(|(kind, _)| {
                kind.is_vital() || kind.is_friction() || kind == JointParameter::Damping
            });
            if is_positive {
                self.program
                    .blocks
                    .push(Block::scalar(0.0, [(unknown, 1.0)]));
                self.subjects.push(parameter.name.clone());
                let scale = if own > 0.0 { own.sqrt().recip() } else { 1.0 };
                self.start[unknown] = value.max(1e-3 * scale);
            }
        }
    }

    fn theta(&self, x: &[f64]) -> Theta {
        let mut theta = self.constant.clone();
        for (column, x) in self.columns.iter().zip(x) {
            for (own, by) in theta.iter_mut().zip(column) {
                *own += x * by;
            }
        }
        theta
    }

    /// Returns all inertial parameters of the links, then the rotor inertias.
    fn standard(&self, x: &[f64]) -> Vec<StandardParameter> {
        let Some(links) = self.model.links() else {
            return Vec::new();
        };
        let n = x.len();
        let whole = self.program.hessian(x);
        let covariance = |hessian: &dyn Fn(usize) -> f64| {
            inverse(&Mat::from_fn(n, n, |i, j| hessian(i * n + j)))
        };
        let posterior = whole.as_ref().and_then(|own| covariance(&|at| own[at]));
        let count = self.standard.len();
        let prior = whole.as_ref().and_then(|own| {
            let part = |i: usize, j: usize| own[i * n + j] - self.of_log[i * n + j];
            inverse(&Mat::from_fn(count, count, part))
        });
        (0..links.standard())
            .map(|index| {
                let unknown = self.standard.binary_search(&index).ok();
                let variance = unknown.and_then(|i| Some(posterior.as_ref()?[(i, i)]));
                let before = unknown.and_then(|i| Some(prior.as_ref()?[(i, i)]));
                let share = match (variance, before) {
                    (Some(after), Some(before)) => (1.0 - after / before).clamp(0.0, 1.0),
                    _ => 0.0,
                };
                let bodies = self.model.joint_count() * BODY;
                let at = match index.checked_sub(bodies) {
                    None => index / BODY,
                    Some(joint) => self.model.joint_count() + joint,
                };
                StandardParameter {
                    name: links.name(index).to_owned(),
                    unit: links.unit(index).to_owned(),
                    value: match unknown {
                        Some(i) => x[i],
                        None => links.known.get(&index).copied().unwrap_or(0.0),
                    },
                    standard_error: variance.map(f64::sqrt).filter(|own| own.is_finite()),
                    nominal: links.nominal(index),
                    decided: match unknown {
                        None => Decided::Given,
                        Some(_) if share > (1.0 - LARGE_SHARE) => Decided::Log,
                        Some(_) if share > LARGE_SHARE => Decided::Both,
                        Some(_) if self.priors[at].is_nominal => Decided::Nominal,
                        Some(_) => Decided::Nothing,
                    },
                    share_of_log: share,
                }
            })
            .collect()
    }

    /// Returns the finding that no bodies obey all limits.
    fn none(&self, reason: NoSolution) -> Finding {
        let why = match reason {
            NoSolution::Contradiction(block) => format!(
                "the given values and limits contradict each other: {} cannot be positive together \
                 with the others",
                self.subjects[block]
            ),
            NoSolution::Singular => "the search failed".to_owned(),
        };
        Finding::new(
            Severity::Warning,
            "no-possible-bodies",
            format!("no possible bodies were found: {why}"),
            "compare the values of fixed, assume_zero, total_mass_kg and mass_kg with the robot",
        )
    }
}

/// Returns the second derivatives by the unknowns of half the squared distance from the estimate, and
/// minus its gradient at zero.
fn normal(
    columns: &[Theta],
    constant: &[f64],
    numbers: &Numbers,
    information: &Mat<f64>,
) -> (Vec<f64>, Vec<f64>) {
    let (n, p) = (columns.len(), constant.len());
    let t = Mat::from_fn(p, n, |i, j| columns[j][i]);
    let rest = Mat::from_fn(p, 1, |i, _| numbers.theta[i] - constant[i]);
    let by = information * &t;
    let quadratic = t.transpose() * &by;
    let linear = by.transpose() * &rest;
    (
        (0..n * n)
            .map(|at| {
                let (i, j) = (at / n, at % n);
                f64::midpoint(quadratic[(i, j)], quadratic[(j, i)])
            })
            .collect(),
        (0..n).map(|i| linear[(i, 0)]).collect(),
    )
}

fn about_nominal(impossible: &[String]) -> Option<Finding> {
    if impossible.is_empty() {
        return None;
    }
    let names = impossible.join(", ");
    Some(Finding::new(
        Severity::Info,
        "impossible-nominal-bodies",
        format!(
            "no body has the nominal inertial parameters of {names}: mass or inertia is zero or \
             negative, or one principal moment of inertia is not below the sum of the other two. They \
             are not used as a prior",
        ),
        "correct mass, centre of mass and inertia in the URDF or in nominal",
    ))
}
