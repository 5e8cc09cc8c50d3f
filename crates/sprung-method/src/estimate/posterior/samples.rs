//! Drawn robots.

use std::collections::BTreeMap;

use sprung_core::spatial::BODY;

use super::body::Body;
use crate::model::Theta;

/// How robots were drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DrawMethod {
    /// Independent draws, of which those that can exist are kept.
    Rejection {
        /// Share of the draws that can exist.
        accepted: f64,
    },
    /// Chains of Gibbs steps.
    Gibbs {
        /// Number of chains.
        chains: usize,
        /// Sweeps over all coordinates from one robot to the next.
        sweeps: usize,
    },
}

/// Robots that can exist, drawn from the posterior of an identification.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    /// Names of the parameters, \[p\], given ones included.
    pub parameters: Vec<String>,
    /// Parameters of each robot in their SI units, \[n\]\[p\].
    pub theta: Vec<Theta>,
    /// Names of the inertial parameters of single links, ten for each, then of the rotor inertias; empty for the paper's
    /// arm, whose parameters do not determine bodies.
    pub standard_parameters: Vec<String>,
    /// Values of these of each robot, kg, kg·m, kg·m², \[n\]\[standard\].
    pub standard: Vec<Vec<f64>>,
    /// Names of the links; empty for the paper's arm.
    pub links: Vec<String>,
    /// Parameters that the log does not determine. Their draws come from nominal values, or from those that the result
    /// gives for simulations, with the relative error of nominal values.
    pub undetermined: Vec<String>,
    /// Inertial parameters of single links whose draws come from nominal or ordinary bodies: the log removes at most a
    /// tenth of their variance.
    pub undetermined_standard: Vec<String>,
    /// Constants of friction laws by name, equal in all robots: Stribeck velocities, widths of presliding friction,
    /// sharpnesses.
    pub constants: BTreeMap<String, f64>,
    /// How the robots were drawn.
    pub method: DrawMethod,
    /// Effective sample size of the parameter whose draws are most correlated with their predecessors, by the
    /// correlation of neighbours.
    pub effective: f64,
}

impl Samples {
    /// Returns the parameters of a robot by name with the constants of friction laws; `None` if there is no such robot.
    #[must_use]
    pub fn values(&self, robot: usize) -> Option<BTreeMap<String, f64>> {
        let theta = self.theta.get(robot)?;
        let mut values = self.constants.clone();
        values.extend(self.parameters.iter().cloned().zip(theta.iter().copied()));
        Some(values)
    }

    /// Returns the bodies of all links of a robot; `None` if there is no such robot, or for the paper's arm.
    #[must_use]
    pub fn bodies(&self, robot: usize) -> Option<Vec<Body>> {
        let standard = self
            .standard
            .get(robot)
            .filter(|standard| !standard.is_empty())?;
        let bodies = standard.chunks_exact(BODY).take(self.links.len());
        bodies
            .map(|body| Some(Body::of(body.try_into().ok()?)))
            .collect()
    }
}
