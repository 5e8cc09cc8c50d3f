//! From the description of a robot to its parameters and equations.

mod base_parameters;
mod layout;
mod links;
mod scratch;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

use sprung_core::chain::{Chain, ChainError, JointKind};
use sprung_core::friction::{Law, Shape};
use sprung_core::links::LengthError;
use sprung_core::parameters::{JointParameter, Side};
use sprung_core::planar_2r::{INERTIAL, INERTIAL_NAMES};
use sprung_core::regressor::{Links, Robot, Values};
use sprung_core::spatial::BODY;

use crate::description::{self, Experiment, Tree};
use layout::Layout;

pub use base_parameters::{BaseParameters, Candidates};
pub use links::TreeLinks;
pub use scratch::Scratch;

/// A parameter vector theta, \[p\].
pub type Theta = Vec<f64>;

/// Stribeck velocity that stands in until a search has found one, rad/s.
const STRIBECK: f64 = 0.1;

/// One parameter of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name, as in `joint1.stiffness`, or `link1.izz + 0.1176*link2.m`.
    pub name: String,
    /// The paper's symbol, as in `theta10`.
    pub symbol: String,
    /// Unit.
    pub unit: &'static str,
    /// Value that the maker gives.
    pub nominal: Option<f64>,
    /// Value that is known and not estimated.
    pub fixed: Option<f64>,
    /// Kind and joint; nothing for a link inertial parameter.
    pub joint: Option<(JointParameter, usize)>,
}

impl Parameter {
    /// Returns whether the parameter takes energy out of the robot.
    #[must_use]
    pub fn is_friction(&self) -> bool {
        self.joint.is_some_and(|(kind, _)| kind.is_friction())
    }

    /// Returns whether a robot is one without it, as without friction, offset
    /// or preload.
    #[must_use]
    pub fn may_be_zero(&self) -> bool {
        self.joint.is_some_and(|(kind, _)| !kind.is_vital())
    }

    /// Returns the name, cut where a long combination of link parameters
    /// begins.
    #[must_use]
    pub fn short(&self) -> Cow<'_, str> {
        short(&self.name)
    }
}

/// Returns the name of a parameter, cut where a long combination begins.
#[must_use]
pub fn short(name: &str) -> Cow<'_, str> {
    const LONGEST: usize = 32;
    match name.split_once([' ']) {
        Some((first, _)) if name.chars().count() > LONGEST => Cow::Owned(format!("{first} + …")),
        _ => Cow::Borrowed(name),
    }
}

/// What is wrong with a robot or with a set of parameter values.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A name that the model does not have.
    #[error("the model has no parameter \"{name}\"{hint}")]
    UnknownParameter {
        /// The name.
        name: String,
        /// The nearest name, as a question, or nothing.
        hint: String,
    },
    /// Values that a simulation or a feedforward needs are not given.
    #[error("no value for {}; give it under nominal or in the parameter file", names.join(", "))]
    Missing {
        /// Names of the parameters.
        names: Vec<String>,
    },
    /// No robot has these values.
    #[error("{name} = {value:.4e} {unit} must be positive")]
    NotPositive {
        /// Name of the parameter.
        name: String,
        /// Its value.
        value: f64,
        /// Its unit.
        unit: &'static str,
    },
    /// The mass matrix is not positive definite.
    #[error("the link inertias ({values}) do not make a positive mass matrix{pose}")]
    MassMatrix {
        /// Link inertial parameters, or nothing said of them.
        values: String,
        /// Where it is not.
        pose: String,
    },
    /// The tree of joints is not one.
    #[error("{0}")]
    Chain(ChainError),
    /// Memory does not fit the robot.
    #[error("{0}")]
    Length(LengthError),
}

impl ModelError {
    fn unknown<'a>(name: &str, names: impl Iterator<Item = &'a String>) -> Self {
        let nearest = names.min_by_key(|known| strsim::damerau_levenshtein(name, known));
        Self::UnknownParameter {
            name: name.to_owned(),
            hint: nearest.map_or_else(String::new, |known| format!("; did you mean \"{known}\"?")),
        }
    }
}

#[derive(Clone, Debug)]
struct JointInfo {
    name: String,
    kind: JointKind,
    flexible: bool,
    torque_limit: f64,
}

/// A robot's parameters and equations; cheap to clone.
#[derive(Clone, Debug)]
pub struct Model {
    fixed: Arc<Fixed>,
    shapes: Vec<Shape>,
}

/// What no search changes.
#[derive(Debug)]
struct Fixed {
    joints: Vec<JointInfo>,
    names: Vec<String>,
    parameters: Vec<Parameter>,
    links: Option<TreeLinks>,
    coupling: Option<Vec<f64>>,
    layout: Layout,
    /// Joints whose Stribeck velocity is to be searched.
    unknown_stribeck: Vec<usize>,
}

impl Model {
    /// Returns the model of a described robot.
    ///
    /// # Errors
    ///
    /// [`ModelError::UnknownParameter`] for a nominal, fixed or zero value
    /// without a parameter.
    pub fn new(experiment: &Experiment) -> Result<Self, ModelError> {
        let robot = &experiment.robot;
        let coupling = layout::coupling(experiment);
        let links = match &robot.tree {
            Some(tree) => Some(TreeLinks::new(robot, tree, coupling.as_deref())?),
            None => None,
        };
        let layout = Layout::new(experiment, links.as_ref(), coupling.as_deref());
        let mut parameters: Vec<Parameter> = match &links {
            None => (INERTIAL_NAMES.iter().enumerate())
                .map(|(i, &(name, unit))| Parameter {
                    name: name.to_owned(),
                    symbol: format!("theta{}", i + 1),
                    unit,
                    nominal: robot.nominal.get(name).copied(),
                    fixed: robot.fixed.get(name).copied(),
                    joint: None,
                })
                .collect(),
            Some(links) => (links.selected.iter().enumerate())
                .map(|(i, &index)| {
                    let name = links.words(i);
                    Parameter {
                        symbol: format!("theta{}", i + 1),
                        unit: links.unit(index),
                        nominal: (robot.nominal.get(&name).copied())
                            .or_else(|| links.lumped(index, |k| links.nominal(k))),
                        fixed: links.known.get(&index).or(robot.fixed.get(&name)).copied(),
                        joint: None,
                        name,
                    }
                })
                .collect(),
        };
        for &(kind, joint) in &layout.drives {
            let of = &robot.joint[joint];
            let mut name = format!("{}.{}", of.name, kind.name());
            let nominal = of.nominal.get(kind.name());
            if let (Some(links), JointParameter::RotorInertia, false) =
                (&links, kind, of.is_flexible())
            {
                name = links.words_of(robot.joint.len() * BODY + joint);
            }
            let fixed = robot.fixed.get(&name).copied();
            parameters.push(Parameter {
                name,
                symbol: format!("theta{}", parameters.len() + 1),
                unit: kind.unit(robot.kind(joint)),
                nominal: fixed.or(nominal),
                fixed,
                joint: Some((kind, joint)),
            });
        }
        let stribeck = |joint: usize| {
            let laws =
                [Side::Link, Side::Motor].map(|s| JointParameter::Friction(s, Law::Stribeck));
            (layout.drives.iter()).any(|(kind, own)| *own == joint && laws.contains(kind))
        };
        let model = Self {
            shapes: (robot.joint.iter())
                .map(|joint| Shape {
                    sharpness: joint.coulomb_sharpness_s_per_rad,
                    stribeck_velocity: joint.stribeck_velocity_rad_per_s.unwrap_or(STRIBECK),
                })
                .collect(),
            fixed: Arc::new(Fixed {
                joints: (robot.joint.iter().enumerate())
                    .map(|(i, joint)| JointInfo {
                        name: joint.name.clone(),
                        kind: robot.kind(i),
                        flexible: joint.is_flexible(),
                        torque_limit: joint.torque_limit().unwrap_or(f64::INFINITY),
                    })
                    .collect(),
                names: robot.joint.iter().map(|joint| joint.name.clone()).collect(),
                unknown_stribeck: (0..robot.joint.len())
                    .filter(|&i| stribeck(i))
                    .filter(|&i| robot.joint[i].stribeck_velocity_rad_per_s.is_none())
                    .collect(),
                parameters,
                links,
                coupling,
                layout,
            }),
        };
        model.check_robot(robot)?;
        Ok(model)
    }

    /// Checks that nominal and fixed values are those of parameters.
    fn check_robot(&self, robot: &description::Robot) -> Result<(), ModelError> {
        let links = self.fixed.links.as_ref();
        let standard = |name: &str| links.is_some_and(|links| links.index_of(name).is_some());
        for name in robot.nominal.keys().filter(|name| !standard(name)) {
            if self.parameters()[self.index_of(name)?].joint.is_some() {
                return Err(ModelError::UnknownParameter {
                    name: name.clone(),
                    hint: " of a link; values of joints stand in [[robot.joint]]".to_owned(),
                });
            }
        }
        for name in robot.fixed.keys().filter(|name| !standard(name)) {
            self.index_of(name)?;
        }
        for parameter in self.parameters() {
            let Some((kind, joint)) = parameter.joint.filter(|(kind, _)| kind.is_vital()) else {
                continue;
            };
            // The link of a rigid joint may hold its rotor.
            let may_be_zero = kind == JointParameter::RotorInertia && !self.is_flexible(joint);
            let wrong = |value: &f64| *value < 0.0 || *value == 0.0 && !may_be_zero;
            if let Some(value) = parameter.fixed.filter(wrong) {
                return Err(ModelError::NotPositive {
                    name: format!("the fixed {}", parameter.name),
                    value,
                    unit: parameter.unit,
                });
            }
        }
        Ok(())
    }

    /// Returns the equations of motion.
    #[must_use]
    pub fn robot(&self) -> Robot<'_> {
        let fixed = &*self.fixed;
        let layout = &fixed.layout;
        Robot {
            links: match &fixed.links {
                None => Links::Planar2R {
                    entries: [layout.link_entries[0], layout.link_entries[1]],
                },
                Some(links) => Links::Tree {
                    chain: Chain::checked(&links.tree.joints, links.gravity),
                    selected: &links.kinds,
                    first: &links.first,
                    entries: &layout.link_entries,
                },
            },
            terms: &layout.terms,
            shapes: &self.shapes,
            coupling: fixed.coupling.as_deref(),
            motor_rows: &layout.motor_rows,
            entries: layout.entries,
        }
    }

    /// Returns bodies that move as theta says, \[n\]; none in closed form.
    #[must_use]
    pub fn bodies(&self, theta: &[f64]) -> Vec<[f64; BODY]> {
        (self.fixed.links.as_ref()).map_or_else(Vec::new, |links| links.bodies(theta))
    }

    /// Returns the links of a tree; nothing for a robot in closed form.
    #[must_use]
    pub fn links(&self) -> Option<&TreeLinks> {
        self.fixed.links.as_ref()
    }

    /// Returns the tree of the joints; nothing for a robot in closed form.
    #[must_use]
    pub fn tree(&self) -> Option<&Tree> {
        Some(&self.fixed.links.as_ref()?.tree)
    }

    /// Returns the number of joints `n`.
    #[must_use]
    pub fn joint_count(&self) -> usize {
        self.fixed.joints.len()
    }

    /// Returns the names of the joints, base first.
    #[must_use]
    pub fn joints(&self) -> &[String] {
        &self.fixed.names
    }

    /// Returns how a joint moves.
    #[must_use]
    pub fn kind(&self, joint: usize) -> JointKind {
        self.fixed.joints[joint].kind
    }

    /// Returns whether a joint has a spring.
    #[must_use]
    pub fn is_flexible(&self, joint: usize) -> bool {
        self.fixed.joints[joint].flexible
    }

    /// Returns the torque that each amplifier lets through, N·m (N); infinite if
    /// it has no limit.
    pub fn torque_limits(&self) -> impl Iterator<Item = f64> {
        self.fixed.joints.iter().map(|joint| joint.torque_limit)
    }

    /// Returns the parameters, in the order of theta.
    #[must_use]
    pub fn parameters(&self) -> &[Parameter] {
        &self.fixed.parameters
    }

    /// Returns the number of rows of the regressor.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.fixed.layout.row_columns.len()
    }

    /// Returns the columns of theta that a row of the regressor touches.
    #[must_use]
    pub fn row_columns(&self, row: usize) -> &[usize] {
        &self.fixed.layout.row_columns[row]
    }

    /// Returns the entries of a row of the regressor.
    #[must_use]
    pub fn row_entries(&self, row: usize) -> std::ops::Range<usize> {
        let bounds = &self.fixed.layout.row_entries;
        bounds[row]..bounds[row + 1]
    }

    /// Returns the number of entries of the regressor.
    #[must_use]
    pub fn entries(&self) -> usize {
        self.fixed.layout.entries
    }

    /// Returns the joint that a row of the regressor belongs to.
    #[must_use]
    pub fn joint_of(&self, row: usize) -> usize {
        self.robot().joint_of(row)
    }

    /// Returns the row of a joint that has the motor torque for its right-hand
    /// side: the motor row of a flexible joint, the only row of a rigid one.
    #[must_use]
    pub fn torque_row(&self, joint: usize) -> usize {
        self.fixed.layout.motor_rows[joint].unwrap_or(joint)
    }

    /// Returns whether a row has a motor torque for its right-hand side.
    #[must_use]
    pub fn is_torque_row(&self, row: usize) -> bool {
        self.torque_row(self.joint_of(row)) == row
    }

    /// Returns the name of a row of the regressor, as in `joint1.motor_nm`.
    #[must_use]
    pub fn row_name(&self, row: usize) -> String {
        let joint = &self.fixed.joints[self.joint_of(row)];
        let side = if self.is_torque_row(row) {
            "motor"
        } else {
            "link"
        };
        let unit = match joint.kind {
            JointKind::Revolute => "nm",
            JointKind::Prismatic => "n",
        };
        format!("{}.{side}_{unit}", joint.name)
    }

    /// Returns the index in theta of a joint's parameter, if it has it.
    #[must_use]
    pub fn index(&self, kind: JointParameter, joint: usize) -> Option<usize> {
        let parameters = self.parameters().iter();
        let mut indices = parameters.map(|p| p.joint);
        indices.position(|own| own == Some((kind, joint)))
    }

    /// Returns the index in theta of a named parameter.
    ///
    /// # Errors
    ///
    /// [`ModelError::UnknownParameter`], with the nearest name.
    pub fn index_of(&self, name: &str) -> Result<usize, ModelError> {
        (self.parameters().iter().position(|p| p.name == name))
            .ok_or_else(|| ModelError::unknown(name, self.parameters().iter().map(|p| &p.name)))
    }

    /// Returns the joints whose Stribeck velocity is to be searched.
    #[must_use]
    pub fn unknown_stribeck(&self) -> &[usize] {
        &self.fixed.unknown_stribeck
    }

    /// Returns beta of the Coulomb friction of a joint, s/rad (s/m).
    #[must_use]
    pub fn sharpness(&self, joint: usize) -> f64 {
        self.shapes[joint].sharpness
    }

    /// Returns the index in theta of the base parameter that a standard
    /// inertial parameter stands first in.
    #[must_use]
    pub fn parameter_of(&self, standard: usize) -> Option<usize> {
        let links = self.fixed.links.as_ref()?;
        let bodies = self.joint_count() * BODY;
        match standard.checked_sub(bodies) {
            None => links.selected.binary_search(&standard).ok(),
            Some(joint) => self.index(JointParameter::RotorInertia, joint),
        }
    }

    /// Returns the Stribeck velocity of a joint, rad/s (m/s).
    #[must_use]
    pub fn stribeck_velocity(&self, joint: usize) -> f64 {
        self.shapes[joint].stribeck_velocity
    }

    /// Returns the model with another Stribeck velocity of a joint.
    #[must_use]
    pub fn with_stribeck(&self, joint: usize, velocity: f64) -> Self {
        let mut changed = self.clone();
        changed.shapes[joint].stribeck_velocity = velocity;
        changed
    }

    /// Returns the model with the Stribeck velocities that values by name hold.
    #[must_use]
    pub fn shaped(&self, values: &BTreeMap<String, f64>) -> Self {
        let mut changed = self.clone();
        for (shape, name) in changed.shapes.iter_mut().zip(&self.fixed.names) {
            if let Some(velocity) = values.get(&stribeck_name(name)) {
                shape.stribeck_velocity = *velocity;
            }
        }
        changed
    }

    /// Returns the vector theta of named values.
    ///
    /// Values of single inertial parameters of the links are lumped as the
    /// model needs them.
    ///
    /// # Errors
    ///
    /// [`ModelError::UnknownParameter`] for a strange name,
    /// [`ModelError::Missing`] if a parameter has no value.
    pub fn theta(&self, values: &BTreeMap<String, f64>) -> Result<Theta, ModelError> {
        self.check_names(values)?;
        let links = self.fixed.links.as_ref();
        self.collect(|at, parameter| {
            let own = values.get(&parameter.name).copied().or(parameter.fixed);
            own.or_else(|| {
                let links = links?;
                let n = self.joint_count();
                let index = match parameter.joint {
                    None => links.selected[at],
                    Some((JointParameter::RotorInertia, joint)) => n * BODY + joint,
                    Some(_) => return None,
                };
                links.lumped(index, |k| {
                    (values.get(links.name(k)).copied()).or(links.known.get(&k).copied())
                })
            })
        })
    }

    /// Checks that all names are those of parameters.
    ///
    /// # Errors
    ///
    /// [`ModelError::UnknownParameter`] for the first that is not.
    pub fn check_names(&self, values: &BTreeMap<String, f64>) -> Result<(), ModelError> {
        for name in values.keys() {
            let links = self.fixed.links.as_ref();
            let standard = links.is_some_and(|links| links.index_of(name).is_some());
            let shape = self
                .joints()
                .iter()
                .any(|joint| *name == stribeck_name(joint));
            if !standard && !shape {
                self.index_of(name)?;
            }
        }
        Ok(())
    }

    /// Returns the vector theta of the nominal values; friction that the file
    /// does not give is taken to be zero.
    ///
    /// # Errors
    ///
    /// [`ModelError::Missing`] if an inertia or a stiffness has no value.
    pub fn nominal(&self) -> Result<Theta, ModelError> {
        self.collect(|_, parameter| (parameter.nominal).or(parameter.may_be_zero().then_some(0.0)))
    }

    fn collect(
        &self,
        value: impl Fn(usize, &Parameter) -> Option<f64>,
    ) -> Result<Theta, ModelError> {
        let mut theta = Vec::with_capacity(self.parameters().len());
        let mut names = Vec::new();
        for (at, parameter) in self.parameters().iter().enumerate() {
            theta.push(value(at, parameter).unwrap_or_else(|| {
                names.push(parameter.short().into_owned());
                f64::NAN
            }));
        }
        if names.is_empty() {
            Ok(theta)
        } else {
            Err(ModelError::Missing { names })
        }
    }

    /// Checks that a feedforward can divide by the stiffnesses.
    ///
    /// # Errors
    ///
    /// [`ModelError::NotPositive`] if a stiffness is zero or below.
    pub fn check_stiffness(&self, theta: &[f64]) -> Result<(), ModelError> {
        self.check_positive(JointParameter::Stiffness, theta)
    }

    fn check_positive(&self, kind: JointParameter, theta: &[f64]) -> Result<(), ModelError> {
        for (value, parameter) in theta.iter().zip(self.parameters()) {
            let wanted =
                (parameter.joint).is_some_and(|(own, i)| own == kind && self.is_flexible(i));
            if wanted && (value.is_nan() || *value <= 0.0) {
                return Err(ModelError::NotPositive {
                    name: parameter.name.clone(),
                    value: *value,
                    unit: parameter.unit,
                });
            }
        }
        Ok(())
    }

    /// Checks that a simulation with these values means something.
    ///
    /// # Errors
    ///
    /// [`ModelError::NotPositive`] or [`ModelError::MassMatrix`] if an inertia
    /// is not one of a body.
    pub fn check_inertias(&self, theta: &[f64]) -> Result<(), ModelError> {
        self.check_positive(JointParameter::RotorInertia, theta)?;
        let n = self.joint_count();
        let (robot, bodies) = (self.robot(), self.bodies(theta));
        let values = Values {
            theta,
            bodies: &bodies,
        };
        let mut scratch = Scratch::new(n);
        let mut matrix = vec![0.0; n * n];
        for pose in poses(n) {
            let mut workspace = scratch.workspace();
            robot
                .mass_matrix(&values, &pose, &mut workspace, &mut matrix)
                .map_err(ModelError::Length)?;
            robot.add_motors(theta, false, &mut matrix);
            let mut column = vec![1.0; n];
            sprung_core::dynamics::solve_positive(&mut matrix, &mut column);
            if column.iter().any(|x| !x.is_finite()) {
                return Err(self.mass_matrix_error(theta, &pose));
            }
        }
        Ok(())
    }

    fn mass_matrix_error(&self, theta: &[f64], pose: &[f64]) -> ModelError {
        let shown: Vec<String> = (theta.iter().zip(self.parameters()))
            .filter(|(_, p)| p.joint.is_none())
            .take(INERTIAL)
            .map(|(value, p)| format!("{} = {value:.4e} {}", p.short(), p.unit))
            .collect();
        let shown = match &shown[..] {
            [] => "all zero".to_owned(),
            shown => shown.join(", "),
        };
        let more = match &self.fixed.links {
            Some(links) if links.selected.len() > INERTIAL => ", …",
            _ => "",
        };
        let angles: Vec<String> = pose.iter().map(|q| format!("{q:.2}")).collect();
        ModelError::MassMatrix {
            values: shown + more,
            pose: format!(" at q = [{}]", angles.join(", ")),
        }
    }
}

/// Returns the name of a joint's Stribeck velocity in files of values.
#[must_use]
pub fn stribeck_name(joint: &str) -> String {
    format!("{joint}.stribeck_velocity")
}

/// Poses at which a mass matrix is looked at: each joint stretched and folded,
/// and many between.
fn poses(n: usize) -> impl Iterator<Item = Vec<f64>> {
    const BETWEEN: usize = 64;
    let turned = (0..n).map(move |i| {
        let mut pose = vec![0.0; n];
        pose[i] = std::f64::consts::PI;
        pose
    });
    // The golden ratio spreads each joint's angles evenly and out of step.
    let spread = (1..=BETWEEN).map(move |k| {
        (0..n)
            .map(|i| {
                let part = (k as f64 * 0.618_033_988_749_895 * (1.0 + i as f64 * 0.37)).fract();
                std::f64::consts::TAU * part
            })
            .collect()
    });
    std::iter::once(vec![0.0; n]).chain(turned).chain(spread)
}
