//! Trees of joints: parents, placements and axes.

use crate::scalar::Scalar;
use crate::spatial::{Motion, Transform, Vector, dot, product, rotation, transposed};

/// Kind of motion of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// The joint turns about its axis.
    Revolute,
    /// The joint slides along its axis.
    Prismatic,
}

/// One joint and the link that it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChainJoint {
    /// Index of the joint that carries this joint; `None` for a joint on the base.
    pub parent: Option<usize>,
    /// Rotation matrix from the joint's frame to the parent's frame at position zero, row by row;
    /// its columns are the joint's axes.
    pub rotation: [Vector; 3],
    /// Origin of the joint's frame in the parent's frame at position zero, m.
    pub origin: Vector,
    /// Unit vector of the joint's axis, in the joint's frame.
    pub axis: Vector,
    /// Whether the joint turns or slides.
    pub kind: JointKind,
}

/// Errors of the description of a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ChainError {
    /// The parent of a joint does not come before the joint.
    Order {
        /// The joint.
        joint: usize,
        /// The parent of the joint.
        parent: usize,
    },
    /// The axis of a joint does not have unit length.
    Axis {
        /// The joint.
        joint: usize,
    },
}

impl core::fmt::Display for ChainError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Order { joint, parent } => write!(
                f,
                "joint {joint} is carried by joint {parent}, which must come before it"
            ),
            Self::Axis { joint } => write!(f, "the axis of joint {joint} has no unit length"),
        }
    }
}

impl core::error::Error for ChainError {}

/// The space in which the links of a tree can move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motions {
    /// In the plane perpendicular to the z axes of all frames: joints turn about z or slide
    /// perpendicular to z.
    InPlane,
    /// In three dimensions.
    InSpace,
}

/// A tree of joints on a fixed base; parents come before their children.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chain<'a> {
    joints: &'a [ChainJoint],
    gravity: Vector,
    motions: Motions,
}

impl<'a> Chain<'a> {
    /// Returns the tree of these joints.
    ///
    /// - `gravity`: acceleration of free fall in the base's frame, m/s².
    ///
    /// # Errors
    ///
    /// [`ChainError`] if a parent does not come before its child or an axis does not have unit
    /// length.
    pub fn new(joints: &'a [ChainJoint], gravity: Vector) -> Result<Self, ChainError> {
        for (joint, described) in joints.iter().enumerate() {
            if let Some(parent) = described.parent.filter(|parent| *parent >= joint) {
                return Err(ChainError::Order { joint, parent });
            }
            let length = dot(&described.axis, &described.axis);
            if length.is_nan() || (length - 1.0).abs() > 1e-9 {
                return Err(ChainError::Axis { joint });
            }
        }
        let in_plane = joints.iter().all(ChainJoint::moves_in_plane);
        Ok(Self {
            joints,
            gravity,
            motions: if in_plane {
                Motions::InPlane
            } else {
                Motions::InSpace
            },
        })
    }

    /// Returns the tree of joints that [`Chain::new`] has accepted, without checking them again.
    ///
    /// - `motions`: [`Chain::motions`] of the tree that [`Chain::new`] returned.
    #[must_use]
    pub const fn checked(joints: &'a [ChainJoint], gravity: Vector, motions: Motions) -> Self {
        Self {
            joints,
            gravity,
            motions,
        }
    }

    /// Returns the space in which the links can move.
    #[must_use]
    pub const fn motions(&self) -> Motions {
        self.motions
    }

    /// Returns the joints.
    #[must_use]
    pub fn joints(&self) -> &'a [ChainJoint] {
        self.joints
    }

    /// Returns the acceleration of the base that has the effect of gravity; `None` if gravity does
    /// no work on any motion.
    #[must_use]
    pub(crate) fn base_acceleration(&self) -> Option<Motion> {
        let [x, y, z] = self.gravity;
        let weightless = match self.motions {
            Motions::InPlane => x.abs().max(y.abs()) <= 0.0,
            Motions::InSpace => x.abs().max(y.abs()).max(z.abs()) <= 0.0,
        };
        (!weightless).then(|| Motion {
            angular: [0.0; 3],
            linear: self.gravity.map(|g| -g),
        })
    }
}

/// One row of a Denavit-Hartenberg table.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DhRow {
    /// Twist alpha, rad.
    pub alpha: f64,
    /// Length a, m.
    pub a: f64,
    /// Offset d, m.
    pub d: f64,
    /// Angle theta at position zero, rad.
    pub theta: f64,
}

impl ChainJoint {
    /// Returns a revolute joint of a modified table. Its row contains the twist and the length of
    /// the previous link.
    ///
    /// # Source
    ///
    /// Craig, Introduction to Robotics; Table I of the paper.
    #[must_use]
    pub fn modified_dh(parent: Option<usize>, row: &DhRow) -> Self {
        let twist = rotation(&[1.0, 0.0, 0.0], row.alpha);
        Self {
            parent,
            rotation: product(&twist, &rotation(&[0.0, 0.0, 1.0], row.theta)),
            origin: [row.a, row.d * twist[1][2], row.d * twist[2][2]],
            axis: [0.0, 0.0, 1.0],
            kind: JointKind::Revolute,
        }
    }

    /// Returns a revolute joint of a classic table, in which the row of a joint describes the
    /// placement of the next joint.
    ///
    /// - `before`: row of the parent; `None` for a joint on the base.
    #[must_use]
    pub fn classic_dh(parent: Option<usize>, before: Option<&DhRow>, row: &DhRow) -> Self {
        let before = before.copied().unwrap_or_default();
        // The parent's frame contains Rot(z, theta) of its row. The rest of the row's product,
        // Trans(z, d) Trans(x, a) Rot(x, alpha), places this joint.
        let twist = rotation(&[1.0, 0.0, 0.0], before.alpha);
        Self {
            parent,
            rotation: product(&twist, &rotation(&[0.0, 0.0, 1.0], row.theta)),
            origin: [before.a, 0.0, before.d],
            axis: [0.0, 0.0, 1.0],
            kind: JointKind::Revolute,
        }
    }

    /// Returns whether the link moves in the plane perpendicular to the z axis of the parent's
    /// frame, and both z axes are parallel.
    fn moves_in_plane(&self) -> bool {
        let zero = |x: f64| x.abs() <= 0.0;
        let [[_, _, xz], [_, _, yz], [zx, zy, zz]] = self.rotation;
        let upright = [xz, yz, zx, zy, zz - 1.0].into_iter().all(zero);
        let [x, y, z] = self.axis;
        upright
            && match self.kind {
                JointKind::Revolute => zero(x) && zero(y),
                JointKind::Prismatic => zero(z),
            }
    }

    fn turns_about_z(&self) -> bool {
        let [x, y, z] = self.axis;
        x.abs().max(y.abs()) <= 0.0 && z > 0.0
    }

    /// Returns the motion of the link at a joint rate of one, in the joint's frame.
    #[must_use]
    pub(crate) fn motion(&self) -> Motion {
        match self.kind {
            JointKind::Revolute => Motion {
                angular: self.axis,
                linear: [0.0; 3],
            },
            JointKind::Prismatic => Motion {
                angular: [0.0; 3],
                linear: self.axis,
            },
        }
    }

    /// Returns the transform from the parent's frame to the joint's frame at position `q`, rad (m).
    #[must_use]
    pub fn transform<S: Scalar>(&self, q: S) -> Transform<S> {
        match self.kind {
            // A rotation about z, the axis in every table, needs fewer operations than one about
            // any axis.
            JointKind::Revolute if self.turns_about_z() => {
                let (sin, cos) = q.sin_cos();
                Transform {
                    axes: [
                        self.rotation.map(|r| cos * r[0] + sin * r[1]),
                        self.rotation.map(|r| cos * r[1] - sin * r[0]),
                        self.rotation.map(|r| S::constant(r[2])),
                    ],
                    origin: self.origin.map(S::constant),
                }
            }
            JointKind::Revolute => Transform {
                axes: transposed(&product(&self.rotation, &rotation(&self.axis, q))),
                origin: self.origin.map(S::constant),
            },
            JointKind::Prismatic => Transform {
                axes: transposed(&self.rotation).map(|axis| axis.map(S::constant)),
                origin: core::array::from_fn(|i| {
                    S::constant(self.origin[i]) + q * dot(&self.rotation[i], &self.axis)
                }),
            },
        }
    }
}
