//! A parameter of a model, and the errors of models and parameter values.

use std::borrow::Cow;

use sprung_core::chain::ChainError;
use sprung_core::links::LengthError;
use sprung_core::parameters::JointParameter;

use crate::named::edits;

/// One parameter of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name, as in `joint1.stiffness`, or `link1.izz + 0.1176*link2.m`.
    pub name: String,
    /// The paper's symbol, as in `theta10`.
    pub symbol: String,
    /// Unit of the value.
    pub unit: &'static str,
    /// Nominal value from the description.
    pub nominal: Option<f64>,
    /// Known value that is not estimated.
    pub fixed: Option<f64>,
    /// Kind and joint; `None` for a link inertial parameter.
    pub joint: Option<(JointParameter, usize)>,
}

impl Parameter {
    /// Returns whether the parameter is a friction parameter.
    #[must_use]
    pub fn is_friction(&self) -> bool {
        self.joint.is_some_and(|(kind, _)| kind.is_friction())
    }

    /// Returns whether the parameter may be zero, as friction, offsets and preloads may.
    #[must_use]
    pub fn may_be_zero(&self) -> bool {
        self.joint.is_some_and(|(kind, _)| !kind.is_vital())
    }

    /// Returns the name; a long combination of link parameters is shortened to its first term.
    #[must_use]
    pub fn short(&self) -> Cow<'_, str> {
        short(&self.name)
    }
}

/// Returns a parameter's name; a long combination is shortened to its first term.
#[must_use]
pub fn short(name: &str) -> Cow<'_, str> {
    const LONGEST_NAME: usize = 32;
    match name.split_once([' ']) {
        Some((first, _)) if name.chars().count() > LONGEST_NAME => {
            Cow::Owned(format!("{first} + …"))
        }
        _ => Cow::Borrowed(name),
    }
}

/// Errors of a robot's description or of a set of parameter values.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// The model has no parameter with this name.
    #[error("the model has no parameter \"{name}\"{hint}")]
    UnknownParameter {
        /// The unknown name.
        name: String,
        /// The nearest name as a question, or empty.
        hint: String,
    },
    /// Values for a simulation or a feedforward are missing.
    #[error("no value for {}; give it under nominal or in the parameter file", names.join(", "))]
    Missing {
        /// Names of the parameters.
        names: Vec<String>,
    },
    /// A value that must be positive is not.
    #[error("{name} = {value:.4e} {unit} must be positive")]
    NotPositive {
        /// Name of the parameter.
        name: String,
        /// Its value.
        value: f64,
        /// Its unit.
        unit: &'static str,
    },
    /// A value that may be zero is negative.
    #[error("{name} = {value:.4e} {unit} must not be negative")]
    Negative {
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
        /// Link inertial parameters, or "all zero".
        values: String,
        /// Pose with this mass matrix, or empty.
        pose: String,
    },
    /// A link that carries a payload has given parameters.
    #[error(
        "{link} carries a payload, but {parameter} is given under fixed or assume_zero, so its change by the \
         payload cannot be told; remove it there"
    )]
    Carries {
        /// Name of the link.
        link: String,
        /// Name of the given parameter.
        parameter: String,
    },
    /// The joints do not form a tree.
    #[error("{0}")]
    Chain(ChainError),
    /// The workspace does not fit the robot.
    #[error("{0}")]
    Length(LengthError),
}

impl ModelError {
    pub(super) fn unknown<'a>(name: &str, names: impl Iterator<Item = &'a String>) -> Self {
        let nearest = names.min_by_key(|known| edits(name, known));
        Self::UnknownParameter {
            name: name.to_owned(),
            hint: nearest.map_or_else(String::new, |known| format!("; did you mean \"{known}\"?")),
        }
    }
}
