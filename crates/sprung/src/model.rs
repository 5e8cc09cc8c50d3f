//! From the description of a robot to its parameters and equations.

use std::collections::BTreeMap;

use sprung_core::parameters::JointParameter;
use sprung_core::planar_2r::{INERTIAL, INERTIAL_NAMES, JOINTS};
use sprung_core::regressor::{LAYOUT, PARAMETERS, PlanarArm, ROW_COLUMNS};

use crate::description::Robot;

/// A parameter vector theta, \[15\].
pub type Theta = [f64; PARAMETERS];

/// Number of joints.
pub const JOINT_COUNT: usize = JOINTS;

/// Number of rows of the regressor: link rows, then motor rows.
pub const ROWS: usize = 2 * JOINTS;

/// One parameter of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name, as in `joint1.stiffness`.
    pub name: String,
    /// The paper's symbol, as in `theta10`.
    pub symbol: String,
    /// Unit.
    pub unit: &'static str,
    /// Value that the maker gives.
    pub nominal: Option<f64>,
    /// Kind and joint; nothing for a link inertial parameter.
    pub joint: Option<(JointParameter, usize)>,
}

impl Parameter {
    /// Returns whether the parameter takes energy out of the robot.
    #[must_use]
    pub fn is_friction(&self) -> bool {
        self.joint.is_some_and(|(kind, _)| kind.is_friction())
    }
}

/// What is wrong with a set of parameter values.
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
    #[error(
        "the link inertias (theta1 = {0:.4e}, theta2 = {1:.4e}, theta3 = {2:.4e} kg·m²) do not \
         make a positive mass matrix",
        values[0], values[1], values[2]
    )]
    MassMatrix {
        /// The three link inertial parameters.
        values: [f64; INERTIAL],
    },
}

/// A robot's parameters and equations.
#[derive(Clone, Debug)]
pub struct Model {
    arm: PlanarArm,
    joints: Vec<String>,
    parameters: Vec<Parameter>,
    torque_limits: [f64; JOINTS],
}

impl Model {
    /// Returns the model of a described robot.
    ///
    /// # Errors
    ///
    /// [`ModelError::UnknownParameter`] for a nominal value without a
    /// parameter.
    pub fn new(robot: &Robot) -> Result<Self, ModelError> {
        let mut arm = PlanarArm {
            coulomb_sharpness: [0.0; JOINTS],
        };
        for (sharpness, joint) in arm.coulomb_sharpness.iter_mut().zip(&robot.joint) {
            *sharpness = joint.coulomb_sharpness_s_per_rad;
        }
        let parameters = (0..PARAMETERS)
            .map(|index| {
                let symbol = format!("theta{}", index + 1);
                match LAYOUT.joint_parameter(index) {
                    None => Parameter {
                        name: INERTIAL_NAMES[index].0.to_owned(),
                        symbol,
                        unit: INERTIAL_NAMES[index].1,
                        nominal: robot.nominal.get(INERTIAL_NAMES[index].0).copied(),
                        joint: None,
                    },
                    Some((kind, joint)) => {
                        let given = &robot.joint[joint].nominal;
                        Parameter {
                            name: format!("{}.{}", robot.joint[joint].name, kind.name()),
                            symbol,
                            unit: kind.unit(),
                            nominal: match kind {
                                JointParameter::RotorInertia => given.rotor_inertia,
                                JointParameter::LinkViscous => given.link_viscous,
                                JointParameter::MotorViscous => given.motor_viscous,
                                JointParameter::Stiffness => given.stiffness,
                                JointParameter::LinkCoulomb => given.link_coulomb,
                                JointParameter::MotorCoulomb => given.motor_coulomb,
                            },
                            joint: Some((kind, joint)),
                        }
                    }
                }
            })
            .collect();
        let model = Self {
            arm,
            joints: robot.joint.iter().map(|joint| joint.name.clone()).collect(),
            parameters,
            torque_limits: std::array::from_fn(|i| {
                robot.joint[i].torque_limit().unwrap_or(f64::INFINITY)
            }),
        };
        for name in robot.nominal.keys() {
            match model.index_of(name)? {
                index if index < INERTIAL => {}
                _ => {
                    return Err(ModelError::UnknownParameter {
                        name: name.clone(),
                        hint: " of a link; values of joints stand in [[robot.joint]]".to_owned(),
                    });
                }
            }
        }
        Ok(model)
    }

    /// Returns the equations of motion.
    #[must_use]
    pub fn arm(&self) -> &PlanarArm {
        &self.arm
    }

    /// Returns the names of the joints, base first.
    #[must_use]
    pub fn joints(&self) -> &[String] {
        &self.joints
    }

    /// Returns the torque that each amplifier lets through, N·m; infinite if it
    /// has no limit.
    #[must_use]
    pub fn torque_limits(&self) -> &[f64; JOINTS] {
        &self.torque_limits
    }

    /// Returns the parameters, in the order of theta.
    #[must_use]
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// Returns the columns of theta that a row of the regressor touches.
    #[must_use]
    pub fn row_columns(&self, row: usize) -> &'static [usize] {
        ROW_COLUMNS[row]
    }

    /// Returns the name of a row of the regressor, as in `joint1.motor_nm`.
    #[must_use]
    pub fn row_name(&self, row: usize) -> String {
        let side = if row < JOINTS { "link" } else { "motor" };
        format!("{}.{side}_nm", self.joints[row % JOINTS])
    }

    /// Returns the index in theta of a joint's parameter.
    #[must_use]
    pub fn index(&self, kind: JointParameter, joint: usize) -> usize {
        LAYOUT.index(kind, joint)
    }

    /// Returns the index in theta of a named parameter.
    ///
    /// # Errors
    ///
    /// [`ModelError::UnknownParameter`], with the nearest name.
    pub fn index_of(&self, name: &str) -> Result<usize, ModelError> {
        if let Some(index) = self.parameters.iter().position(|p| p.name == name) {
            return Ok(index);
        }
        let names = self.parameters.iter().map(|p| p.name.as_str());
        let nearest = names.min_by_key(|known| strsim::damerau_levenshtein(name, known));
        Err(ModelError::UnknownParameter {
            name: name.to_owned(),
            hint: nearest.map_or_else(String::new, |known| format!("; did you mean \"{known}\"?")),
        })
    }

    /// Returns the vector theta of named values.
    ///
    /// # Errors
    ///
    /// [`ModelError::UnknownParameter`] for a strange name,
    /// [`ModelError::Missing`] if a parameter has no value.
    pub fn theta(&self, values: &BTreeMap<String, f64>) -> Result<Theta, ModelError> {
        for name in values.keys() {
            self.index_of(name)?;
        }
        self.collect(|parameter| values.get(&parameter.name).copied())
    }

    /// Returns the vector theta of the nominal values; friction that the file
    /// does not give is taken to be zero.
    ///
    /// # Errors
    ///
    /// [`ModelError::Missing`] if an inertia or a stiffness has no value.
    pub fn nominal(&self) -> Result<Theta, ModelError> {
        self.collect(|parameter| parameter.nominal.or(parameter.is_friction().then_some(0.0)))
    }

    fn collect(&self, value: impl Fn(&Parameter) -> Option<f64>) -> Result<Theta, ModelError> {
        let mut theta = [0.0; PARAMETERS];
        let mut names = Vec::new();
        for (slot, parameter) in theta.iter_mut().zip(&self.parameters) {
            match value(parameter) {
                Some(value) => *slot = value,
                None => names.push(parameter.name.clone()),
            }
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
    pub fn check_stiffness(&self, theta: &Theta) -> Result<(), ModelError> {
        self.check_positive(JointParameter::Stiffness, theta)
    }

    fn check_positive(&self, kind: JointParameter, theta: &Theta) -> Result<(), ModelError> {
        for joint in 0..JOINTS {
            let index = LAYOUT.index(kind, joint);
            if theta[index].is_nan() || theta[index] <= 0.0 {
                return Err(ModelError::NotPositive {
                    name: self.parameters[index].name.clone(),
                    value: theta[index],
                    unit: self.parameters[index].unit,
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
    pub fn check_inertias(&self, theta: &Theta) -> Result<(), ModelError> {
        self.check_positive(JointParameter::RotorInertia, theta)?;
        // The determinant is a parabola in cos q2 that opens downwards, so the
        // two stretched poses bound it.
        for q2 in [0.0, std::f64::consts::PI] {
            let m = PlanarArm::mass_matrix(theta, &[0.0, q2]);
            let determinant = m[0][0] * m[1][1] - m[0][1] * m[1][0];
            if m[0][0].is_nan() || m[0][0] <= 0.0 || determinant.is_nan() || determinant <= 0.0 {
                return Err(ModelError::MassMatrix {
                    values: [theta[0], theta[1], theta[2]],
                });
            }
        }
        Ok(())
    }
}
