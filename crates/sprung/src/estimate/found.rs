//! What an estimator hands back, before it is judged.

use super::result::{Refinement, SimulationFit};
use crate::finding::Finding;
use crate::fit::Fitted;
use crate::model::Theta;

/// Half width of a 95 % interval of a normal error, in standard errors.
pub(crate) const NORMAL_95: f64 = 1.959_964;

/// What an estimator found, and what it says of itself.
pub(super) struct Found {
    pub(super) numbers: Numbers,
    pub(super) findings: Vec<Finding>,
}

/// The numbers that an estimator found.
pub(super) struct Numbers {
    /// Parameters, \[p\].
    pub(super) theta: Theta,
    /// Standard errors, \[p\].
    pub(super) errors: Vec<f64>,
    /// Whether each parameter is determined, \[p\].
    pub(super) seen: Vec<bool>,
    /// Half width of a 95 % interval in standard errors; infinite where they make none.
    pub(super) interval: f64,
    /// Its estimates over time, s; none if it takes the log as a whole.
    pub(super) points: Vec<(f64, Option<Theta>)>,
    /// What it makes small, and how well that went.
    pub(super) criterion: Criterion,
    /// Time that it took, s.
    pub(super) elapsed: f64,
}

/// What an estimator makes small.
pub(super) enum Criterion {
    /// What the filtered equations of the whole log leave.
    Equations,
    /// The same of the last samples, while they come.
    RecentEquations,
    /// The distance of a simulated loop from the log; nothing if none was simulated.
    Loop(Option<SimulationFit>),
    /// Minus the likelihood of the log; nothing if no filter followed it.
    Likelihood(Option<Box<Refinement>>),
}

impl Criterion {
    /// Returns how the simulated loop fits, if one was simulated.
    pub(super) fn simulation(&self) -> Option<&SimulationFit> {
        match self {
            Self::Loop(fit) => fit.as_ref(),
            Self::Equations | Self::RecentEquations | Self::Likelihood(_) => None,
        }
    }

    /// Returns how the filter fits, if one was run.
    pub(super) fn refinement(&self) -> Option<&Refinement> {
        match self {
            Self::Likelihood(refinement) => refinement.as_deref(),
            Self::Equations | Self::RecentEquations | Self::Loop(_) => None,
        }
    }

    /// Returns whether the motor rows alone and other ways to solve the equations of the
    /// whole log tell how far to trust the numbers.
    pub(super) fn stands_beside_equations(&self) -> bool {
        match self {
            Self::Equations | Self::Likelihood(_) => true,
            Self::RecentEquations | Self::Loop(_) => false,
        }
    }
}

impl Numbers {
    /// Returns those of least squares, which stand where another estimator fails.
    pub(super) fn of(fitted: &Fitted) -> Self {
        Self {
            theta: fitted.theta.clone(),
            errors: fitted.standard_error.clone(),
            seen: fitted.identifiable.clone(),
            interval: fitted.interval,
            points: Vec::new(),
            criterion: Criterion::Equations,
            elapsed: 0.0,
        }
    }
}
