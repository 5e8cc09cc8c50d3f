//! Robots as URDF describes them: links, joints, inertias.
//!
//! [`Urdf::parse`] checks a file as a whole; [`Urdf::tree`] reduces it to the
//! joints that move in an experiment. Meshes, transmissions and simulator
//! settings are not read.
//!
//! # Source
//!
//! <http://wiki.ros.org/urdf/XML>.

mod body;
mod error;
mod parse;
mod robot;
mod tree;
mod xml;

#[cfg(test)]
mod refusals;
#[cfg(test)]
mod tests;

pub use error::UrdfError;
pub use robot::{TreeJoint, Urdf, UrdfJoint};
