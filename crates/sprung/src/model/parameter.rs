//! One parameter of a model, and what is wrong with sets of them.

use std::borrow::Cow;

use sprung_core::chain::ChainError;
use sprung_core::links::LengthError;
use sprung_core::parameters::JointParameter;

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
    pub(super) fn unknown<'a>(name: &str, names: impl Iterator<Item = &'a String>) -> Self {
        let nearest = names.min_by_key(|known| strsim::damerau_levenshtein(name, known));
        Self::UnknownParameter {
            name: name.to_owned(),
            hint: nearest.map_or_else(String::new, |known| format!("; did you mean \"{known}\"?")),
        }
    }
}
