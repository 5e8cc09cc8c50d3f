//! Turns the description of a robot into its parameters and equations.
//!
//! This crate is internal to `sprung`. Its items may change in any version; use the crate `sprung`, which re-exports the
//! public names.

// The compiler names each place that must handle a new law, parameter, quantity or format.
#![warn(clippy::wildcard_enum_match_arm)]

mod base_parameters;
mod changes;
mod convex;
mod deflection_entry;
mod elements;
mod high_pass;
mod inertial;
mod initial_shape;
mod layout;
mod links;
mod nearest_bodies;
mod parameter;
mod payload;
mod regions;
mod scratch;
mod second_moments;
mod shapes;
mod springs;
mod values;

use sprung_base::{ellipsoid, named};
use sprung_robot as description;

use std::sync::Arc;

use sprung_core::chain::JointKind;
use sprung_core::covariate::Covariate;
use sprung_core::friction::{Scale, Shape};
use sprung_core::parameters::JointParameter;
use sprung_core::robot::{Links, Robot};
use sprung_core::spatial::BODY;

use description::{Experiment, Instrumentation, Row, SpringTerm, Tree};
use inertial::{Inertial, PLANAR_2R_NAMES};
use initial_shape::initial_shape;
use layout::Layout;

pub use convex::{Block, Entry, NoSolution, Program, ROWS};
pub use elements::{ElementSet, Elements};
use links::OFFSET;
pub use links::TreeLinks;
pub use parameter::{ModelError, Parameter, short};
pub use regions::Region;
pub use scratch::Scratch;
pub use second_moments::{is_possible, second_moments};
pub use shapes::hysteresis_name;
pub use shapes::play_centre_name;
pub use shapes::play_name;
pub use shapes::presliding_name;
pub use shapes::sharpness_name;
pub use shapes::stribeck_name;

/// A parameter vector theta, \[p\].
pub type Theta = Vec<f64>;

#[derive(Clone, Debug)]
struct JointInfo {
    name: String,
    kind: JointKind,
    flexible: bool,
    torque_limit: f64,
    /// Covariates at which friction has its parameters.
    references: [f64; Covariate::COUNT],
}

impl JointInfo {
    fn all(robot: &description::Robot) -> Vec<Self> {
        let joints = robot.joint.iter().enumerate();
        let of = |(i, joint): (usize, &description::Joint)| Self {
            name: joint.name.clone(),
            kind: robot.kind(i),
            flexible: joint.is_flexible(),
            torque_limit: joint.torque_limit().unwrap_or(f64::INFINITY),
            references: joint.references(),
        };
        joints.map(of).collect()
    }
}

/// A robot's parameters and equations; cheap to clone.
#[derive(Clone, Debug)]
pub struct Model {
    fixed: Arc<Fixed>,
    shapes: Vec<Shape>,
    /// Joints whose Stribeck velocity the refinement estimates.
    open_stribeck: Vec<usize>,
    /// Parameter vector about which the regression is linear in the stiffnesses of joints with torque
    /// sensor and without link position; `None` before it is known.
    springs: Option<Arc<[f64]>>,
    /// Values that fits take for the changes of friction with covariates; `None` if they are estimated.
    known_changes: Option<Arc<[f64]>>,
}

/// Parts of a model that no search changes.
#[derive(Clone, Debug)]
struct Fixed {
    joints: Vec<JointInfo>,
    names: Vec<String>,
    parameters: Vec<Parameter>,
    inertial: Inertial,
    links: Option<TreeLinks>,
    coupling: Option<Vec<f64>>,
    /// The equations of motion.
    layout: Layout,
    /// The equations of the regression, if a log has torques of springs.
    measured: Option<Layout>,
    instruments: Instrumentation,
    /// Joints with an unknown Stribeck velocity, which is to be searched.
    unknown_stribeck: Vec<usize>,
    /// Joints whose sharpness of Coulomb friction the description does not give.
    open_sharpness: Vec<usize>,
    /// Joints for whose presliding friction a log must give the width.
    open_presliding: Vec<usize>,
    /// The same for hysteresis.
    open_hysteresis: Vec<usize>,
    /// Joints for whose play a log must give half width and centre.
    open_play: Vec<usize>,
}

/// Returns the value of a drive's parameter that the description fixes.
fn fixed_value(
    robot: &description::Robot,
    kind: JointParameter,
    joint: usize,
    name: &str,
) -> Option<f64> {
    match kind {
        JointParameter::BackEmf => robot.back_emf(joint),
        JointParameter::RotorInertia
        | JointParameter::Stiffness
        | JointParameter::CubicStiffness
        | JointParameter::Damping
        | JointParameter::Hysteresis(_)
        | JointParameter::Preload
        | JointParameter::Friction(..)
        | JointParameter::Change(..)
        | JointParameter::TorqueOffset => robot.fixed.get(name).copied(),
    }
}

/// Returns the parameter of a drive.
fn of_drive(
    (robot, links): (&description::Robot, Option<&TreeLinks>),
    (kind, joint): (JointParameter, usize),
    symbol: String,
) -> Parameter {
    let of = &robot.joint[joint];
    let mut name = format!("{}.{}", of.name, kind.name());
    let mut nominal = of.nominal.get(kind);
    match (links, kind) {
        (Some(links), OFFSET) => {
            if let Some(index) = links.combined_offset(joint) {
                name = links.words_of(index);
                nominal = links.lumped(index, |k| links.nominal(k));
            }
        }
        (Some(links), JointParameter::RotorInertia) if !of.is_flexible() => {
            name = links.words_of(robot.joint.len() * BODY + joint);
        }
        _ => {}
    }
    let fixed = fixed_value(robot, kind, joint, &name);
    Parameter {
        name,
        symbol,
        unit: kind.unit(robot.kind(joint)),
        nominal: fixed.or(nominal),
        fixed,
        joint: Some((kind, joint)),
    }
}

/// Returns the joints of which something holds.
fn joints_with(
    robot: &description::Robot,
    holds: impl Fn(&description::Joint) -> bool,
) -> Vec<usize> {
    let joints = robot.joint.iter().enumerate();
    joints
        .filter(|(_, joint)| holds(joint))
        .map(|(index, _)| index)
        .collect()
}

impl Model {
    /// Returns the model of a described robot.
    ///
    /// # Errors
    ///
    /// [`ModelError::UnknownParameter`] for a nominal, fixed or zero value of an unknown parameter.
    pub fn new(experiment: &Experiment) -> Result<Self, ModelError> {
        let robot = &experiment.robot;
        let coupling = layout::coupling(experiment);
        let links = match &robot.tree {
            Some(tree) => Some(TreeLinks::new(robot, tree, coupling.as_deref())?),
            None => None,
        };
        let inertial = match &links {
            Some(links) => Inertial::of_tree(&links.tree.joints, links.gravity, &links.selected),
            None => Inertial::planar_2r(),
        };
        let inertial = inertial.map_err(ModelError::Chain)?;
        let instruments = Instrumentation::new(robot, experiment.log.as_ref());
        let structure = (links.as_ref(), coupling.as_deref());
        let layout = Layout::new(experiment, &inertial, structure, &instruments);
        let measured = (instruments.has_measured_springs())
            .then(|| layout.with_instruments(&inertial, coupling.as_deref(), &instruments));
        let mut parameters: Vec<Parameter> = match &links {
            None => (PLANAR_2R_NAMES.iter().enumerate())
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
            let symbol = format!("theta{}", parameters.len() + 1);
            parameters.push(of_drive((robot, links.as_ref()), (kind, joint), symbol));
        }
        let unknown_stribeck: Vec<usize> = (layout.joints_with(Scale::Stribeck).into_iter())
            .filter(|&i| robot.joint[i].stribeck_velocity_rad_per_s.is_none())
            .collect();
        let model = Self {
            springs: None,
            known_changes: None,
            open_stribeck: unknown_stribeck.clone(),
            shapes: robot.joint.iter().map(initial_shape).collect(),
            fixed: Arc::new(Fixed {
                joints: JointInfo::all(robot),
                names: robot.joint.iter().map(|joint| joint.name.clone()).collect(),
                unknown_stribeck,
                open_sharpness: joints_with(robot, |joint| {
                    joint.coulomb_sharpness_s_per_rad.is_none()
                }),
                instruments,
                open_presliding: joints_with(robot, |joint| joint.presliding_width_rad.is_none()),
                open_hysteresis: joints_with(robot, |joint| joint.hysteresis_width_rad.is_none()),
                open_play: joints_with(robot, |joint| {
                    let terms = joint.spring_terms();
                    terms.contains(&SpringTerm::Play) && joint.play_half_width_rad.is_none()
                }),
                parameters,
                inertial,
                links,
                coupling,
                layout,
                measured,
            }),
        };
        model.check_robot(robot)?;
        model.check_payloads(experiment)?;
        model.check_masses(experiment.identify.physical.mass_kg.keys())?;
        Ok(model)
    }

    /// Checks that limits of masses belong to links.
    fn check_masses<'a>(&self, names: impl Iterator<Item = &'a String>) -> Result<(), ModelError> {
        let links = self.tree().map_or(&[][..], |tree| &tree.links);
        for name in names {
            if !links.contains(name) {
                return Err(ModelError::unknown(name, links.iter()));
            }
        }
        Ok(())
    }

    /// Checks that nominal and fixed values belong to parameters.
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
            let Some((kind, joint)) = parameter.joint else {
                continue;
            };
            if let Some(value) = parameter
                .fixed
                .filter(|value| *value < 0.0 && kind.is_friction())
            {
                return Err(ModelError::Negative {
                    name: format!("the fixed {}", parameter.name),
                    value,
                    unit: parameter.unit,
                });
            }
            if !kind.is_vital() {
                continue;
            }
            // The inertia of a rigid joint's rotor may be part of the link's.
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
        self.robot_of(&self.fixed.layout)
    }

    /// Returns the equations of the regression. They have other rows than [`Model::robot`] if a log
    /// has torques of springs; rows of links and motors are the same.
    #[must_use]
    pub fn regressor(&self) -> Robot<'_> {
        self.robot_of(self.rows_in_use())
    }

    fn rows_in_use(&self) -> &Layout {
        self.fixed.measured.as_ref().unwrap_or(&self.fixed.layout)
    }

    fn robot_of<'m>(&'m self, layout: &'m Layout) -> Robot<'m> {
        let fixed = &*self.fixed;
        Robot {
            links: Links {
                chain: fixed.inertial.chain(),
                selected: &fixed.inertial.kinds,
                first: &fixed.inertial.first,
                entries: &layout.link_entries,
                shares: &layout.shares,
            },
            terms: &layout.terms,
            shapes: &self.shapes,
            coupling: fixed.coupling.as_deref(),
            motor_rows: &layout.motor_rows,
            entries: layout.entries,
        }
    }

    /// Returns one body per link, \[n\]; the bodies have the link inertias of theta.
    #[must_use]
    pub fn bodies(&self, theta: &[f64]) -> Vec<[f64; BODY]> {
        self.fixed.inertial.bodies(theta)
    }

    /// Returns the links of a described tree; `None` for the paper's arm.
    #[must_use]
    pub fn links(&self) -> Option<&TreeLinks> {
        self.fixed.links.as_ref()
    }

    /// Returns the described tree of joints; `None` for the paper's arm.
    #[must_use]
    pub fn tree(&self) -> Option<&Tree> {
        Some(&self.fixed.links.as_ref()?.tree)
    }

    /// Returns the acceleration of free fall in the base frame, m/s²; zero for the paper's arm.
    #[must_use]
    pub fn gravity(&self) -> [f64; 3] {
        self.fixed.inertial.gravity
    }

    /// Returns the same parameters with another acceleration of free fall, m/s².
    #[must_use]
    pub fn with_gravity(mut self, gravity: [f64; 3]) -> Self {
        Arc::make_mut(&mut self.fixed).inertial.gravity = gravity;
        self
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

    /// Returns the kind of a joint's motion.
    #[must_use]
    pub fn kind(&self, joint: usize) -> JointKind {
        self.fixed.joints[joint].kind
    }

    /// Returns whether any joint has a spring.
    #[must_use]
    pub fn has_springs(&self) -> bool {
        (0..self.joint_count()).any(|joint| self.is_flexible(joint))
    }

    /// Returns whether a joint has a spring.
    #[must_use]
    pub fn is_flexible(&self, joint: usize) -> bool {
        self.fixed.joints[joint].flexible
    }

    /// Returns the torque limit of each amplifier, N·m (N); infinite without a limit.
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
        self.rows_in_use().row_columns.len()
    }

    /// Returns the number of equations of motion, one per coordinate. They are the first rows of the
    /// regressor; rows of torque sensors follow.
    #[must_use]
    pub fn coordinates(&self) -> usize {
        self.fixed.layout.row_columns.len()
    }

    /// Returns the columns of theta in a row of the regressor.
    #[must_use]
    pub fn row_columns(&self, row: usize) -> &[usize] {
        &self.rows_in_use().row_columns[row]
    }

    /// Returns the columns of theta in an equation of motion.
    #[must_use]
    pub fn equation_columns(&self, row: usize) -> &[usize] {
        &self.fixed.layout.row_columns[row]
    }

    /// Returns the range of entries of a row of the regressor.
    #[must_use]
    pub fn row_entries(&self, row: usize) -> std::ops::Range<usize> {
        self.rows_in_use().entries_of(row)
    }

    /// Returns the range of entries of an equation of motion.
    #[must_use]
    pub fn equation_entries(&self, row: usize) -> std::ops::Range<usize> {
        self.fixed.layout.entries_of(row)
    }

    /// Returns the number of entries of the regressor.
    #[must_use]
    pub fn entries(&self) -> usize {
        self.rows_in_use().entries
    }

    /// Returns the joint of a row of the regressor.
    #[must_use]
    pub fn joint_of(&self, row: usize) -> usize {
        self.rows_in_use().row_joints[row]
    }

    /// Returns the row of a joint with the motor torque on its right-hand side: the motor row of a
    /// flexible joint, the only row of a rigid joint.
    #[must_use]
    pub fn torque_row(&self, joint: usize) -> usize {
        self.fixed.layout.motor_rows[joint].unwrap_or(joint)
    }

    /// Returns whether a sensor measures the torque of a joint's spring.
    #[must_use]
    pub fn has_torque_sensor(&self, joint: usize) -> bool {
        self.right_hand_side(joint).torques()[1].is_some()
    }

    /// Returns the right-hand side of a row.
    #[must_use]
    pub fn right_hand_side(&self, row: usize) -> description::RightHandSide {
        self.rows_in_use().right_hand_sides[row]
    }

    /// Returns the kind of a row of the regressor.
    #[must_use]
    pub fn row_of_joint(&self, row: usize) -> Row {
        match row {
            _ if self.torque_row(self.joint_of(row)) == row => Row::Motor,
            _ if row < self.coordinates() => Row::Link,
            _ => Row::Spring,
        }
    }

    /// Returns whether the right-hand side of a row contains a motor torque.
    #[must_use]
    pub fn is_torque_row(&self, row: usize) -> bool {
        self.row_of_joint(row) == Row::Motor
    }

    /// Returns the name of a row of the regressor, as in `joint1.motor_nm`.
    #[must_use]
    pub fn row_name(&self, row: usize) -> String {
        let joint = &self.fixed.joints[self.joint_of(row)];
        let side = match self.row_of_joint(row) {
            Row::Motor => "motor",
            Row::Link => "link",
            Row::Spring => "spring",
        };
        let unit = match joint.kind {
            JointKind::Revolute => "nm",
            JointKind::Prismatic => "n",
        };
        format!("{}.{side}_{unit}", joint.name)
    }

    /// Returns the index in theta of a joint's parameter; `None` if the joint does not have it.
    #[must_use]
    pub fn index(&self, kind: JointParameter, joint: usize) -> Option<usize> {
        let parameters = self.parameters().iter();
        let mut indices = parameters.map(|p| p.joint);
        indices.position(|meaning| meaning == Some((kind, joint)))
    }

    /// Returns the index in theta of a named parameter.
    ///
    /// # Errors
    ///
    /// [`ModelError::UnknownParameter`] with the nearest name.
    pub fn index_of(&self, name: &str) -> Result<usize, ModelError> {
        (self.parameters().iter().position(|p| p.name == name))
            .ok_or_else(|| ModelError::unknown(name, self.parameters().iter().map(|p| &p.name)))
    }

    /// Returns the nominal values of the link parameters without rotors, \[p\]; zero for the
    /// parameters of joints and for bodies without a nominal value. `None` if no body has a nominal
    /// value other than zero.
    #[must_use]
    pub fn nominal_bodies(&self) -> Option<Theta> {
        let values: Theta = (self.parameters().iter().enumerate())
            .map(
                |(i, parameter)| match (&self.fixed.links, parameter.joint) {
                    (_, Some(_)) => 0.0,
                    (Some(links), None) => links.of_bodies(links.selected[i]),
                    (None, None) => parameter.nominal.unwrap_or(0.0),
                },
            )
            .collect();
        values.iter().any(|value| *value != 0.0).then_some(values)
    }

    /// Returns the link parameters in theta that contain the rotor inertia of a rigid joint, each
    /// with the factor of the rotor inertia; empty if it is a separate parameter.
    #[must_use]
    pub fn rotor_in_links(&self, joint: usize) -> Vec<(usize, f64)> {
        let Some(links) = &self.fixed.links else {
            return Vec::new();
        };
        let shares = links.shares_of(self.joint_count() * BODY + joint);
        (shares.into_iter())
            .filter_map(|(index, share)| Some((self.parameter_of(index)?, share)))
            .collect()
    }

    /// Returns the index in theta of the base parameter that begins with a standard inertial
    /// parameter; `None` if no base parameter begins with it.
    #[must_use]
    pub fn parameter_of(&self, standard: usize) -> Option<usize> {
        let links = self.fixed.links.as_ref()?;
        let bodies = self.joint_count() * BODY;
        match standard.checked_sub(bodies) {
            None => links.selected.binary_search(&standard).ok(),
            Some(joint) => self.index(JointParameter::RotorInertia, joint),
        }
    }
}
