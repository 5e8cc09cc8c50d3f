//! The posterior of an identification.

use rayon::prelude::*;
use sprung_core::spatial::BODY;

use super::centre::{borders_of, centre, start};
use super::chains::{Chains, Drawn};
use super::density::Density;
use super::errors::PosteriorError;
use super::evidence::Evidence;
use super::normal::{Normal, bodies};
use super::plain::Plain;
use super::rest::Rest;
use super::samples::{DrawMethod, Samples};
use crate::description::Physical;
use crate::estimate::possible::{Beside, Robots, Tool};
use crate::estimate::result::EstimateResult;
use crate::model::{Model, Region, Theta, TreeLinks};

/// Largest number of robots of one call: their parameters take some hundred megabytes.
const MAX_ROBOTS: usize = 100_000;

/// The posterior of an identification: a normal distribution over the robots that can exist.
#[derive(Clone, Debug)]
pub struct Posterior {
    density: Density,
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
    /// - `model`: the robot with the laws of the identification; `settings`: information of the experiment about its
    ///   bodies.
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
            .map(|parameter| values.get(&parameter.name).copied().unwrap_or(0.0))
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
            let name = |index: usize| links.map(|links| links.name(index).to_owned());
            (0..count).filter_map(name).collect::<Vec<_>>()
        };
        let standard = links.map_or(0, TreeLinks::standard);
        let constants = (values.into_iter())
            .filter(|(name, _)| result.parameter(name).is_none())
            .collect();
        Ok(Self {
            empty: Samples {
                parameters: (model.parameters().iter())
                    .map(|parameter| parameter.name.clone())
                    .collect(),
                theta: Vec::new(),
                standard_parameters: names(standard),
                standard: Vec::new(),
                links: links.map_or_else(Vec::new, |links| links.tree.links.clone()),
                undetermined: rest.undetermined,
                undetermined_standard: normal.undetermined(&robots),
                constants,
                method: DrawMethod::Rejection { accepted: 0.0 },
                effective: 0.0,
            },
            standard: (0..standard)
                .map(|index| links.and_then(|links| links.known.get(&index).copied()))
                .map(Option::unwrap_or_default)
                .collect(),
            density: Density {
                mean: normal.mean,
                precision: normal.precision,
                blocks: borders_of(&robots),
                centre,
                columns: robots.columns,
                constant: robots.constant,
            },
            places: robots.standard,
        })
    }

    /// Draws robots. The same seed gives the same robots, on any number of threads.
    ///
    /// - `count`: number of robots, 1 to 100 000.
    ///
    /// # Errors
    ///
    /// [`PosteriorError::Count`] for another number.
    pub fn sample(&self, count: usize, seed: u64) -> Result<Samples, PosteriorError> {
        if count == 0 || count > MAX_ROBOTS {
            return Err(PosteriorError::Count {
                count,
                most: MAX_ROBOTS,
            });
        }
        let plain = Plain::new(&self.density).and_then(|plain| plain.draw(count, seed));
        let Drawn {
            unknowns,
            method,
            effective,
        } = match plain {
            Some((unknowns, accepted)) => Drawn {
                unknowns,
                method: DrawMethod::Rejection { accepted },
                effective: count as f64,
            },
            None => Chains::new(&self.density).draw(count, seed),
        };
        let theta = unknowns.par_iter().map(|x| self.density.theta(x)).collect();
        let standard = unknowns.par_iter().map(|x| self.standard(x)).collect();
        Ok(Samples {
            theta,
            standard,
            method,
            effective,
            ..self.empty.clone()
        })
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

/// Speed of a joint without one, rad/s (m/s).
const ORDINARY_SPEED: f64 = 1.0;

/// Returns the speeds up to which sums of friction laws take energy, rad/s (m/s), \[n\]. Results of earlier
/// versions have none.
fn speeds(model: &Model, result: &EstimateResult) -> Vec<f64> {
    (model.joints().iter())
        .map(|name| {
            let speed = result.friction_speed.get(name);
            speed.unwrap_or(ORDINARY_SPEED)
        })
        .collect()
}

/// Returns the places of the masses of links without a child joint in the estimate.
fn tool(model: &Model, result: &EstimateResult) -> Tool {
    let Some(tree) = model.tree() else {
        return Tool::InRegion;
    };
    let bodies = result.standard_parameters.chunks_exact(BODY);
    let mut links = Region::all(tree).into_iter().zip(bodies).enumerate();
    let is_outside = links.any(|(link, (region, body))| {
        let carries = tree.joints.iter().any(|joint| joint.parent == Some(link));
        let body: Vec<f64> = body.iter().map(|parameter| parameter.value).collect();
        !carries && region.is_some_and(|region| !region.holds(&body))
    });
    if is_outside {
        Tool::Anywhere
    } else {
        Tool::InRegion
    }
}
