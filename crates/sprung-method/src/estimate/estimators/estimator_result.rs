//! Result of an estimator before it is judged.

use crate::estimate::result::{ErrorParts, Refinement};
use crate::finding::Finding;
use crate::fit::Fitted;
use crate::model::Theta;
use crate::unknowns::UnknownResult;

/// Result of an estimator with its own findings.
pub(in crate::estimate) struct Found {
    pub(in crate::estimate) numbers: Numbers,
    pub(in crate::estimate) findings: Vec<Finding>,
    /// What the logs show beyond the model of this estimator.
    pub(in crate::estimate) unknowns: Vec<UnknownResult>,
}

/// Numerical result of an estimator.
pub(in crate::estimate) struct Numbers {
    /// Parameters, \[p\].
    pub(in crate::estimate) theta: Theta,
    /// Parameters by the same criterion without constraints, \[p\]; `None` if the estimator has no constraints.
    pub(in crate::estimate) unconstrained: Option<Theta>,
    /// Standard errors without constraints, \[p\].
    pub(in crate::estimate) errors: Vec<f64>,
    /// Contributions to the standard errors, \[p\]; empty if the estimator gives none.
    pub(in crate::estimate) error_parts: Vec<ErrorParts>,
    /// Covariance by the estimator; `None` if the equations give it.
    pub(in crate::estimate) covariance: Option<Covariance>,
    /// Whether each parameter is determined, \[p\].
    pub(in crate::estimate) identifiable: Vec<bool>,
    /// Half width of a 95 % interval in standard errors; infinite if the standard errors give no
    /// interval.
    pub(in crate::estimate) interval: f64,
    /// Estimates over time, s; empty if the estimator uses the log as a whole.
    pub(in crate::estimate) points: Vec<(f64, Option<Theta>)>,
    /// The criterion that the estimator minimises, with its figures of fit.
    pub(in crate::estimate) criterion: Criterion,
    /// Computing time, s.
    pub(in crate::estimate) elapsed: f64,
}

/// Covariance of some parameters.
#[derive(Clone, Debug)]
pub(in crate::estimate) struct Covariance {
    /// Their indices in theta.
    pub(in crate::estimate) free: Vec<usize>,
    /// \[free × free\].
    pub(in crate::estimate) values: Vec<f64>,
}

/// Criterion that an estimator minimises.
pub(in crate::estimate) enum Criterion {
    /// Residuals of the filtered equations of the whole log.
    Equations,
    /// Residuals of the filtered equations of the latest samples, recursively.
    RecentEquations,
    /// Minus the likelihood of the log; `None` if the filter did not follow the log.
    Likelihood(Option<Box<Refinement>>),
}

impl Criterion {
    /// Returns the fit of the filter, if the filter followed the log.
    pub(in crate::estimate) fn refinement(&self) -> Option<&Refinement> {
        match self {
            Self::Likelihood(refinement) => refinement.as_deref(),
            Self::Equations | Self::RecentEquations => None,
        }
    }

    /// Returns whether the result is compared with the motor rows alone and with the cross-checks.
    /// This needs equations of the whole log.
    pub(in crate::estimate) fn stands_beside_equations(&self) -> bool {
        match self {
            Self::Equations | Self::Likelihood(_) => true,
            Self::RecentEquations => false,
        }
    }
}

impl Numbers {
    /// Returns the numbers of least squares. They are the result where another estimator fails.
    pub(in crate::estimate) fn of(fitted: &Fitted) -> Self {
        Self {
            theta: fitted.theta.clone(),
            unconstrained: None,
            errors: fitted.standard_error.clone(),
            error_parts: (0..fitted.theta.len())
                .map(|i| ErrorParts {
                    sampling: fitted.sampling_error[i],
                    between_parts: fitted.between_parts[i],
                    bias: fitted.bias[i],
                })
                .collect(),
            covariance: None,
            identifiable: fitted.identifiable.clone(),
            interval: fitted.interval,
            points: Vec::new(),
            criterion: Criterion::Equations,
            elapsed: 0.0,
        }
    }
}
