//! Prior of the bodies: the nominal values and their errors.

use sprung_core::spatial::BODY;

use crate::description::{Distance, Physical, Prior};
use crate::model::{Block, Entry, Model, Program, Region, TreeLinks, is_possible, second_moments};

/// Least eigenvalue of the second moments of a nominal body relative to their trace. Thinner bodies
/// would make the entropic distance infinite in one direction.
const THINNEST: f64 = 1e-4;

/// Weight of the entropic distance from bodies of equal size in all directions, without a nominal body, and with the
/// Euclidean distance. It decides only directions that the log does not determine.
const WEIGHT_WITHOUT_NOMINAL: f64 = 1e-3;

/// Weight of nominal values beside a log where the log decides. A parameter that the log determines as accurately as
/// the prior then moves by a thirtieth of its standard error, if the prior is wrong by three of its errors.
const WHERE_LOG_DECIDES: f64 = 1e-2;

/// Mass of a link of a cobot with a region of this radius, kg and m: links of arms of 0.5 to 1.5 m reach have 1 to 5 kg.
const ORDINARY_MASS: f64 = 2.0;
const ORDINARY_REGION: f64 = 0.25;

/// Radius of a link without a region, m, and reflected inertia of a rotor, kg·m²: those of a cobot's wrist.
const ORDINARY_RADIUS: f64 = 0.1;
const ORDINARY_ROTOR: f64 = 0.1;

/// Radius of a compact body over that of its region. Draws use the whole region: a compact body would keep the centre
/// of mass near that of the region.
const COMPACT: f64 = 0.5;

/// Weight of the entropic distance from ordinary bodies and rotors where robots are drawn: the error of each mass and each
/// rotor inertia is as large as itself. Links of a cobot have 1 to 5 kg.
const ORDINARY: f64 = 1.0;

/// Where the mass of a link that carries no joint may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::estimate) enum Tool {
    /// In the region of the link, which leaves room for a tool.
    InRegion,
    /// Anywhere.
    Anywhere,
}

/// Information that prior and regions of the links complement.
#[derive(Clone, Copy, Debug)]
pub(in crate::estimate) enum Beside<'a> {
    /// Bodies of a finished estimate: nominal values count with their errors.
    Estimate,
    /// A log with these largest speeds of the joints, rad/s (m/s), \[n\]. The log decides: nominal values count a
    /// hundred times less, masses lie in the regions of their links, and sums of friction laws take energy.
    Log(&'a [f64], Tool),
    /// Draws of robots, with the set of robots of `Log`: nominal values count with their errors, other bodies are ordinary
    /// ones with errors as large as themselves.
    Draws(&'a [f64], Tool),
}

impl Beside<'_> {
    fn weight(self) -> f64 {
        match self {
            Self::Estimate | Self::Draws(..) => 1.0,
            Self::Log(..) => WHERE_LOG_DECIDES,
        }
    }

    /// Returns the weight of the entropic distance from a body that is no nominal one.
    fn weight_without_nominal(self) -> f64 {
        match self {
            Self::Estimate | Self::Log(..) => WEIGHT_WITHOUT_NOMINAL,
            Self::Draws(..) => ORDINARY,
        }
    }
}

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
/// - `size`: typical size of the link parameters, kg·m².
pub(super) fn priors(
    model: &Model,
    links: &TreeLinks,
    (settings, beside): (&Physical, Beside<'_>),
    size: f64,
) -> Vec<BodyPrior> {
    let n = model.joint_count();
    let nominal = |index: usize| match settings.prior {
        Prior::Nominal => links.nominal(index),
        Prior::None => links.known.get(&index).copied(),
    };
    let regions = match beside {
        Beside::Estimate => vec![None; n],
        Beside::Log(_, tool) | Beside::Draws(_, tool) => regions_of(links, tool),
    };
    let links = (0..n).map(|link| {
        let values: Option<Vec<f64>> = (0..BODY).map(|k| nominal(link * BODY + k)).collect();
        let possible = values.filter(|values| {
            let body: Result<[f64; BODY], _> = values.as_slice().try_into();
            body.is_ok_and(|body| is_possible(&body, THINNEST))
        });
        match possible {
            Some(values) => BodyPrior {
                values,
                is_nominal: true,
            },
            None => BodyPrior {
                values: match beside {
                    Beside::Estimate => round([0.0; 3], size, size).to_vec(),
                    Beside::Log(..) => compact(regions[link].as_ref(), COMPACT).to_vec(),
                    Beside::Draws(..) => compact(regions[link].as_ref(), 1.0).to_vec(),
                },
                is_nominal: false,
            },
        }
    });
    let rotors = (0..n).map(|joint| {
        let given = nominal(n * BODY + joint).filter(|value| *value > 0.0);
        BodyPrior {
            values: vec![given.unwrap_or(match beside {
                Beside::Estimate => size,
                Beside::Log(..) | Beside::Draws(..) => ORDINARY_ROTOR,
            })],
            is_nominal: given.is_some(),
        }
    });
    links.chain(rotors).collect()
}

/// Returns the regions of all links.
pub(super) fn regions_of(links: &TreeLinks, tool: Tool) -> Vec<Option<Region>> {
    let joints = &links.tree.joints;
    let carries = |link: usize| joints.iter().any(|joint| joint.parent == Some(link));
    let all = Region::all(&links.tree).into_iter().enumerate();
    all.map(|(link, region)| region.filter(|_| tool == Tool::InRegion || carries(link)))
        .collect()
}

/// Returns a body of ordinary density: a ball about the centre of the link's region.
///
/// - `share`: radius over that of the region.
fn compact(region: Option<&Region>, share: f64) -> [f64; BODY] {
    let Some(region) = region else {
        return round(
            [0.0; 3],
            ORDINARY_MASS,
            ORDINARY_MASS * ORDINARY_RADIUS.powi(2) / 5.0,
        );
    };
    let size = region.ellipsoid.radius();
    let radius = share * size;
    // The regions of an arm are wider than its links, which are tubes with motors.
    let mass = ORDINARY_MASS * size / ORDINARY_REGION;
    round(region.ellipsoid.centre, mass, mass * radius.powi(2) / 5.0)
}

/// Returns a body with the same second moments about its centre in all directions.
fn round(centre: [f64; 3], mass: f64, moment: f64) -> [f64; BODY] {
    let [x, y, z] = centre;
    let inertia = |a: f64, b: f64| 2.0 * moment + mass * (a * a + b * b);
    [
        mass,
        mass * x,
        mass * y,
        mass * z,
        inertia(y, z),
        -mass * x * y,
        inertia(x, z),
        -mass * x * z,
        -mass * y * z,
        inertia(x, y),
    ]
}

/// Returns the names of links whose nominal bodies are given but cannot exist.
pub(super) fn impossible(model: &Model, links: &TreeLinks) -> Vec<String> {
    (0..model.joint_count())
        .filter(|link| {
            let values: Option<Vec<f64>> =
                (0..BODY).map(|k| links.nominal(link * BODY + k)).collect();
            let body: Option<[f64; BODY]> = values.and_then(|values| values.try_into().ok());
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
/// - `settings`, and the information that the prior complements.
pub(super) fn add_prior(
    program: &mut Program,
    block: &mut Block,
    prior: &BodyPrior,
    unknowns: &[Option<usize>],
    (settings, beside): (&Physical, Beside<'_>),
) {
    let relative = settings.prior_error;
    let quadratic = prior.is_nominal && settings.distance == Distance::Euclidean;
    // A body whose mass is wrong by the relative error is one standard error away.
    let weight = if prior.is_nominal && !quadratic {
        beside.weight() / (block.rows as f64 * relative * relative)
    } else if prior.is_nominal {
        WEIGHT_WITHOUT_NOMINAL
    } else {
        beside.weight_without_nominal()
    };
    block.entropy = weight;
    let prior_block = match prior.values.len() {
        BODY => second_moments(|k| Err(prior.values[k])),
        _ => Block::scalar(prior.values[0], []),
    };
    if let Some(inverse) = prior_block.inverse(&[]) {
        for (unknown, entries) in &block.terms {
            let slope: f64 = (entries.iter())
                .map(|&Entry { row, column, by }| {
                    let both = if row == column { 1.0 } else { 2.0 };
                    both * by * inverse[row * block.rows + column]
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
        let weight = beside.weight() * (relative * scale).powi(-2);
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
