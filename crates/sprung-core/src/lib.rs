//! The physics of flexible-joint robots, one sample at a time.
//!
//! This crate is the only place where the equations of motion are written.
//! Its columns build the regressor of an identification and the right-hand
//! side of a simulation alike. It needs no standard library and allocates
//! nothing, so that the same code runs on a controller: the caller owns the
//! memory, and a twin function says how much is needed.
//!
//! Modules in the order of the data flow; each uses only those before it:
//!
//! - [`scalar`]: numbers and truncated Taylor series,
//! - [`linear`]: positive definite equations,
//! - [`spatial`]: motions of rigid bodies and the kernel of every link column,
//! - [`chain`]: trees of joints,
//! - `space`: what the algorithms on trees do with motions, in space or in a plane,
//! - [`friction`]: the table of friction laws, one formula each,
//! - [`parameters`]: kinds of parameter, their order, names and units,
//! - [`links`]: link columns of any tree,
//! - [`dynamics`]: torques and mass matrix of any tree,
//! - [`drives`]: rotor inertia, spring and friction columns of a joint,
//! - [`robot`]: links and drives as rows and entries,
//! - `regressor`: one sample's `[Y_a | Y_b]`,
//! - `motion`: the equations of motion and the accelerations that solve them,
//! - [`linearized`]: derivatives of the accelerations,
//! - [`filter`]: the filter pair `f_D`, `g_D`,
//! - [`velocity`]: on-line averaged velocity,
//! - [`controller`]: PD, and feedforward with state feedback,
//! - [`recursive`]: recursive least squares with forgetting (LSFF).
//!
//! All quantities are in SI units and radians. Equation numbers without a key
//! are those of Miranda-Colorado and Moreno-Valenzuela, Robotica 2017.
#![no_std]

pub mod chain;
pub mod controller;
pub mod drives;
pub mod dynamics;
pub mod filter;
pub mod friction;
pub mod linear;
pub mod linearized;
pub mod links;
mod motion;
pub mod parameters;
pub mod recursive;
mod regressor;
pub mod robot;
pub mod scalar;
mod space;
pub mod spatial;
pub mod velocity;
