//! Draws of robots that can exist from the posterior of an identification.
//!
//! ```text
//! density of x  ∝  N(θ(x); θ̂, C) · π(x | θ(x))    over the robots that can exist
//! ```
//!
//! The unknowns x are those of [`Robots`](crate::estimate::possible::Robots): all inertial parameters of links and
//! rotors, and the drives. θ̂ and C are the estimate without constraints and its covariance; the set is that of the
//! estimate. The log determines only θ. The prior π, a normal distribution about nominal or ordinary bodies, decides
//! the rest and does not change θ where no constraint is active. If at least a twentieth of normal draws are possible
//! robots, rejection sampling gives independent draws. Else chains of Gibbs steps draw them: each step draws one
//! coordinate exactly, from a normal distribution between the two borders of the set.
//!
//! # Source
//!
//! Geman and Geman, "Stochastic relaxation, Gibbs distributions, and the Bayesian restoration of images", IEEE Transactions
//! on Pattern Analysis and Machine Intelligence, 1984, for the steps. Kannan and Narayanan, "Random walks on polytopes and an
//! affine interior point method for linear programming", Mathematics of Operations Research, 2012, for coordinates by the
//! second derivatives of the barrier.

mod body;
mod borders;
mod centre;
mod chains;
mod density;
mod distribution;
mod errors;
mod evidence;
mod normal;
mod plain;
mod rest;
mod samples;
#[cfg(test)]
mod tests;
mod truncated;

pub use body::Body;
pub use distribution::Posterior;
pub use errors::PosteriorError;
pub use samples::{DrawMethod, Samples};
