//! The physics of flexible-joint robots, one sample at a time.
//!
//! This crate contains the only definition of the equations of motion. Identification builds its
//! regressor and simulation its right-hand side from the same columns. The crate needs no standard
//! library and allocates no memory, so the same code runs on a controller. The caller owns the
//! memory; functions such as [`memory_len`](recursive::memory_len) return the required lengths.
//!
//! Modules in the order of the data flow; each module uses only the modules before it:
//!
//! - [`scalar`]: numbers and truncated Taylor series,
//! - [`linear`]: solution of symmetric positive definite equations,
//! - [`spatial`]: motions and forces of rigid bodies, and the kernel of all link columns,
//! - [`chain`]: trees of joints,
//! - `space`: operations on motions and forces, in three dimensions or in a plane,
//! - [`presliding`]: elastic elements that remember the last reversal,
//! - [`friction`]: the table of friction laws, with one formula per law,
//! - [`parameters`]: kinds of parameter, their order, names and units,
//! - [`links`]: link columns of any tree,
//! - [`dynamics`]: torques and mass matrix of any tree,
//! - [`drives`]: rotor inertia, spring and friction columns of a joint,
//! - [`robot`]: links and drives as rows and entries of the regressor,
//! - `regressor`: the regressor `[Y_a | Y_b]` of one sample,
//! - `motion`: the equations of motion and the accelerations that solve them,
//! - [`linearized`]: derivatives of the accelerations,
//! - [`pull`]: derivatives of weighted sums of the regressor by the motion,
//! - [`servo`]: a position servo with the friction of its gear under load,
//! - [`filter`]: the filter pair `f_D`, `g_D`,
//! - [`observer`]: position, velocity and acceleration on line, and torques from outside,
//! - [`velocity`]: averaged velocity, computed on line,
//! - [`shaper`]: input shapers against residual vibration,
//! - [`controller`]: PD, and feedforward with state feedback,
//! - [`recursive`]: recursive least squares with forgetting (LSFF).
//!
//! All quantities are in SI units and radians. Units in parentheses are those of prismatic joints.
//! Equation numbers without a reference are those of Miranda-Colorado and Moreno-Valenzuela,
//! Robotica 2017.
// The compiler names each place that must handle a new law or parameter.
#![warn(clippy::wildcard_enum_match_arm)]
#![no_std]

pub mod chain;
pub mod controller;
pub mod covariate;
pub mod drives;
pub mod dynamics;
pub mod filter;
pub mod friction;
pub mod linear;
pub mod linearized;
pub mod links;
mod motion;
pub mod observer;
pub mod parameters;
pub mod presliding;
pub mod pull;
pub mod recursive;
mod regressor;
pub mod robot;
pub mod scalar;
pub mod servo;
pub mod shaper;
mod space;
pub mod spatial;
pub mod velocity;
