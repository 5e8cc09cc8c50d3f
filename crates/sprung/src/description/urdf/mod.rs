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
mod tree;
mod xml;

#[cfg(test)]
mod refusals;
#[cfg(test)]
mod tests;

use sprung_core::chain::{ChainJoint, JointKind};

use body::{Body, Placement};

pub use error::UrdfError;

/// A robot description: links and joints as the file has them, checked.
///
/// The joints form one tree, names are unique, numbers are finite.
#[derive(Clone, Debug)]
pub struct Urdf {
    file: String,
    name: String,
    links: Vec<Link>,
    /// Parents come before children.
    joints: Vec<Joint>,
    movable: Vec<UrdfJoint>,
}

/// One joint that can move, as the file has it.
#[derive(Clone, Debug, PartialEq)]
pub struct UrdfJoint {
    /// Its name.
    pub name: String,
    /// Name of the link that it moves.
    pub child: String,
    /// How it moves.
    pub kind: JointKind,
    /// Whether it turns without end.
    pub continuous: bool,
    /// Lower limit of its position, rad or m; a continuous joint has none.
    pub lower: Option<f64>,
    /// Upper limit of its position, rad or m; a continuous joint has none.
    pub upper: Option<f64>,
    /// Limit of its torque or force, N·m or N; exporters write 0 for unknown.
    pub effort: Option<f64>,
    /// Limit of its velocity, rad/s or m/s; exporters write 0 for unknown.
    pub velocity: Option<f64>,
}

/// One moving joint of a reduced tree, its link with everything fixed to it
/// merged.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeJoint {
    /// Its name.
    pub name: String,
    /// Name of the link that it moves.
    pub link: String,
    /// Who carries it, where, and how it moves.
    pub joint: ChainJoint,
    /// Inertial parameters in the order of
    /// [`BODY_NAMES`](sprung_core::spatial::BODY_NAMES): mass, kg, first
    /// moments, kg·m, and inertia, kg·m², about the origin of the joint's frame
    /// in its axes; nothing if no merged body has an `<inertial>`.
    pub inertial: Option<[f64; 10]>,
    /// Limit of its torque or force, N·m or N.
    pub effort: Option<f64>,
}

#[derive(Clone, Debug)]
struct Link {
    name: String,
    line: usize,
    body: Option<Body>,
}

#[derive(Clone, Debug)]
struct Joint {
    name: String,
    line: usize,
    /// Indices into the links.
    parent: usize,
    child: usize,
    /// Its frame in the parent link's.
    placement: Placement,
    mobility: Mobility,
}

#[derive(Clone, Debug)]
enum Mobility {
    Fixed,
    /// It follows another joint and has no motor.
    Mimic {
        leader: String,
    },
    Own(Freedom),
}

/// How a joint moves and how far.
#[derive(Clone, Debug)]
struct Freedom {
    kind: JointKind,
    continuous: bool,
    /// Of unit length, in the joint's frame.
    axis: [f64; 3],
    limits: Limits,
}

#[derive(Clone, Debug, Default)]
struct Limits {
    lower: Option<f64>,
    upper: Option<f64>,
    effort: Option<f64>,
    velocity: Option<f64>,
}

impl Urdf {
    /// Reads a robot description.
    ///
    /// - `file`: name for messages.
    /// - `text`: contents of the file; macros of xacro must be expanded.
    ///
    /// # Errors
    ///
    /// [`UrdfError`] with the line if the text is not XML, not one tree of
    /// revolute, continuous, prismatic and fixed joints, or has a number that
    /// is none.
    pub fn parse(file: &str, text: &str) -> Result<Self, UrdfError> {
        parse::parse(file, text)
    }

    /// Returns the name of the robot.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the revolute, continuous and prismatic joints, parents before
    /// children, otherwise in the order of the file; at least one.
    ///
    /// Joints that mimic another are not among them.
    #[must_use]
    pub fn movable(&self) -> &[UrdfJoint] {
        &self.movable
    }

    /// Returns the tree of the named joints, in that order.
    ///
    /// All other joints are fixed at zero and their bodies merged into the body
    /// that carries them. What no named joint carries belongs to the base, whose
    /// frame is the root link's; it is left out.
    ///
    /// - `moving`: names of joints; a joint comes before those that it carries.
    ///
    /// # Errors
    ///
    /// [`UrdfError`] if there is no such joint, if it is fixed or mimics
    /// another, is listed twice, or after a joint that it carries.
    pub fn tree(&self, moving: &[&str]) -> Result<Vec<TreeJoint>, UrdfError> {
        tree::tree(self, moving)
    }
}
