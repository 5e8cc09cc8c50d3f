//! Operations on motions and forces, in three dimensions or in a plane.
//!
//! Every algorithm on trees is written once over [`Space`]. If all joints of a tree move in one
//! plane, most numbers of its motions and forces are zero, and [`Planar`] skips them.

use core::ops::Mul;

use crate::chain::{ChainJoint, JointKind};
use crate::scalar::Scalar;
use crate::spatial::{self, BODY, Force, Motion, Transform, Vector};

/// Operations on motions, forces and bodies in the frame of a joint.
pub(crate) trait Space {
    /// Indices of the inertial parameters that affect motions in this space.
    const SHOWN: &'static [usize];

    /// Returns the transform from the parent's frame to the joint's frame at position `q`, rad (m).
    fn transform<S: Scalar>(joint: &ChainJoint, q: S) -> Transform<S>;

    /// Transforms a motion from the parent's frame to the child's frame.
    fn apply<S: Scalar>(transform: &Transform<S>, motion: &Motion<S>) -> Motion<S>;

    /// Transforms a force from the child's frame to the parent's frame and adds it to `sum`.
    fn add_back<S: Scalar>(transform: &Transform<S>, force: &Force<S>, sum: &mut Force<S>);

    /// Transforms inertial parameters from the child's frame to the parent's frame and adds them to
    /// `sum`.
    fn add_body_back<S: Scalar>(transform: &Transform<S>, body: &[S; BODY], sum: &mut [S; BODY]);

    /// Adds a motion along a joint's axis with the given rate.
    fn add_along<S: Scalar>(joint: &ChainJoint, rate: S, sum: &mut Motion<S>);

    /// Returns the rate of change of a joint's axis in a frame that moves with `v`.
    fn axis_rate<S: Scalar>(v: &Motion<S>, joint: &ChainJoint) -> Motion<S>;

    /// Adds a multiple of a motion to `sum`.
    fn add_times<S: Scalar>(motion: &Motion<S>, factor: S, sum: &mut Motion<S>);

    /// Returns the force on a body that moves with velocity `v` and acceleration `a`:
    /// `I a + v ×* I v`.
    fn force<S: Scalar>(body: &[f64; BODY], v: &Motion<S>, a: &Motion<S>) -> Force<S>;

    /// Returns the momentum of a body that moves along a joint's axis with unit rate.
    fn momentum_along<S: Scalar>(body: &[S; BODY], joint: &ChainJoint) -> Force<S>;

    /// Returns the component of a force along a joint's axis.
    fn along<S: Scalar>(joint: &ChainJoint, force: &Force<S>) -> S;

    /// Returns the rate of change of `m` in a frame that moves with `v`.
    fn cross<S: Scalar>(v: &Motion<S>, m: &Motion<S>) -> Motion<S>;

    /// Writes the entries of [`spatial::kernel`] with indices in [`Self::SHOWN`].
    fn kernel<S: Scalar>(s: &Motion<S>, v: &Motion<S>, row: &mut [S; BODY]);
}

/// Motions in three dimensions.
pub(crate) enum Spatial {}

impl Space for Spatial {
    const SHOWN: &'static [usize] = &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9];

    #[inline]
    fn transform<S: Scalar>(joint: &ChainJoint, q: S) -> Transform<S> {
        joint.transform(q)
    }

    #[inline]
    fn apply<S: Scalar>(transform: &Transform<S>, motion: &Motion<S>) -> Motion<S> {
        transform.apply(motion)
    }

    #[inline]
    fn add_back<S: Scalar>(transform: &Transform<S>, force: &Force<S>, sum: &mut Force<S>) {
        *sum = sum.plus(&transform.back(force));
    }

    #[inline]
    fn add_body_back<S: Scalar>(transform: &Transform<S>, body: &[S; BODY], sum: &mut [S; BODY]) {
        for (sum, part) in sum.iter_mut().zip(transform.back_body(body)) {
            *sum = *sum + part;
        }
    }

    #[inline]
    fn add_along<S: Scalar>(joint: &ChainJoint, rate: S, sum: &mut Motion<S>) {
        let part = match joint.kind {
            JointKind::Revolute => &mut sum.angular,
            JointKind::Prismatic => &mut sum.linear,
        };
        for (sum, axis) in part.iter_mut().zip(joint.axis) {
            *sum = *sum + rate * axis;
        }
    }

    #[inline]
    fn axis_rate<S: Scalar>(v: &Motion<S>, joint: &ChainJoint) -> Motion<S> {
        match joint.kind {
            JointKind::Revolute => Motion {
                angular: cross_fixed(&v.angular, &joint.axis),
                linear: cross_fixed(&v.linear, &joint.axis),
            },
            JointKind::Prismatic => Motion {
                angular: [S::ZERO; 3],
                linear: cross_fixed(&v.angular, &joint.axis),
            },
        }
    }

    #[inline]
    fn add_times<S: Scalar>(motion: &Motion<S>, factor: S, sum: &mut Motion<S>) {
        *sum = sum.plus(&motion.times(factor));
    }

    #[inline]
    fn force<S: Scalar>(body: &[f64; BODY], v: &Motion<S>, a: &Motion<S>) -> Force<S> {
        spatial::momentum(body, a).plus(&v.cross_force(&spatial::momentum(body, v)))
    }

    #[inline]
    fn momentum_along<S: Scalar>(body: &[S; BODY], joint: &ChainJoint) -> Force<S> {
        spatial::momentum(body, &Motion::constant(&joint.motion()))
    }

    #[inline]
    fn along<S: Scalar>(joint: &ChainJoint, force: &Force<S>) -> S {
        let part = match joint.kind {
            JointKind::Revolute => &force.moment,
            JointKind::Prismatic => &force.force,
        };
        let [x, y, z] = joint.axis;
        part[0] * x + part[1] * y + part[2] * z
    }

    #[inline]
    fn cross<S: Scalar>(v: &Motion<S>, m: &Motion<S>) -> Motion<S> {
        v.cross(m)
    }

    #[inline]
    fn kernel<S: Scalar>(s: &Motion<S>, v: &Motion<S>, row: &mut [S; BODY]) {
        *row = spatial::kernel(s, v);
    }
}

/// Motions in the plane perpendicular to the z axes of all frames.
///
/// Only the angular part about z and the linear parts along x and y are read and written.
pub(crate) enum Planar {}

impl Planar {
    #[inline]
    fn motion<S: Scalar>(turn: S, x: S, y: S) -> Motion<S> {
        Motion {
            angular: [S::ZERO, S::ZERO, turn],
            linear: [x, y, S::ZERO],
        }
    }

    #[inline]
    fn force_of<S: Scalar>(moment: S, x: S, y: S) -> Force<S> {
        Force {
            moment: [S::ZERO, S::ZERO, moment],
            force: [x, y, S::ZERO],
        }
    }

    #[inline]
    fn momentum<A: Copy, S: Scalar + Mul<A, Output = S>>(
        body: &[A; BODY],
        v: &Motion<S>,
    ) -> [S; 3] {
        let [m, hx, hy, .., izz] = *body;
        let (w, [x, y, _]) = (v.angular[2], v.linear);
        [w * izz + (y * hx - x * hy), x * m - w * hy, y * m + w * hx]
    }

    /// Returns a vector of the child's frame in the parent's axes.
    #[inline]
    fn out<S: Scalar>(transform: &Transform<S>, x: S, y: S) -> [S; 2] {
        let [along_x, along_y, _] = &transform.axes;
        [
            along_x[0] * x + along_y[0] * y,
            along_x[1] * x + along_y[1] * y,
        ]
    }
}

impl Space for Planar {
    const SHOWN: &'static [usize] = &[0, 1, 2, 9];

    #[inline]
    fn transform<S: Scalar>(joint: &ChainJoint, q: S) -> Transform<S> {
        let [[xx, yx, _], [xy, yy, _], _] = joint.rotation;
        let mut transform = Transform::default();
        let [x, y, _] = joint.origin;
        match joint.kind {
            JointKind::Revolute => {
                let (sin, cos) = (q * joint.axis[2]).sin_cos();
                transform.axes[0] = [cos * xx + sin * yx, cos * xy + sin * yy, S::ZERO];
                transform.axes[1] = [cos * yx - sin * xx, cos * yy - sin * xy, S::ZERO];
                transform.origin = [S::constant(x), S::constant(y), S::ZERO];
            }
            JointKind::Prismatic => {
                let [along_x, along_y, _] = joint.axis;
                transform.axes[0] = [S::constant(xx), S::constant(xy), S::ZERO];
                transform.axes[1] = [S::constant(yx), S::constant(yy), S::ZERO];
                transform.origin = [
                    S::constant(x) + q * (xx * along_x + yx * along_y),
                    S::constant(y) + q * (xy * along_x + yy * along_y),
                    S::ZERO,
                ];
            }
        }
        transform
    }

    #[inline]
    fn apply<S: Scalar>(transform: &Transform<S>, motion: &Motion<S>) -> Motion<S> {
        let ([along_x, along_y, _], [ox, oy, _]) = (&transform.axes, transform.origin);
        let turn = motion.angular[2];
        let x = motion.linear[0] - turn * oy;
        let y = motion.linear[1] + turn * ox;
        Self::motion(
            turn,
            along_x[0] * x + along_x[1] * y,
            along_y[0] * x + along_y[1] * y,
        )
    }

    #[inline]
    fn add_back<S: Scalar>(transform: &Transform<S>, force: &Force<S>, sum: &mut Force<S>) {
        let [x, y] = Self::out(transform, force.force[0], force.force[1]);
        let [ox, oy, _] = transform.origin;
        sum.moment[2] = sum.moment[2] + force.moment[2] + (ox * y - oy * x);
        sum.force[0] = sum.force[0] + x;
        sum.force[1] = sum.force[1] + y;
    }

    #[inline]
    fn add_body_back<S: Scalar>(transform: &Transform<S>, body: &[S; BODY], sum: &mut [S; BODY]) {
        let [mass, hx, hy, .., izz] = *body;
        let [hx, hy] = Self::out(transform, hx, hy);
        let [ox, oy, _] = transform.origin;
        sum[0] = sum[0] + mass;
        sum[1] = sum[1] + (hx + mass * ox);
        sum[2] = sum[2] + (hy + mass * oy);
        sum[9] = sum[9] + (izz + (hx * ox + hy * oy) * 2.0 + mass * (ox * ox + oy * oy));
    }

    #[inline]
    fn add_along<S: Scalar>(joint: &ChainJoint, rate: S, sum: &mut Motion<S>) {
        match joint.kind {
            JointKind::Revolute => sum.angular[2] = sum.angular[2] + rate * joint.axis[2],
            JointKind::Prismatic => {
                sum.linear[0] = sum.linear[0] + rate * joint.axis[0];
                sum.linear[1] = sum.linear[1] + rate * joint.axis[1];
            }
        }
    }

    #[inline]
    fn axis_rate<S: Scalar>(v: &Motion<S>, joint: &ChainJoint) -> Motion<S> {
        let [ax, ay, az] = joint.axis;
        match joint.kind {
            JointKind::Revolute => Self::motion(S::ZERO, v.linear[1] * az, v.linear[0] * -az),
            JointKind::Prismatic => Self::motion(S::ZERO, v.angular[2] * -ay, v.angular[2] * ax),
        }
    }

    #[inline]
    fn add_times<S: Scalar>(motion: &Motion<S>, factor: S, sum: &mut Motion<S>) {
        sum.angular[2] = sum.angular[2] + motion.angular[2] * factor;
        sum.linear[0] = sum.linear[0] + motion.linear[0] * factor;
        sum.linear[1] = sum.linear[1] + motion.linear[1] * factor;
    }

    #[inline]
    fn force<S: Scalar>(body: &[f64; BODY], v: &Motion<S>, a: &Motion<S>) -> Force<S> {
        let [moment, x, y] = Self::momentum(body, a);
        let [_, px, py] = Self::momentum(body, v);
        let w = v.angular[2];
        Self::force_of(
            moment + (v.linear[0] * py - v.linear[1] * px),
            x - w * py,
            y + w * px,
        )
    }

    #[inline]
    fn momentum_along<S: Scalar>(body: &[S; BODY], joint: &ChainJoint) -> Force<S> {
        let [moment, x, y] = Self::momentum(body, &Motion::constant(&joint.motion()));
        Self::force_of(moment, x, y)
    }

    #[inline]
    fn along<S: Scalar>(joint: &ChainJoint, force: &Force<S>) -> S {
        match joint.kind {
            JointKind::Revolute => force.moment[2] * joint.axis[2],
            JointKind::Prismatic => force.force[0] * joint.axis[0] + force.force[1] * joint.axis[1],
        }
    }

    #[inline]
    fn cross<S: Scalar>(v: &Motion<S>, m: &Motion<S>) -> Motion<S> {
        let (w, a) = (v.angular[2], m.angular[2]);
        Self::motion(
            S::ZERO,
            v.linear[1] * a - w * m.linear[1],
            w * m.linear[0] - v.linear[0] * a,
        )
    }

    #[inline]
    fn kernel<S: Scalar>(s: &Motion<S>, v: &Motion<S>, row: &mut [S; BODY]) {
        let (a, [bx, by, _]) = (s.angular[2], s.linear);
        let (w, [ux, uy, _]) = (v.angular[2], v.linear);
        row[0] = bx * ux + by * uy;
        row[1] = uy * a + by * w;
        row[2] = -(ux * a + bx * w);
        row[9] = a * w;
    }
}

/// Returns the cross product with a constant vector.
fn cross_fixed<S: Scalar>(a: &Vector<S>, b: &Vector) -> Vector<S> {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
