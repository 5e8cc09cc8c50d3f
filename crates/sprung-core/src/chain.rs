//! Trees of joints: who carries whom, where and about which axis.

use crate::scalar::Scalar;
use crate::spatial::{Motion, Transform, Vector, dot, product, rotation, transposed};

/// How a joint moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// It turns about its axis.
    Revolute,
    /// It slides along its axis.
    Prismatic,
}

/// One joint and the link that it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChainJoint {
    /// The joint that carries it; nothing if the base does.
    pub parent: Option<usize>,
    /// Its frame in the parent's frame at position zero: columns are its axes.
    pub rotation: [Vector; 3],
    /// Its origin in the parent's frame at position zero, m.
    pub origin: Vector,
    /// Unit vector of its axis, in its own frame.
    pub axis: Vector,
    /// How it moves.
    pub kind: JointKind,
}

/// What is wrong with a tree of joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ChainError {
    /// A joint is carried by itself or by one that comes later.
    Order {
        /// The joint.
        joint: usize,
        /// The joint that shall carry it.
        parent: usize,
    },
    /// The axis of a joint has no unit length.
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

/// Where the links of a tree can move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motions {
    /// In the plane across the z axes of all frames: turns about z, slides across.
    InPlane,
    /// Anywhere.
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
    /// [`ChainError`] if a parent does not come first or an axis has no unit
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

    /// Returns the tree of joints that [`Chain::new`] has accepted before.
    ///
    /// - `motions`: those of the tree that it returned.
    #[must_use]
    pub const fn checked(joints: &'a [ChainJoint], gravity: Vector, motions: Motions) -> Self {
        Self {
            joints,
            gravity,
            motions,
        }
    }

    /// Returns where the links can move.
    #[must_use]
    pub const fn motions(&self) -> Motions {
        self.motions
    }

    /// Returns the joints.
    #[must_use]
    pub fn joints(&self) -> &'a [ChainJoint] {
        self.joints
    }

    /// Returns the acceleration of the base that stands for gravity; nothing if
    /// gravity does no work on any motion.
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
    /// Returns a revolute joint of a modified table: its row holds the twist
    /// and the length of the link before it.
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

    /// Returns a revolute joint of a classic table, in which the row of a joint
    /// holds what lies between it and the next.
    ///
    /// - `before`: row of the joint that carries it; nothing for the first.
    #[must_use]
    pub fn classic_dh(parent: Option<usize>, before: Option<&DhRow>, row: &DhRow) -> Self {
        let before = before.copied().unwrap_or_default();
        // Rot(z, theta) Trans(z, d) Trans(x, a) Rot(x, alpha) seen from the
        // turned frame of the joint before is the rest of that product.
        let twist = rotation(&[1.0, 0.0, 0.0], before.alpha);
        Self {
            parent,
            rotation: product(&twist, &rotation(&[0.0, 0.0, 1.0], row.theta)),
            origin: [before.a, 0.0, before.d],
            axis: [0.0, 0.0, 1.0],
            kind: JointKind::Revolute,
        }
    }

    /// Returns whether the joint leaves its link in the plane across the z axis of
    /// its parent's frame, and z along z.
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

    /// Returns the joint's axis as a motion, in its own frame.
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

    /// Returns the transform from the parent's frame at position `q`, rad or m.
    #[must_use]
    pub fn transform<S: Scalar>(&self, q: S) -> Transform<S> {
        match self.kind {
            // A turn about z, as of every table, costs less than one about any axis.
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
