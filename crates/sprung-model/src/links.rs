//! Link parameters of a tree: which are in theta, and the values of the others.

use std::collections::BTreeMap;

use sprung_core::chain::Chain;
use sprung_core::friction::Law;
use sprung_core::parameters::{JointParameter, Side};
use sprung_core::spatial::{BODY, BODY_NAMES, BODY_UNITS};

use super::ModelError;
use super::base_parameters::{BaseParameters, Candidates};
use crate::description::{Joint, Robot, Tree};

/// The constant torque of a motor.
pub(super) const OFFSET: JointParameter = JointParameter::Friction(Side::Motor, Law::Offset);

/// Returns whether a joint is rigid and its motor has an unknown constant torque.
fn has_offset(joint: &Joint) -> bool {
    let mut laws = joint.motor_laws().iter();
    !joint.is_flexible() && laws.any(|law| law.columns().contains(&Law::Offset))
}

/// The links of a tree with their inertial parameters in theta.
#[derive(Clone, Debug)]
pub struct TreeLinks {
    /// The tree.
    pub tree: Tree,
    /// Acceleration of free fall in the base frame, m/s².
    pub gravity: [f64; 3],
    /// Base parameters among the unknown parameters.
    pub base: BaseParameters,
    /// Standard index of each link parameter in theta, link by link.
    pub selected: Vec<usize>,
    /// Known values by standard index; parameters with the value zero have no column.
    pub known: BTreeMap<usize, f64>,
    names: Vec<String>,
    nominal: Vec<Option<f64>>,
}

impl TreeLinks {
    /// Finds the base parameters of a tree.
    ///
    /// # Errors
    ///
    /// [`ModelError::UnknownParameter`] for a name in `assume_zero` that is no link parameter.
    pub(super) fn new(
        robot: &Robot,
        tree: &Tree,
        coupling: Option<&[f64]>,
    ) -> Result<Self, ModelError> {
        let n = tree.joints.len();
        let links = tree.links.iter();
        let mut names: Vec<String> = links
            .flat_map(|link| BODY_NAMES.map(|name| format!("{link}.{name}")))
            .collect();
        names.extend((robot.joint.iter()).map(|joint| format!("{}.rotor_inertia", joint.name)));
        let offset: Vec<bool> = robot.joint.iter().map(has_offset).collect();
        let of_motors = robot.joint.iter().zip(&offset);
        names.extend(of_motors.map(|(joint, has)| match has {
            true => format!("{}.{}", joint.name, OFFSET.name()),
            false => String::new(),
        }));
        let mut known = BTreeMap::new();
        for (i, _) in (robot.joint.iter().enumerate()).filter(|(_, joint)| joint.is_on_link_side())
        {
            known.insert(n * BODY + i, 0.0);
        }
        for name in &robot.assume_zero {
            let index = names[..n * BODY].iter().position(|known| known == name);
            let index = index.ok_or_else(|| ModelError::unknown(name, names[..n * BODY].iter()))?;
            known.insert(index, 0.0);
        }
        for (name, value) in &robot.fixed {
            // A known rotor inertia is not combined with a link parameter.
            if let Some(index) = names.iter().position(|known| known == name) {
                known.insert(index, *value);
            }
        }
        let candidates = Candidates {
            chain: Chain::new(&tree.joints, robot.gravity()).map_err(ModelError::Chain)?,
            coupling,
            rigid: &(robot.joint.iter())
                .map(|joint| !joint.is_flexible())
                .collect::<Vec<_>>(),
            offset: &offset,
            known: &known.keys().copied().collect::<Vec<_>>(),
        };
        let base = BaseParameters::new(&candidates).map_err(ModelError::Length)?;
        let mut selected: Vec<usize> = (base.independent.iter().copied())
            .chain(known.iter().filter(|(_, v)| **v != 0.0).map(|(k, _)| *k))
            .filter(|index| *index < n * BODY)
            .collect();
        selected.sort_unstable();
        let nominal = (tree.inertial.iter())
            .flat_map(|body| (0..BODY).map(move |k| body.map(|body| body[k])))
            .chain(
                (robot.joint.iter()).map(|joint| joint.nominal.get(JointParameter::RotorInertia)),
            )
            .chain(robot.joint.iter().map(|joint| joint.nominal.get(OFFSET)))
            .enumerate()
            .map(|(index, value)| robot.nominal.get(&names[index]).copied().or(value))
            .collect();
        Ok(Self {
            gravity: robot.gravity(),
            tree: tree.clone(),
            selected,
            base,
            known,
            names,
            nominal,
        })
    }

    /// Returns the index of a standard parameter among the base parameters.
    fn base_of(&self, index: usize) -> Option<usize> {
        self.base
            .independent
            .iter()
            .position(|other| *other == index)
    }

    /// Returns the name of a link parameter of theta with its combination.
    pub(super) fn words(&self, parameter: usize) -> String {
        self.words_of(self.selected[parameter])
    }

    /// Returns the name of a standard parameter with all parameters that are combined with it.
    pub(super) fn words_of(&self, index: usize) -> String {
        match self.base_of(index) {
            Some(base) => self.base.words(base, |k| self.names[k].clone()),
            None => self.names[index].clone(),
        }
    }

    /// Returns whether a joint's rotor inertia is a separate parameter.
    pub(super) fn has_rotor(&self, joint: usize) -> bool {
        let index = self.tree.joints.len() * BODY + joint;
        self.base_of(index).is_some() || self.known.contains_key(&index)
    }

    /// Returns the index of the constant torque of a rigid joint's motor, if that torque is combined with other
    /// parameters.
    pub(super) fn combined_offset(&self, joint: usize) -> Option<usize> {
        let index = self.tree.joints.len() * (BODY + 1) + joint;
        let base = self.base_of(index)?;
        (!self.base.is_alone(base)).then_some(index)
    }

    /// Returns the name of a standard parameter.
    #[must_use]
    pub fn name(&self, index: usize) -> &str {
        &self.names[index]
    }

    /// Returns the unit of a standard parameter.
    #[must_use]
    pub fn unit(&self, index: usize) -> &'static str {
        if index < self.tree.joints.len() * BODY {
            BODY_UNITS[index % BODY]
        } else {
            "kg·m²"
        }
    }

    /// Returns the nominal value of a standard parameter.
    #[must_use]
    pub fn nominal(&self, index: usize) -> Option<f64> {
        match self.known.get(&index) {
            Some(value) => Some(*value),
            None => self.nominal[index],
        }
    }

    /// Returns the nominal value of a parameter of theta from its standard index, without rotors and
    /// without bodies that have no nominal value.
    pub(super) fn of_bodies(&self, index: usize) -> f64 {
        let bodies = self.tree.joints.len() * BODY;
        let body = |k: usize| if k < bodies { self.nominal(k) } else { None };
        self.lumped(index, |k| Some(body(k).unwrap_or(0.0)))
            .unwrap_or(0.0)
    }

    /// Returns the base parameters that contain a dependent parameter, as standard indices, each with
    /// the factor of the dependent parameter.
    pub(super) fn shares_of(&self, index: usize) -> Vec<(usize, f64)> {
        let Some(at) = self.base.dependent.iter().position(|other| *other == index) else {
            return Vec::new();
        };
        (self.base.independent.iter().zip(&self.base.combination))
            .map(|(&independent, shares)| (independent, shares[at]))
            .filter(|(_, share)| *share != 0.0)
            .collect()
    }

    /// Returns the number of standard parameters of links and rotors; rotors are last.
    #[must_use]
    pub fn standard(&self) -> usize {
        self.tree.joints.len() * (BODY + 1)
    }

    /// Returns the index of a standard parameter by its name.
    pub(super) fn index_of(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| known == name)
    }

    /// Returns the value of a parameter of theta from standard values; `None` if a value in its
    /// combination is unknown.
    ///
    /// - `index`: standard index of the parameter.
    /// - `value`: returns the value of a standard parameter from its index.
    pub(super) fn lumped(&self, index: usize, value: impl Fn(usize) -> Option<f64>) -> Option<f64> {
        let Some(base) = self.base_of(index) else {
            return value(index);
        };
        let mut sum = value(index)?;
        for (&k, &share) in self.base.dependent.iter().zip(&self.base.combination[base]) {
            if share != 0.0 {
                sum += share * value(k)?;
            }
        }
        Some(sum)
    }
}
