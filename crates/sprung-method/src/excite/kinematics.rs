//! Places and speeds of links and tool, with their derivatives.

use sprung_core::chain::{ChainJoint, JointKind};
use sprung_core::scalar::Scalar;
use sprung_core::spatial::{Vector, add, cross};

use crate::description::Tree;

/// A robot's chain with a point of the tool in the frame of its last link.
#[derive(Clone, Debug)]
pub struct Kinematics {
    joints: Vec<ChainJoint>,
    tool: [f64; 3],
    /// Unit vector against gravity in the frame of the base; the z axis without gravity.
    pub up: [f64; 3],
}

/// Origins of the joints' frames, then the tool; and the velocity of the tool; m and m/s.
#[derive(Clone, Debug)]
pub struct Places<S> {
    /// Origins of the frames of all joints, then the tool, \[n + 1\].
    pub points: Vec<Vector<S>>,
    /// Velocity of the tool.
    pub velocity: Vector<S>,
}

struct Frame<S> {
    axes: [Vector<S>; 3],
    origin: Vector<S>,
    velocity: Vector<S>,
    turning: Vector<S>,
}

impl Kinematics {
    /// Returns the kinematics of a tree.
    #[must_use]
    pub fn new(tree: &Tree, tool: [f64; 3], gravity: [f64; 3]) -> Self {
        let length = gravity.iter().map(|x| x * x).sum::<f64>().sqrt();
        Self {
            joints: tree.joints.clone(),
            tool,
            up: if length > 0.0 {
                gravity.map(|x| -x / length)
            } else {
                [0.0, 0.0, 1.0]
            },
        }
    }

    /// Returns the index of the joint that carries each joint.
    #[must_use]
    pub fn parents(&self) -> Vec<Option<usize>> {
        self.joints.iter().map(|joint| joint.parent).collect()
    }

    /// Returns the points that move, links first, then the tool, each with the joint that carries it. The origin of a joint on
    /// the base does not move.
    #[must_use]
    pub fn moving(&self) -> Vec<(usize, usize)> {
        let links = self.joints.iter().enumerate();
        let mut all: Vec<(usize, usize)> = links
            .filter_map(|(point, joint)| Some((point, joint.parent?)))
            .collect();
        if let Some(last) = self.joints.len().checked_sub(1) {
            all.push((last + 1, last));
        }
        all
    }

    /// Returns places and the tool's velocity.
    ///
    /// - `q`, `dq`: \[n\], rad (m), rad/s (m/s).
    pub fn places<S: Scalar>(&self, q: &[S], dq: &[S]) -> Places<S> {
        let mut frames: Vec<Frame<S>> = Vec::with_capacity(self.joints.len());
        for (joint, (&q, &dq)) in self.joints.iter().zip(q.iter().zip(dq)) {
            let transform = joint.transform(q);
            let base = Frame {
                axes: [0, 1, 2].map(|i| {
                    let mut axis = [S::ZERO; 3];
                    axis[i] = S::constant(1.0);
                    axis
                }),
                origin: [S::ZERO; 3],
                velocity: [S::ZERO; 3],
                turning: [S::ZERO; 3],
            };
            let parent = joint.parent.map_or(&base, |parent| &frames[parent]);
            let arm = out(&parent.axes, &transform.origin);
            let axes = transform.axes.map(|axis| out(&parent.axes, &axis));
            let along = out(&axes, &joint.axis.map(S::constant));
            let mut velocity = add(&parent.velocity, &cross(&parent.turning, &arm));
            let mut turning = parent.turning;
            let joint_rate = along.map(|x| x * dq);
            match joint.kind {
                JointKind::Revolute => turning = add(&turning, &joint_rate),
                JointKind::Prismatic => velocity = add(&velocity, &joint_rate),
            }
            frames.push(Frame {
                axes,
                origin: add(&parent.origin, &arm),
                velocity,
                turning,
            });
        }
        let mut points: Vec<Vector<S>> = frames.iter().map(|frame| frame.origin).collect();
        let mut velocity = [S::ZERO; 3];
        if let Some(last) = frames.last() {
            let arm = out(&last.axes, &self.tool.map(S::constant));
            points.push(add(&last.origin, &arm));
            velocity = add(&last.velocity, &cross(&last.turning, &arm));
        }
        Places { points, velocity }
    }

    /// Returns the height of a point.
    pub fn height<S: Scalar>(&self, point: &Vector<S>) -> S {
        point[0] * self.up[0] + point[1] * self.up[1] + point[2] * self.up[2]
    }
}

/// Returns a vector with components along three axes.
fn out<S: Scalar>(axes: &[Vector<S>; 3], v: &Vector<S>) -> Vector<S> {
    let [x, y, z] = axes;
    [0, 1, 2].map(|i| x[i] * v[0] + y[i] * v[1] + z[i] * v[2])
}
