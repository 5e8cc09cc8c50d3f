//! Robot descriptions in URDF: links, joints, inertias, shapes.
//!
//! [`Urdf::parse`] checks a complete file; [`Urdf::tree`] reduces it to the joints that move in an
//! experiment. Faults of geometry are no errors, because only the places of masses depend on it. sprung does not read
//! transmissions and simulator settings.
//!
//! # Source
//!
//! <http://wiki.ros.org/urdf/XML>.

mod body;
mod error;
mod geometry;
mod mesh;
mod no_shape;
mod parse;
mod robot;
mod shape;
mod tree;
mod xml;

#[cfg(test)]
mod refusals;
#[cfg(test)]
mod tests;

pub use error::UrdfError;
pub(crate) use no_shape::LARGEST_MESH;
pub use no_shape::NoShape;
pub use robot::{TreeJoint, Urdf, UrdfJoint};
pub use shape::Shape;
