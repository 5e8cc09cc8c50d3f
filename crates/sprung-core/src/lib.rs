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
//! - [`friction`]: friction columns, one function per law,
//! - [`spatial`]: motions of rigid bodies and the kernel of every link column,
//! - [`chain`]: trees of joints,
//! - [`parameters`]: kinds of parameter, their order, names and units,
//! - [`links`]: link columns of any tree,
//! - [`dynamics`]: torques and accelerations of any tree,
//! - [`planar_2r`]: link columns of the planar arm with two joints, in closed form,
//! - [`drives`]: rotor inertia, spring and friction columns of a joint,
//! - [`regressor`]: one sample's `[Y_a | Y_b]`, and the same as dynamics,
//! - [`linearized`]: accelerations and their derivatives,
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
pub mod linearized;
pub mod links;
pub mod parameters;
pub mod planar_2r;
pub mod recursive;
pub mod regressor;
pub mod scalar;
pub mod spatial;
pub mod velocity;
