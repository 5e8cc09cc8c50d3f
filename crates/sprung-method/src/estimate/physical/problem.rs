//! The convex program of an estimate.

use faer::Mat;
use sprung_core::spatial::BODY;

use super::bodies::Bodies;
use super::information::Information;
use super::regions::about_regions;
use crate::description::{Distance, Physical};
use crate::estimate::estimators::Numbers;
use crate::estimate::possible::{Beside, Possible, Robots, inverse, squared_distance};
use crate::estimate::result::{Decided, PhysicalResult, StandardParameter};
use crate::estimate::statistics::LARGE_SHARE;
use crate::finding::{Finding, Severity};
use crate::fit::residual;
use crate::model::{Model, NoSolution};
use crate::regression::System;

/// The robot of an estimate.
#[derive(Clone, Copy)]
enum Search {
    /// The nearest one that can exist.
    Near,
    /// The one with the parameters of the estimate, which can exist.
    Exact,
}

impl Search {
    fn run(
        self,
        robots: &Robots<'_>,
        information: &Mat<f64>,
        theta: &[f64],
    ) -> Result<Possible, NoSolution> {
        match self {
            Self::Near => robots.nearest(information, theta),
            Self::Exact => robots.robot_of(information, theta),
        }
    }
}

/// Returns possible bodies with possible drives near an estimate without constraints.
///
/// - `information`: information about theta; `None` if the log gives none.
pub(in crate::estimate) fn physical(
    model: &Model,
    settings: &Physical,
    numbers: &Numbers,
    about: (Option<&Information>, &System),
) -> Bodies {
    let robots = Robots::new(model, settings, &numbers.theta, Beside::Estimate);
    bodies(&robots, settings, numbers, about, Search::Near)
}

/// Returns the bodies of a robot that can exist.
///
/// - `information`: information about theta; `None` if the log gives none.
pub(in crate::estimate) fn bodies_of(
    robots: &Robots<'_>,
    settings: &Physical,
    numbers: &Numbers,
    about: (Option<&Information>, &System),
) -> Bodies {
    let mut result = bodies(robots, settings, numbers, about, Search::Exact);
    if let Some(tree) = robots.model.tree() {
        result.findings.extend(about_regions(tree, &robots.outside));
    }
    result
}

/// - `search`: which robot is that of the estimate.
fn bodies(
    robots: &Robots<'_>,
    settings: &Physical,
    numbers: &Numbers,
    (information, system): (Option<&Information>, &System),
    search: Search,
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
    let model = robots.model;
    bodies
        .findings
        .extend(about_nominal(&robots.impossible_nominal));
    let found = match search.run(robots, information, &numbers.theta) {
        Ok(found) => found,
        Err(reason) => {
            bodies.findings.push(none(&robots.why(reason)));
            return bodies;
        }
    };
    let theta = found.theta.clone();
    let squares = squared_distance(information, &theta, &numbers.theta);
    bodies.standard = standard(robots, &found);
    bodies.result = Some(PhysicalResult {
        prior: if robots.priors.iter().any(|prior| prior.is_nominal) {
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
            .filter(|(row, (_, (unconstrained, _)))| {
                model.is_torque_row(*row) && *unconstrained > 0.0
            })
            .map(|(row, ((possible, _), (unconstrained, _)))| {
                (model.row_name(row), possible / unconstrained)
            })
            .collect(),
        impossible_nominal: robots.impossible_nominal.clone(),
    });
    bodies.theta = Some(theta);
    bodies
}

/// Returns all inertial parameters of the links, then the rotor inertias.
fn standard(robots: &Robots<'_>, found: &Possible) -> Vec<StandardParameter> {
    let Some(links) = robots.model.links() else {
        return Vec::new();
    };
    let Possible {
        x, of_log, of_all, ..
    } = found;
    let n = x.len();
    let covariance =
        |hessian: &dyn Fn(usize) -> f64| inverse(&Mat::from_fn(n, n, |i, j| hessian(i * n + j)));
    let posterior = of_all
        .as_ref()
        .and_then(|matrix| covariance(&|at| matrix[at]));
    let count = robots.standard.len();
    let prior = of_all.as_ref().and_then(|matrix| {
        let part = |i: usize, j: usize| matrix[i * n + j] - of_log[i * n + j];
        inverse(&Mat::from_fn(count, count, part))
    });
    (0..links.standard())
        .map(|index| {
            let unknown = robots.standard.binary_search(&index).ok();
            let variance = unknown.and_then(|i| Some(posterior.as_ref()?[(i, i)]));
            let before = unknown.and_then(|i| Some(prior.as_ref()?[(i, i)]));
            let share = match (variance, before) {
                (Some(after), Some(before)) => (1.0 - after / before).clamp(0.0, 1.0),
                _ => 0.0,
            };
            let bodies = robots.model.joint_count() * BODY;
            let at = match index.checked_sub(bodies) {
                None => index / BODY,
                Some(joint) => robots.model.joint_count() + joint,
            };
            StandardParameter {
                name: links.name(index).to_owned(),
                unit: links.unit(index).to_owned(),
                value: match unknown {
                    Some(i) => x[i],
                    None => links.known.get(&index).copied().unwrap_or(0.0),
                },
                standard_error: variance.map(f64::sqrt).filter(|error| error.is_finite()),
                nominal: links.nominal(index),
                decided: match unknown {
                    None => Decided::Given,
                    Some(_) if share > 1.0 - LARGE_SHARE => Decided::Log,
                    Some(_) if share > LARGE_SHARE => Decided::Both,
                    Some(_) if robots.priors[at].is_nominal => Decided::Nominal,
                    Some(_) => Decided::Nothing,
                },
                share_of_log: share,
            }
        })
        .collect()
}

/// Returns the finding that no bodies obey all limits.
fn none(why: &str) -> Finding {
    Finding::new(
        Severity::Warning,
        "no-possible-bodies",
        format!("no possible bodies were found: {why}"),
        "compare the values of fixed, assume_zero, total_mass_kg and mass_kg with the robot",
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
