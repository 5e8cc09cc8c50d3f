//! Possible bodies: inertial parameters of single links with positive definite second moments, positive
//! rotor inertias, stiffnesses and friction, nearest to an estimate and to nominal values.
//!
//! The program minimises the squared distance from the estimate in the metric of its information, plus the distance
//! from the nominal values of the bodies. It has one unknown per inertial parameter of a link, so the result is a full
//! set of parameters. The log decides the base parameters; the nominal values decide the rest.
//!
//! # Source
//!
//! Sousa and Cortesão, "Physical feasibility of robot base inertial parameter identification: a linear
//! matrix inequality approach", International Journal of Robotics Research, 2014. Lee, Wensing and Park,
//! "Geometric robot dynamic identification: a convex programming approach", IEEE Transactions on
//! Robotics, 2020, for the entropic distance.

mod bodies;
mod information;
mod problem;
mod regions;

pub(super) use bodies::Bodies;
pub(super) use information::{covariance, information, limits, of_equations, widened};
pub(super) use problem::{bodies_of, physical};
