//! The posterior of an identification.

use faer::Mat;
use faer::linalg::solvers::DenseSolveCore;
use rayon::prelude::*;
use sprung_core::parameters::JointParameter;
use sprung_core::spatial::BODY;

use super::chains::Chains;
use super::errors::PosteriorError;
use super::evidence::Evidence;
use super::plain::Plain;
use super::samples::{DrawMethod, Samples};
use crate::description::Physical;
use crate::estimate::possible::{Beside, Robots, Tool, inverse, must_be_positive};
use crate::estimate::result::{EstimateResult, ParameterEstimate};
use crate::estimate::statistics::LARGE_SHARE;
use crate::model::{Block, Model, Program, Region, Theta};

/// Largest number of robots of one call: their parameters take some hundred megabytes.
const MOST: usize = 100_000;

/// Error of a value of zero that the log does not determine, in its unit: the value hardly moves.
const SMALLEST_ERROR: f64 = 1e-9;

/// Distance from its bound at which a drive's parameter starts, in its errors.
const INSIDE: f64 = 1e-3;

/// The posterior of an identification: a normal distribution over the robots that can exist.
#[derive(Clone, Debug)]
pub struct Posterior {
    /// Mean without the set, \[unknowns\].
    pub(super) mean: Vec<f64>,
    /// Inverse of the covariance without the set, \[unknowns × unknowns\].
    pub(super) precision: Mat<f64>,
    /// Matrices that must be positive definite, without the prior.
    pub(super) blocks: Vec<Block>,
    /// The robot in the middle of the posterior: the minimum of minus the logarithm of the density with the barrier,
    /// \[unknowns\].
    pub(super) centre: Vec<f64>,
    /// Change of theta by each unknown, \[unknowns\]\[p\], and theta without the unknowns, \[p\].
    columns: Vec<Theta>,
    constant: Theta,
    /// Places of the first unknowns among the inertial parameters of single links and rotors, and these without the
    /// unknowns.
    places: Vec<usize>,
    standard: Vec<f64>,
    /// Samples without robots.
    empty: Samples,
}

impl Posterior {
    /// Returns the posterior of a result.
    ///
    /// - `model`: the robot with the laws of the identification; `settings`: what the experiment says about its bodies.
    ///
    /// # Errors
    ///
    /// [`PosteriorError`] if the result has no covariance or belongs to another robot, or if no robot can exist.
    pub fn new(
        model: &Model,
        settings: &Physical,
        result: &EstimateResult,
    ) -> Result<Self, PosteriorError> {
        let values = result.values();
        let model = &model.shaped(&values);
        let evidence = Evidence::new(model, result)?;
        let speeds = speeds(model, result);
        let near: Theta = (model.parameters().iter())
            .map(|own| values.get(&own.name).copied().unwrap_or(0.0))
            .collect();
        let tool = tool(model, result);
        let robots = Robots::new(model, settings, &near, Beside::Draws(&speeds, tool));
        let rest = Rest::new(&robots, settings, result, &evidence)?;
        let normal =
            Normal::new(&robots, &bodies(&robots, result), &evidence, &rest).ok_or_else(|| {
                PosteriorError::Covariance {
                    estimator: result.estimator.clone(),
                }
            })?;
        let centre = centre(&robots, &normal, &start(&robots, &rest, result))?;
        let links = model.links();
        let names = |count: usize| {
            let name = |index: usize| links.map(|own| own.name(index).to_owned());
            (0..count).filter_map(name).collect::<Vec<_>>()
        };
        let standard = links.map_or(0, crate::model::TreeLinks::standard);
        let constants = (values.into_iter())
            .filter(|(name, _)| result.parameter(name).is_none())
            .collect();
        Ok(Self {
            blocks: borders_of(&robots),
            centre,
            empty: Samples {
                parameters: (model.parameters().iter())
                    .map(|own| own.name.clone())
                    .collect(),
                theta: Vec::new(),
                standard_parameters: names(standard),
                standard: Vec::new(),
                links: links.map_or_else(Vec::new, |own| own.tree.links.clone()),
                undetermined: rest.undetermined,
                undetermined_standard: normal.undetermined(&robots),
                constants,
                method: DrawMethod::Rejection { accepted: 0.0 },
                effective: 0.0,
            },
            mean: normal.mean,
            precision: normal.precision,
            standard: (0..standard)
                .map(|index| links.and_then(|own| own.known.get(&index).copied()))
                .map(Option::unwrap_or_default)
                .collect(),
            columns: robots.columns,
            constant: robots.constant,
            places: robots.standard,
        })
    }

    /// Draws robots. The same seed gives the same robots, on any number of threads.
    ///
    /// - `count`: number of robots, 1 to 100 000.
    ///
    /// # Errors
    ///
    /// [`PosteriorError::Count`].
    pub fn sample(&self, count: usize, seed: u64) -> Result<Samples, PosteriorError> {
        if count == 0 || count > MOST {
            return Err(PosteriorError::Count { count, most: MOST });
        }
        let plain = Plain::new(self).and_then(|plain| plain.draw(count, seed));
        let (unknowns, method, effective) = match plain {
            Some((unknowns, accepted)) => {
                let method = DrawMethod::Rejection { accepted };
                (unknowns, method, count as f64)
            }
            None => Chains::new(self).draw(count, seed),
        };
        let theta = unknowns.par_iter().map(|x| self.theta(x)).collect();
        let standard = unknowns.par_iter().map(|x| self.standard(x)).collect();
        Ok(Samples {
            theta,
            standard,
            method,
            effective,
            ..self.empty.clone()
        })
    }

    /// Returns the parameters of a robot, \[p\].
    pub(super) fn theta(&self, x: &[f64]) -> Theta {
        let mut theta = self.constant.clone();
        for (column, x) in self.columns.iter().zip(x) {
            for (own, by) in theta.iter_mut().zip(column) {
                *own += x * by;
            }
        }
        theta
    }

    /// Returns the inertial parameters of single links and rotors of a robot.
    fn standard(&self, x: &[f64]) -> Vec<f64> {
        let mut standard = self.standard.clone();
        for (place, x) in self.places.iter().zip(x) {
            standard[*place] = *x;
        }
        standard
    }
}

/// Returns the speeds up to which sums of friction laws take energy, rad/s (m/s), \[n\]. Results that do not tell them
/// have the velocity of the residual laws, which is the largest speed of the log, too.
fn speeds(model: &Model, result: &EstimateResult) -> Vec<f64> {
    (model.joints().iter().enumerate())
        .map(|(joint, name)| {
            let own = result.friction_speed.get(name);
            own.unwrap_or(model.shape(joint).residual_velocity)
        })
        .collect()
}

/// Returns where the estimate has the masses of links that carry no joint.
fn tool(model: &Model, result: &EstimateResult) -> Tool {
    let Some(tree) = model.tree() else {
        return Tool::InRegion;
    };
    let bodies = result.standard_parameters.chunks_exact(BODY);
    let mut links = Region::all(tree).into_iter().zip(bodies).enumerate();
    let is_outside = links.any(|(link, (region, body))| {
        let carries = tree.joints.iter().any(|joint| joint.parent == Some(link));
        let body: Vec<f64> = body.iter().map(|own| own.value).collect();
        !carries && region.is_some_and(|region| !region.holds(&body))
    });
    if is_outside {
        Tool::Anywhere
    } else {
        Tool::InRegion
    }
}

/// The other unknowns, and the parameters that the log does not determine.
struct Rest {
    /// Most likely value and its error by the prior, of each other unknown.
    others: Vec<[f64; 2]>,
    undetermined: Vec<String>,
}

impl Rest {
    fn new(
        robots: &Robots<'_>,
        settings: &Physical,
        result: &EstimateResult,
        evidence: &Evidence,
    ) -> Result<Self, PosteriorError> {
        let parameters = robots.model.parameters();
        let is_known = |index: usize| evidence.known.contains(&index);
        let mut names = Vec::new();
        let others = (robots.others.iter())
            .map(|&index| {
                let parameter = &parameters[index];
                let own = result.parameter(&parameter.name);
                let value = own.and_then(|own| own.value.or(own.physical));
                // The offset of a sensor is no property of the robot.
                let is_offset = matches!(parameter.joint, Some((JointParameter::TorqueOffset, _)));
                let value = (value.or(parameter.nominal)).or(is_offset.then_some(0.0));
                if value.is_none() && !is_known(index) {
                    names.push(parameter.name.clone());
                }
                let value = value.unwrap_or(0.0);
                if is_known(index) {
                    // The log's distribution takes the place of this one.
                    let error = own.and_then(ParameterEstimate::error_by_equations);
                    return [value, error.unwrap_or(1.0)];
                }
                [
                    value,
                    (settings.prior_error * value.abs()).max(SMALLEST_ERROR),
                ]
            })
            .collect();
        if !names.is_empty() {
            return Err(PosteriorError::NoValue { names });
        }
        let undetermined = (parameters.iter().enumerate())
            .filter(|(index, own)| own.fixed.is_none() && !is_known(*index))
            .map(|(_, own)| own.name.clone());
        Ok(Self {
            others,
            undetermined: undetermined.collect(),
        })
    }
}

/// The posterior without the set.
struct Normal {
    mean: Vec<f64>,
    precision: Mat<f64>,
    /// Second derivatives of minus the logarithm of the prior, \[unknowns × unknowns\].
    prior: Mat<f64>,
}

impl Normal {
    /// The prior decides only what the log leaves open: the distribution of the parameters that the log determines is that
    /// of the log.
    ///
    /// - `bodies`: most likely bodies by the prior, \[unknowns\].
    fn new(robots: &Robots<'_>, bodies: &[f64], evidence: &Evidence, rest: &Rest) -> Option<Self> {
        let (n, count) = (robots.columns.len(), robots.standard.len());
        let of_bodies = Program {
            blocks: (robots.prior.blocks.iter())
                .filter(|block| block.entropy > 0.0)
                .cloned()
                .collect(),
            ..robots.prior.clone()
        };
        let hessian = of_bodies.hessian(bodies)?;
        let mut prior = Mat::from_fn(n, n, |i, j| hessian[i * n + j]);
        let mut middle = bodies.to_vec();
        for (at, [value, error]) in (count..).zip(&rest.others) {
            prior[(at, at)] = error.powi(-2);
            middle[at] = *value;
        }
        let known = &evidence.known;
        let t = Mat::from_fn(known.len(), n, |i, j| robots.columns[j][known[i]]);
        let moved = inverse(&prior)? * t.transpose();
        // Information about the known parameters by the prior alone; that by the log takes its place.
        let before = inverse(&(&t * &moved))?;
        let precision = &prior + t.transpose() * (&evidence.information - &before) * &t;
        let of_middle = &t * Mat::from_fn(n, 1, |i, _| middle[i]);
        let rest = Mat::from_fn(known.len(), 1, |i, _| {
            evidence.values[i] - robots.constant[known[i]] - of_middle[(i, 0)]
        });
        let by = &moved * (&before * &rest);
        let mean: Vec<f64> = (0..n).map(|i| middle[i] + by[(i, 0)]).collect();
        let precision = Mat::from_fn(n, n, |i, j| {
            f64::midpoint(precision[(i, j)], precision[(j, i)])
        });
        let is_finite = mean.iter().all(|own| own.is_finite())
            && (0..n * n).all(|at| precision[(at / n, at % n)].is_finite());
        is_finite.then_some(Self {
            mean,
            precision,
            prior,
        })
    }

    /// Returns the names of inertial parameters whose variance is that of the prior.
    fn undetermined(&self, robots: &Robots<'_>) -> Vec<String> {
        let (Some(links), Some(before), Some(after)) = (
            robots.model.links(),
            inverse(&self.prior),
            inverse(&self.precision),
        ) else {
            return Vec::new();
        };
        (robots.standard.iter().enumerate())
            .filter(|(i, _)| after[(*i, *i)] > (1.0 - LARGE_SHARE) * before[(*i, *i)])
            .map(|(_, index)| links.name(*index).to_owned())
            .collect()
    }
}

/// Returns the most likely bodies by the prior, \[unknowns\]: nominal bodies, else bodies in the middle between ordinary
/// ones and those of the result. Ordinary bodies alone may be ten times smaller than those that the log needs, and the
/// others may be thin.
fn bodies(robots: &Robots<'_>, result: &EstimateResult) -> Vec<f64> {
    let links = robots.model.joint_count() * BODY;
    let mut bodies = robots.start.clone();
    for (own, &index) in bodies.iter_mut().zip(&robots.standard) {
        let is_nominal = (robots.priors.get(index / BODY)).is_some_and(|own| own.is_nominal);
        if let Some(found) = result.standard_parameters.get(index)
            && index < links
            && !is_nominal
        {
            *own = f64::midpoint(*own, found.value);
        }
    }
    bodies
}

/// Returns the matrices that must be positive definite, without the prior.
fn borders_of(robots: &Robots<'_>) -> Vec<Block> {
    let without_prior = |block: &Block| {
        let mut own = block.clone();
        own.entropy = 0.0;
        own
    };
    robots.prior.blocks.iter().map(without_prior).collect()
}

/// Returns the robot of the result, as far as it tells it, else of the prior.
fn start(robots: &Robots<'_>, rest: &Rest, result: &EstimateResult) -> Vec<f64> {
    let mut start = robots.start.clone();
    for (own, index) in start.iter_mut().zip(&robots.standard) {
        if let Some(found) = result.standard_parameters.get(*index) {
            *own = found.value;
        }
    }
    let others = robots.others.iter().zip(&rest.others);
    for (own, (&index, [value, error])) in start[robots.standard.len()..].iter_mut().zip(others) {
        let parameter = &robots.model.parameters()[index];
        *own = *value;
        if must_be_positive(parameter) {
            let found = result.parameter(&parameter.name);
            let error = found.and_then(|own| own.standard_error).unwrap_or(*error);
            *own = value.max(INSIDE * error);
        }
    }
    start
}

/// Returns the robot in the middle of the posterior.
fn centre(robots: &Robots<'_>, normal: &Normal, start: &[f64]) -> Result<Vec<f64>, PosteriorError> {
    let n = start.len();
    // Differences from the mean keep the digits of the function.
    let shifted = |block: &Block| {
        let mut own = block.clone();
        for (unknown, entries) in &block.terms {
            own.add_constant(entries, normal.mean[*unknown]);
        }
        own
    };
    let program = Program {
        quadratic: (0..n * n)
            .map(|at| normal.precision[(at / n, at % n)])
            .collect(),
        linear: vec![0.0; n],
        blocks: borders_of(robots).iter().map(shifted).collect(),
    };
    let from: Vec<f64> = start.iter().zip(&normal.mean).map(|(x, m)| x - m).collect();
    let gap = program.rows() as f64;
    let found = (program.minimise(&from, gap))
        .map_err(|reason| PosteriorError::NoRobot(robots.why(reason)))?;
    Ok(found.iter().zip(&normal.mean).map(|(x, m)| x + m).collect())
}

/// Returns vectors whose products give the inverse of a positive definite matrix: independent standard normal numbers
/// times these have this covariance.
///
/// - `matrix`: \[n × n\].
pub(super) fn coordinates(matrix: &Mat<f64>) -> Option<Vec<Vec<f64>>> {
    let n = matrix.nrows();
    let scale: Vec<f64> = (0..n).map(|i| matrix[(i, i)].sqrt().recip()).collect();
    // The last unknowns come first: those are the drives, whose coordinates then move no body.
    let back = |i: usize| n - 1 - i;
    let scaled = Mat::from_fn(n, n, |i, j| {
        matrix[(back(i), back(j))] * scale[back(i)] * scale[back(j)]
    });
    let factor = scaled.llt(faer::Side::Lower).ok()?;
    let inverse = factor.L().to_owned().partial_piv_lu().inverse();
    let entry = |k: usize, i: usize| {
        if back(i) <= k {
            scale[i] * inverse[(k, back(i))]
        } else {
            0.0
        }
    };
    let directions: Vec<Vec<f64>> = (0..n)
        .map(|k| (0..n).map(|i| entry(k, i)).collect())
        .collect();
    let is_finite = directions.iter().flatten().all(|own| own.is_finite());
    is_finite.then_some(directions)
}
