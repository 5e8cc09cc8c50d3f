//! Parameters that fits do not estimate: known values, and changes of friction with covariates.

use std::sync::Arc;

use sprung_core::covariate::Covariate;
use sprung_core::parameters::JointParameter;

use super::Model;

impl Model {
    /// Returns the covariates of each joint at which its friction has its parameters; zero for those on
    /// which its friction does not depend.
    pub fn references(&self) -> impl Iterator<Item = [f64; Covariate::COUNT]> {
        self.fixed.joints.iter().map(|joint| joint.references)
    }

    /// Returns the index of the friction parameter whose change with a covariate a parameter is; `None`
    /// for other parameters.
    #[must_use]
    pub fn friction_of_change(&self, index: usize) -> Option<usize> {
        match self.fixed.parameters[index].joint? {
            (JointParameter::Change(side, law, _), joint) => {
                self.index(JointParameter::Friction(side, law), joint)
            }
            _ => None,
        }
    }

    /// Returns the model with given changes of friction, which fits then do not estimate. A part of the
    /// logs may determine none of them, as a covariate such as the hours of operation changes only from
    /// log to log.
    ///
    /// - `theta`: contains their values, \[p\].
    #[must_use]
    pub fn with_known_changes(&self, theta: &[f64]) -> Self {
        Self {
            known_changes: Some(theta.into()),
            ..self.clone()
        }
    }

    /// Returns the model with further known parameters, as if the description fixed them.
    ///
    /// - `values`: indices in theta and values.
    #[must_use]
    pub fn with_fixed(&self, values: &[(usize, f64)]) -> Self {
        let mut fixed = (*self.fixed).clone();
        for &(index, value) in values {
            fixed.parameters[index].fixed = Some(value);
        }
        Self {
            fixed: Arc::new(fixed),
            ..self.clone()
        }
    }

    /// Returns the value of a parameter that fits do not estimate.
    #[must_use]
    pub fn known(&self, index: usize) -> Option<f64> {
        let change = || {
            let theta = self.known_changes.as_ref()?;
            self.friction_of_change(index).map(|_| theta[index])
        };
        self.fixed.parameters[index].fixed.or_else(change)
    }
}
