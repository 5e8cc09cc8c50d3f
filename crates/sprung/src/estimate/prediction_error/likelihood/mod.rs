//! The likelihood of the levels of noise and disturbances, the filter being linear about
//! the last trajectory, with its exact gradient and a curvature. NOTATION.md has its
//! equations.
//!
//! [`forward`] goes the filter; [`backward`] go the derivatives of the loss by state and
//! covariance, which give those by all levels at once; forward once more goes, for
//! each level, what a change of it would add to the measurements ([`average_information`]).
//!
//! # Source
//!
//! Koopman and Shephard, Biometrika 1992: "Exact score for time series models in
//! state space form"; Gilmour, Thompson and Cullis, Biometrics 1995: "Average
//! information REML".

mod average_information;
mod backward;
mod forward;
mod level_gradient;
mod level_likelihood;
mod linear_run;

pub(super) use level_likelihood::{LevelLikelihood, Score};
