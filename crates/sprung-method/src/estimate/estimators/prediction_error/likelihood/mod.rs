//! The likelihood of the levels of noise and disturbances, with its exact gradient and a curvature.
//! The filter is linearised about the last trajectory. NOTATION.md contains the equations.
//!
//! [`forward`] runs the filter. [`backward`] propagates the derivatives of the loss by state and
//! covariance, which give the derivatives by all levels at once. [`average_information`] runs
//! forward again with the contribution that a change of each level makes to the measurements.
//!
//! # Source
//!
//! Koopman and Shephard, Biometrika 1992: "Exact score for time series models in state space form";
//! Gilmour, Thompson and Cullis, Biometrics 1995: "Average information REML".

mod average_information;
mod backward;
mod forward;
mod information_ahead;
mod level_gradient;
mod level_likelihood;
mod linear_run;
mod noise_behind;

pub(super) use information_ahead::information_ahead;
pub(super) use level_likelihood::{LevelLikelihood, Score, Searched};
pub(super) use noise_behind::noise_behind;
