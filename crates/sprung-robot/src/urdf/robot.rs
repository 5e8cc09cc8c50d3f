//! Links and joints of a file, and the joints that move in an experiment.

use sprung_core::chain::{ChainJoint, JointKind};

use super::body::{Body, Placement};
use super::error::UrdfError;
use super::geometry::Geometry;
use crate::limits::Limits as KnownLimits;

/// A robot description: the checked links and joints of a file.
///
/// The joints form one tree, names are unique, numbers are finite.
#[derive(Clone, Debug)]
pub struct Urdf {
    /// Sentences about what the file says otherwise than a URDF should, without their last full stops.
    pub(super) notes: Vec<String>,
    pub(super) file: String,
    pub(super) name: String,
    pub(super) links: Vec<Link>,
    /// Parents come before children.
    pub(super) joints: Vec<Joint>,
    pub(super) movable: Vec<UrdfJoint>,
}

/// A movable joint of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct UrdfJoint {
    /// Its name.
    pub name: String,
    /// Name of the link that it moves.
    pub child: String,
    /// Revolute or prismatic.
    pub kind: JointKind,
    /// Whether it turns without position limits.
    pub continuous: bool,
    /// Lower limit of its position, rad or m; `None` for a continuous joint.
    pub lower: Option<f64>,
    /// Upper limit of its position, rad or m; `None` for a continuous joint.
    pub upper: Option<f64>,
    /// Limit of its torque or force, N·m or N; exporters write 0 for an unknown limit.
    pub effort: Option<f64>,
    /// Limit of its velocity, rad/s or m/s; exporters write 0 for an unknown limit.
    pub velocity: Option<f64>,
    /// Whether it carries no other movable joint.
    pub is_last: bool,
}

/// A moving joint of a reduced tree; its link includes all bodies that are fixed to it.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeJoint {
    /// Its name.
    pub name: String,
    /// Name of the link that it moves.
    pub link: String,
    /// Its parent, placement, axis and kind.
    pub joint: ChainJoint,
    /// Inertial parameters in the order of
    /// [`BODY_NAMES`](sprung_core::spatial::BODY_NAMES): mass, kg, first
    /// moments, kg·m, and inertia, kg·m², about the origin of the joint's frame
    /// in its axes; `None` if no merged body has an `<inertial>`.
    pub inertial: Option<[f64; 10]>,
    /// Its limits, without those of zero, which exporters write for unknown ones.
    pub limits: KnownLimits,
}

#[derive(Clone, Debug)]
pub(super) struct Link {
    pub(super) name: String,
    pub(super) line: usize,
    pub(super) body: Option<Body>,
    /// Its forms, or why one cannot be used.
    pub(super) geometry: Vec<Result<Geometry, UrdfError>>,
}

#[derive(Clone, Debug)]
pub(super) struct Joint {
    pub(super) name: String,
    pub(super) line: usize,
    /// Indices into the links.
    pub(super) parent: usize,
    pub(super) child: usize,
    /// Its frame in the frame of the parent link.
    pub(super) placement: Placement,
    pub(super) mobility: Mobility,
}

#[derive(Clone, Debug)]
pub(super) enum Mobility {
    Fixed,
    /// It follows another joint, so it has no motor.
    Mimic {
        leader: String,
    },
    Own(Freedom),
}

/// The motion of a joint and its limits.
#[derive(Clone, Debug)]
pub(super) struct Freedom {
    pub(super) kind: JointKind,
    pub(super) continuous: bool,
    /// Unit vector in the joint's frame.
    pub(super) axis: [f64; 3],
    pub(super) limits: Limits,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Limits {
    pub(super) lower: Option<f64>,
    pub(super) upper: Option<f64>,
    pub(super) effort: Option<f64>,
    pub(super) velocity: Option<f64>,
}

impl Limits {
    /// Returns the limits with a meaning.
    pub(super) fn known(&self) -> KnownLimits {
        let positive = |value: Option<f64>| value.filter(|value| *value > 0.0);
        let positions = self.lower.zip(self.upper);
        KnownLimits {
            position_rad: (positions.filter(|(low, high)| low < high)).map(<[f64; 2]>::from),
            velocity_rad_per_s: positive(self.velocity),
            torque_nm: positive(self.effort),
            ..KnownLimits::default()
        }
    }
}

impl Urdf {
    /// Returns the name of the robot.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns whether the file describes the mass of a link that moves.
    pub(crate) fn has_bodies(&self) -> bool {
        (self.joints.iter())
            .filter(|joint| !matches!(joint.mobility, Mobility::Fixed))
            .any(|joint| self.links[joint.child].body.is_some())
    }

    /// Returns the revolute, continuous and prismatic joints, at least one: parents before children,
    /// otherwise in the order of the file.
    ///
    /// Joints that mimic another are left out.
    #[must_use]
    pub fn movable(&self) -> &[UrdfJoint] {
        &self.movable
    }

    /// Returns sentences about what the file says otherwise than a URDF should, and about bodies that cannot be, without
    /// their last full stops.
    pub(crate) fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Returns the joints that mimic another, each with the name of the joint that it follows.
    pub fn mimics(&self) -> impl Iterator<Item = (&str, &str)> {
        self.joints
            .iter()
            .filter_map(|joint| match &joint.mobility {
                Mobility::Mimic { leader } => Some((&*joint.name, &**leader)),
                Mobility::Fixed | Mobility::Own(_) => None,
            })
    }
}
