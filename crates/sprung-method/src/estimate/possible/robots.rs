//! The robots that can exist, as a convex set.

use sprung_core::friction::{Conditions, Law};
use sprung_core::parameters::{JointParameter, Side};
use sprung_core::spatial::BODY;

use super::prior::{Beside, BodyPrior, add_prior, impossible, priors, regions_of};
use crate::description::Physical;
use crate::model::{
    Block, Entry, Model, NoSolution, Parameter, Program, Region, Theta, TreeLinks, second_moments,
};

/// Velocities at which a sum of friction laws must take energy, over the largest of the log.
const VELOCITIES: [f64; 7] = [0.01, 0.03, 0.1, 0.2, 0.4, 0.7, 1.0];

/// Robots that can exist: possible bodies, positive rotor inertias, stiffnesses and dampings,
/// friction that takes energy. The unknowns are the inertial parameters of all links and rotors that are not
/// given, then the other parameters of theta.
pub(in crate::estimate) struct Robots<'a> {
    pub(in crate::estimate) model: &'a Model,
    /// Standard index of each of the first unknowns; the others are parameters of theta.
    pub(in crate::estimate) standard: Vec<usize>,
    /// Prior of each link, then of each rotor; empty for a robot in closed form.
    pub(in crate::estimate) priors: Vec<BodyPrior>,
    /// Links whose nominal bodies cannot exist.
    pub(in crate::estimate) impossible_nominal: Vec<String>,
    /// Links whose nominal bodies lie outside their geometry.
    pub(in crate::estimate) outside: Vec<String>,
    /// Indices in theta of the other unknowns.
    pub(in crate::estimate) others: Vec<usize>,
    /// Condition of each block, as the subject of a sentence.
    subjects: Vec<String>,
    /// Change of theta by each unknown, \[p\] each.
    pub(in crate::estimate) columns: Vec<Theta>,
    /// Theta without the unknowns.
    pub(in crate::estimate) constant: Theta,
    /// Bodies of the prior; zeros for the other unknowns.
    pub(in crate::estimate) start: Vec<f64>,
    /// The prior as a program without a log.
    pub(in crate::estimate) prior: Program,
}

impl<'a> Robots<'a> {
    /// - `near`: an estimate, for the size of bodies without nominal values, \[p\].
    pub(in crate::estimate) fn new(
        model: &'a Model,
        settings: &Physical,
        near: &[f64],
        beside: Beside<'_>,
    ) -> Self {
        let p = model.parameters().len();
        let links = model.links();
        let standard: Vec<usize> = links.map_or_else(Vec::new, |links| {
            let all = 0..links.standard();
            all.filter(|index| !links.known.contains_key(index))
                .collect()
        });
        let is_other = |(_, parameter): &(usize, &Parameter)| {
            let of_bodies = match parameter.joint {
                None | Some((JointParameter::RotorInertia, _)) => links.is_some(),
                Some(_) => false,
            };
            parameter.fixed.is_none() && !of_bodies
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
        let n = columns.len();
        let mut robots = Self {
            model,
            standard,
            priors: Vec::new(),
            impossible_nominal: links.map_or_else(Vec::new, |links| impossible(model, links)),
            outside: Vec::new(),
            others,
            subjects: Vec::new(),
            columns,
            constant: (model.parameters().iter())
                .map(|parameter| parameter.fixed.unwrap_or(0.0))
                .collect(),
            start: vec![0.0; n],
            prior: Program {
                quadratic: vec![0.0; n * n],
                linear: vec![0.0; n],
                blocks: Vec::new(),
            },
        };
        if let Some(links) = links {
            robots.add_bodies(links, near, (settings, beside));
            robots.add_masses(links, settings);
        } else {
            robots.add_planar();
        }
        robots.add_drives();
        match beside {
            Beside::Estimate => (),
            Beside::Log(speeds, _) | Beside::Draws(speeds, _) => robots.add_friction(speeds),
        }
        robots
    }

    /// Returns the parameters of a robot, \[p\].
    pub(super) fn theta(&self, x: &[f64]) -> Theta {
        let mut theta = self.constant.clone();
        for (column, x) in self.columns.iter().zip(x) {
            for (value, by) in theta.iter_mut().zip(column) {
                *value += x * by;
            }
        }
        theta
    }

    /// Returns the reason why there is no such robot, as a sentence without a full stop.
    pub(in crate::estimate) fn why(&self, reason: NoSolution) -> String {
        match reason {
            NoSolution::Contradiction(block) => format!(
                "{} cannot be positive together with the others",
                self.subjects[block]
            ),
            NoSolution::Singular => "the search failed".to_owned(),
        }
    }

    fn add(&mut self, block: Block, subject: String) {
        self.prior.blocks.push(block);
        self.subjects.push(subject);
    }

    /// Adds the bodies and rotors of a tree with their regions and priors.
    fn add_bodies(&mut self, links: &TreeLinks, near: &[f64], settings: (&Physical, Beside<'_>)) {
        let n = self.model.joint_count();
        let size = (near.iter().zip(self.model.parameters()))
            .filter(|(_, parameter)| parameter.joint.is_none())
            .fold(1e-3_f64, |max, (value, _)| max.max(value.abs()));
        self.priors = priors(self.model, links, settings, size);
        let regions = match settings.1 {
            Beside::Estimate => vec![None; n],
            Beside::Log(_, tool) | Beside::Draws(_, tool) => regions_of(links, tool),
        };
        let known = |index: usize| links.known.get(&index).copied().unwrap_or(0.0);
        let mut added = Vec::new();
        for (at, prior) in self.priors.iter().enumerate() {
            let (first, count) = match at.checked_sub(n) {
                None => (at * BODY, BODY),
                Some(joint) => (n * BODY + joint, 1),
            };
            let unknown = |index: usize| self.standard.binary_search(&index).ok();
            let unknowns: Vec<Option<usize>> = (first..first + count).map(unknown).collect();
            if unknowns.iter().all(Option::is_none) {
                continue;
            }
            let name = links.name(first);
            let (mut block, subject) = if count == BODY {
                let link = name.strip_suffix(".m").unwrap_or(name);
                let fits = |region: &Region| !prior.is_nominal || region.holds(&prior.values);
                if regions[at].is_some_and(|region| region.of_geometry && !fits(&region)) {
                    self.outside.push(link.to_owned());
                }
                if let Some(region) = regions[at].filter(fits) {
                    let factors = region.factors();
                    let (mut constant, mut terms) = (0.0, Vec::new());
                    for (k, (unknown, factor)) in unknowns.iter().zip(factors).enumerate() {
                        match unknown {
                            Some(unknown) => terms.push((*unknown, factor)),
                            None => constant += factor * known(first + k),
                        }
                    }
                    let region = Block::scalar(constant, terms);
                    added.push((region, format!("the mass of {link} inside its region")));
                }
                let moments = second_moments(|k| unknowns[k].ok_or_else(|| known(first + k)));
                (moments, format!("the second moments of the mass of {link}"))
            } else {
                let scalar = Block::scalar(0.0, unknowns[0].map(|unknown| (unknown, 1.0)));
                (scalar, name.to_owned())
            };
            for (unknown, value) in unknowns.iter().zip(&prior.values) {
                if let Some(unknown) = unknown {
                    self.start[*unknown] = *value;
                }
            }
            add_prior(&mut self.prior, &mut block, prior, &unknowns, settings);
            added.push((block, subject));
        }
        for (block, subject) in added {
            self.add(block, subject);
        }
    }

    /// Adds the limits of masses.
    fn add_masses(&mut self, links: &TreeLinks, settings: &Physical) {
        for limit in mass_limits(links, self.model.joint_count(), settings) {
            let (known, unknowns) = self.parts_of(links, &limit.masses);
            let [least, largest] = limit.range;
            let terms = |by: f64| unknowns.iter().map(move |&unknown| (unknown, by));
            self.add(
                Block::scalar(known - least, terms(1.0)),
                format!("{} above {least} kg", limit.subject),
            );
            self.add(
                Block::scalar(largest - known, terms(-1.0)),
                format!("{} below {largest} kg", limit.subject),
            );
        }
    }

    /// Returns the sum of the given ones among masses, kg, and the unknowns of the others.
    fn parts_of(&self, links: &TreeLinks, masses: &[usize]) -> (f64, Vec<usize>) {
        let known = masses.iter().filter_map(|index| links.known.get(index));
        let unknowns = masses
            .iter()
            .filter_map(|index| self.standard.binary_search(index).ok());
        (known.sum(), unknowns.collect())
    }

    /// Returns the limits of masses that a robot exceeds, with its masses, kg.
    ///
    /// - `x`: unknowns of the robot.
    pub(in crate::estimate) fn exceeded(
        &self,
        settings: &Physical,
        x: &[f64],
    ) -> Vec<(MassLimit, f64)> {
        let Some(links) = self.model.links() else {
            return Vec::new();
        };
        let with_mass = |limit: MassLimit| {
            let (known, unknowns) = self.parts_of(links, &limit.masses);
            let mass = known + unknowns.iter().map(|unknown| x[*unknown]).sum::<f64>();
            (limit, mass)
        };
        let all = mass_limits(links, self.model.joint_count(), settings);
        (all.into_iter().map(with_mass))
            .filter(|(limit, mass)| *mass < limit.range[0] || *mass > limit.range[1])
            .collect()
    }

    /// Adds the bodies of the paper's arm: `theta1 - theta3` and `theta3` are inertias of two bodies
    /// that `theta2` couples.
    fn add_planar(&mut self) {
        let unknown = |index: usize| self.others.iter().position(|other| *other == index);
        let entries: [Vec<Entry>; 3] = [
            vec![Entry::at(0, 0, 1.0)],
            vec![Entry::at(0, 1, 1.0)],
            vec![Entry::at(0, 0, -1.0), Entry::at(1, 1, 1.0)],
        ];
        let mut block = Block::new(2, Vec::new());
        for (index, entry) in entries.into_iter().enumerate() {
            match unknown(index) {
                Some(unknown) => block.terms.push((unknown, entry)),
                None => block.add_constant(&entry, self.constant[index]),
            }
        }
        if !block.terms.is_empty() {
            self.add(block, "the inertia of the links".to_owned());
        }
    }

    /// Adds the parameters that are no part of bodies: positive stiffnesses, and friction that takes
    /// energy.
    fn add_drives(&mut self) {
        for at in 0..self.others.len() {
            let parameter = &self.model.parameters()[self.others[at]];
            if must_be_positive(parameter) {
                let block = Block::scalar(0.0, [(self.standard.len() + at, 1.0)]);
                let name = parameter.name.clone();
                self.add(block, name);
            }
        }
    }

    /// Adds the sums of friction laws of which some may be negative: the sum takes energy at every velocity of the
    /// log.
    fn add_friction(&mut self, speeds: &[f64]) {
        for (joint, speed) in speeds.iter().enumerate() {
            for side in [Side::Link, Side::Motor] {
                let Some(laws) = sum_of_laws(self.model, joint, side) else {
                    continue;
                };
                let name = format!("{} friction of {}", side.name(), self.model.joints()[joint]);
                for velocity in VELOCITIES.iter().flat_map(|v| [v * speed, -v * speed]) {
                    let at = Conditions::sliding(velocity, 0.0);
                    let shape = self.model.shape(joint);
                    let sign = velocity.signum();
                    let (mut known, mut terms) = (0.0, Vec::new());
                    for (index, law) in &laws {
                        let torque = sign * law.column(&at, shape);
                        match self.others.binary_search(index) {
                            Ok(at) => terms.push((self.standard.len() + at, torque)),
                            Err(_) => known += torque * self.constant[*index],
                        }
                    }
                    self.add(Block::scalar(known, terms), name.clone());
                }
            }
        }
    }
}

/// Returns whether friction of a joint has a law that may be negative, so that only the sum of its laws takes energy.
pub(in crate::estimate) fn has_sum(model: &Model, joint: usize) -> bool {
    let mut sides = [Side::Link, Side::Motor].into_iter();
    sides.any(|side| sum_of_laws(model, joint, side).is_some())
}

/// Returns the friction laws of a side of a joint with their indices in theta if one of them may be negative.
fn sum_of_laws(model: &Model, joint: usize, side: Side) -> Option<Vec<(usize, Law)>> {
    let laws: Vec<(usize, Law)> = Law::all()
        .filter(|law| *law != Law::Offset)
        .filter_map(|law| {
            Some((
                model.index(JointParameter::Friction(side, law), joint)?,
                law,
            ))
        })
        .collect();
    let may_be_negative = laws.iter().any(|(_, law)| !law.takes_energy());
    may_be_negative.then_some(laws)
}

/// A limit of the mass of links.
pub(in crate::estimate) struct MassLimit {
    /// "the total mass", or "the mass of" a link.
    pub(in crate::estimate) subject: String,
    /// Standard indices of the masses.
    masses: Vec<usize>,
    /// Least and largest mass, kg.
    pub(in crate::estimate) range: [f64; 2],
}

/// - `count`: number of links.
fn mass_limits(links: &TreeLinks, count: usize, settings: &Physical) -> Vec<MassLimit> {
    let all: Vec<usize> = (0..count).map(|link| link * BODY).collect();
    let total = settings.total_mass_kg.map(|range| MassLimit {
        subject: "the total mass".to_owned(),
        masses: all.clone(),
        range,
    });
    let single = settings.mass_kg.iter().map(|(name, range)| MassLimit {
        subject: format!("the mass of {name}"),
        masses: (all.iter().copied())
            .filter(|index| links.name(*index).strip_suffix(".m") == Some(name))
            .collect(),
        range: *range,
    });
    total.into_iter().chain(single).collect()
}

/// Returns whether a negative value of a parameter of a drive is impossible.
pub(in crate::estimate) fn must_be_positive(parameter: &Parameter) -> bool {
    parameter
        .joint
        .is_some_and(|(kind, _)| kind.is_vital() || kind.is_friction())
}
