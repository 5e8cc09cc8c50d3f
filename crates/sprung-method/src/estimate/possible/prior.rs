//! Prior of the bodies: the nominal values, and how far they may be from the truth.

use sprung_core::spatial::BODY;

use crate::description::{Distance, Physical, Prior};
use crate::model::{Block, Model, Program, Region, TreeLinks, is_possible, second_moments};

/// Least eigenvalue of the second moments of a nominal body relative to their trace. Thinner bodies
/// would make the entropic distance infinite in one direction.
const THINNEST: f64 = 1e-4;

/// Weight of the prior beside the log where the log decides. Nominal values that are wrong by three of their errors then
/// move a parameter that the log determines as well as they do by a thirtieth of its standard error.
pub(in crate::estimate) const BESIDE_LOG: f64 = 1e-2;

/// Relative error of the body of a link without nominal values.
const ERROR_OF_COMPACT_BODY: f64 = 1.0;

/// Radius of the ball that a link without nominal values is, over that of its region. A third of the length is usual
/// for the modules of cobots.
const COMPACT: f64 = 1.0 / 3.0;

/// Density of this ball, kg/m³: that of water, between hollow castings and steel.
const DENSITY: f64 = 1000.0;

/// Prior of one link, or of one rotor.
#[derive(Clone, Debug)]
pub(in crate::estimate) struct BodyPrior {
    /// Most likely values: the ten inertial parameters, or the rotor inertia alone.
    pub(in crate::estimate) values: Vec<f64>,
    /// Whether they are nominal values.
    pub(in crate::estimate) is_nominal: bool,
}

/// Returns the prior of each link, then of each rotor.
///
/// - `regions`: of the links.
pub(super) fn priors(
    model: &Model,
    links: &TreeLinks,
    settings: &Physical,
    regions: &[Region],
) -> Vec<BodyPrior> {
    let n = model.joint_count();
    let nominal = |index: usize| match settings.prior {
        Prior::Nominal => links.nominal(index),
        Prior::None => links.known.get(&index).copied(),
    };
    let compact: Vec<[f64; BODY]> = regions.iter().map(ball).collect();
    let of_links = (0..n).map(|link| {
        let values: Option<Vec<f64>> = (0..BODY).map(|k| nominal(link * BODY + k)).collect();
        let possible = values.filter(|own| {
            let body: Result<[f64; BODY], _> = own.as_slice().try_into();
            body.is_ok_and(|body| is_possible(&body, THINNEST))
        });
        BodyPrior {
            is_nominal: possible.is_some(),
            values: possible.unwrap_or_else(|| compact[link].to_vec()),
        }
    });
    let rotors = (0..n).map(|joint| {
        let own = nominal(n * BODY + joint).filter(|value| *value > 0.0);
        BodyPrior {
            is_nominal: own.is_some(),
            values: vec![own.unwrap_or(compact[joint][BODY - 1])],
        }
    });
    of_links.chain(rotors).collect()
}

/// Returns the inertial parameters of a compact ball at the centre of a region.
fn ball(region: &Region) -> [f64; BODY] {
    let radius = COMPACT * region.radius;
    let mass = DENSITY * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let c = region.centre;
    let squares: f64 = c.iter().map(|x| x * x).sum();
    let own = 0.4 * radius * radius;
    let inertia = |i: usize, j: usize| {
        let diagonal = if i == j { own + squares } else { 0.0 };
        mass * (diagonal - c[i] * c[j])
    };
    [
        mass,
        mass * c[0],
        mass * c[1],
        mass * c[2],
        inertia(0, 0),
        inertia(0, 1),
        inertia(1, 1),
        inertia(0, 2),
        inertia(1, 2),
        inertia(2, 2),
    ]
}

/// Returns the names of links whose nominal bodies are given but cannot exist.
pub(super) fn impossible(model: &Model, links: &TreeLinks) -> Vec<String> {
    (0..model.joint_count())
        .filter(|link| {
            let values: Option<Vec<f64>> =
                (0..BODY).map(|k| links.nominal(link * BODY + k)).collect();
            let body: Option<[f64; BODY]> = values.and_then(|own| own.try_into().ok());
            body.is_some_and(|body| !is_possible(&body, THINNEST))
        })
        .map(|link| {
            let name = links.name(link * BODY);
            name.strip_suffix(".m").unwrap_or(name).to_owned()
        })
        .collect()
}

/// Adds the prior of a body to a program.
///
/// - `block`: the second moments of the body in the program, or its rotor inertia.
/// - `unknowns`: unknown of each parameter of the body; `None` for known values.
/// - `settings`, and the weight of the prior beside the log.
pub(super) fn add_prior(
    program: &mut Program,
    block: &mut Block,
    prior: &BodyPrior,
    unknowns: &[Option<usize>],
    (settings, weight_of_prior): (&Physical, f64),
) {
    let relative = if prior.is_nominal {
        settings.prior_error
    } else {
        ERROR_OF_COMPACT_BODY
    };
    let quadratic = prior.is_nominal && settings.distance == Distance::Euclidean;
    // A body whose mass is wrong by the relative error is one standard error away. Beside the Euclidean distance the
    // entropic one only keeps the body possible.
    let relative_of_entropy = if quadratic {
        ERROR_OF_COMPACT_BODY
    } else {
        relative
    };
    // A compact body is a guess, so it never stands against the log.
    let weight = if prior.is_nominal && !quadratic {
        weight_of_prior
    } else {
        BESIDE_LOG
    };
    let weight = weight / (block.rows as f64 * relative_of_entropy.powi(2));
    block.entropy = weight;
    let own = match prior.values.len() {
        BODY => second_moments(|k| Err(prior.values[k])),
        _ => Block::scalar(prior.values[0], []),
    };
    if let Some(inverse) = own.inverse(&[]) {
        for (unknown, entries) in &block.terms {
            let slope: f64 = (entries.iter())
                .map(|&(i, j, by)| {
                    let both = if i == j { 1.0 } else { 2.0 };
                    both * by * inverse[i * block.rows + j]
                })
                .sum();
            program.linear[*unknown] -= weight * slope;
        }
    }
    if !quadratic {
        return;
    }
    let n = program.linear.len();
    let scales = scales(&prior.values);
    for ((unknown, value), scale) in unknowns.iter().zip(&prior.values).zip(scales) {
        let Some(unknown) = unknown else { continue };
        let weight = weight_of_prior * (relative * scale).powi(-2);
        program.quadratic[unknown * (n + 1)] += weight;
        program.linear[*unknown] += weight * value;
    }
}

/// Returns the sizes of the parameters of a body: m, m·L and m·L², with its root mean square radius L;
/// the rotor inertia itself.
fn scales(values: &[f64]) -> Vec<f64> {
    if values.len() != BODY {
        return values.to_vec();
    }
    let mass = values[0];
    let length = (0.5 * (values[4] + values[6] + values[9]) / mass).sqrt();
    (0..BODY)
        .map(|k| match k {
            0 => mass,
            1..=3 => mass * length,
            _ => mass * length * length,
        })
        .collect()
}
