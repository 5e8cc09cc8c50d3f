//! Robot descriptions in URDF: links, joints, inertias.
//!
//! [`Urdf::parse`] checks a complete file; [`Urdf::tree`] reduces it to the joints that move in an
//! experiment. sprung does not read meshes, transmissions and simulator settings.
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
