//! Motions and forces of rigid bodies, and the kernel of all link columns.
//!
//! A motion is a pair of an angular and a linear vector, in a joint's frame and about its origin. A
//! force is the dual pair of a moment and a force vector. Both are written over [`Scalar`], so they
//! can contain Taylor series and dual numbers.

use core::ops::Mul;

use crate::scalar::Scalar;

/// A vector in three dimensions.
pub type Vector<S = f64> = [S; 3];

/// Number of inertial parameters of a body.
pub const BODY: usize = 10;

/// Names of the inertial parameters of a body: mass, first moments, and inertia about the origin of
/// the joint's frame, in the axes of this frame.
pub const BODY_NAMES: [&str; BODY] = [
    "m", "mx", "my", "mz", "ixx", "ixy", "iyy", "ixz", "iyz", "izz",
];

/// Units of the inertial parameters of a body.
pub const BODY_UNITS: [&str; BODY] = [
    "kg", "kg·m", "kg·m", "kg·m", "kg·m²", "kg·m²", "kg·m²", "kg·m²", "kg·m²", "kg·m²",
];

/// A velocity or an acceleration of a rigid body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion<S = f64> {
    /// Angular part, rad/s or rad/s².
    pub angular: Vector<S>,
    /// Linear part at the origin, m/s or m/s².
    pub linear: Vector<S>,
}

/// A force on a rigid body, or a momentum. The product of a force and a velocity is a power.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Force<S = f64> {
    /// Moment about the origin, N·m, or angular momentum, N·m·s.
    pub moment: Vector<S>,
    /// Force, N, or linear momentum, N·s.
    pub force: Vector<S>,
}

impl<S: Scalar> Default for Motion<S> {
    fn default() -> Self {
        Self {
            angular: [S::ZERO; 3],
            linear: [S::ZERO; 3],
        }
    }
}

impl<S: Scalar> Default for Force<S> {
    fn default() -> Self {
        Self {
            moment: [S::ZERO; 3],
            force: [S::ZERO; 3],
        }
    }
}

impl<S: Scalar> Motion<S> {
    /// Returns a motion whose derivatives are zero.
    #[must_use]
    pub fn constant(motion: &Motion) -> Self {
        Self {
            angular: motion.angular.map(S::constant),
            linear: motion.linear.map(S::constant),
        }
    }

    /// Returns the motion times a number.
    #[must_use]
    pub fn times(&self, factor: S) -> Self {
        Self {
            angular: self.angular.map(|x| x * factor),
            linear: self.linear.map(|x| x * factor),
        }
    }

    /// Returns the sum of two motions.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            angular: add(&self.angular, &other.angular),
            linear: add(&self.linear, &other.linear),
        }
    }

    /// Returns the rate of change of `other` in a frame that moves with `self`.
    ///
    /// # Source
    ///
    /// Featherstone, Rigid Body Dynamics Algorithms, Eq. (2.31): `v × m`.
    #[must_use]
    pub fn cross(&self, other: &Self) -> Self {
        Self {
            angular: cross(&self.angular, &other.angular),
            linear: add(
                &cross(&self.angular, &other.linear),
                &cross(&self.linear, &other.angular),
            ),
        }
    }

    /// Returns the rate of change of a force in a frame that moves with `self`.
    ///
    /// # Source
    ///
    /// Featherstone, Eq. (2.32): `v ×* f`.
    #[must_use]
    pub fn cross_force(&self, other: &Force<S>) -> Force<S> {
        Force {
            moment: add(
                &cross(&self.angular, &other.moment),
                &cross(&self.linear, &other.force),
            ),
            force: cross(&self.angular, &other.force),
        }
    }

    /// Returns the power of a force at this velocity.
    #[must_use]
    pub fn power(&self, force: &Force<S>) -> S {
        dot(&self.angular, &force.moment) + dot(&self.linear, &force.force)
    }
}

impl<S: Scalar> Force<S> {
    /// Returns the sum of two forces.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            moment: add(&self.moment, &other.moment),
            force: add(&self.force, &other.force),
        }
    }
}

/// Transform from a parent's frame to a child's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform<S = f64> {
    /// Axes of the child's frame in the parent's frame, one per row.
    pub axes: [Vector<S>; 3],
    /// Origin of the child's frame in the parent's frame, m.
    pub origin: Vector<S>,
}

impl<S: Scalar> Default for Transform<S> {
    fn default() -> Self {
        Self {
            axes: [[S::ZERO; 3]; 3],
            origin: [S::ZERO; 3],
        }
    }
}

impl<S: Scalar> Transform<S> {
    /// Transforms a motion from the parent's frame to the child's frame.
    #[must_use]
    pub fn apply(&self, motion: &Motion<S>) -> Motion<S> {
        let at_origin = add(&motion.linear, &cross(&motion.angular, &self.origin));
        Motion {
            angular: times(&self.axes, &motion.angular),
            linear: times(&self.axes, &at_origin),
        }
    }

    /// Transforms a force from the child's frame to the parent's frame.
    #[must_use]
    pub fn back(&self, force: &Force<S>) -> Force<S> {
        let turned = self.out(&force.force);
        Force {
            moment: add(&self.out(&force.moment), &cross(&self.origin, &turned)),
            force: turned,
        }
    }

    /// Returns a vector of the child's frame in the parent's axes.
    fn out(&self, v: &Vector<S>) -> Vector<S> {
        let [x, y, z] = &self.axes;
        core::array::from_fn(|i| x[i] * v[0] + y[i] * v[1] + z[i] * v[2])
    }
}

impl<S: Scalar> Transform<S> {
    /// Transforms the inertial parameters of a body from the child's frame to the parent's frame.
    ///
    /// # Source
    ///
    /// The parallel axis theorem.
    #[must_use]
    pub fn back_body(&self, body: &[S; BODY]) -> [S; BODY] {
        let mass = body[0];
        let first = self.out(&[body[1], body[2], body[3]]);
        // R^T I R, column by column of I R.
        let inertia = [
            [body[4], body[5], body[7]],
            [body[5], body[6], body[8]],
            [body[7], body[8], body[9]],
        ];
        let half = product(&inertia, &self.axes);
        let turned = product(&transposed(&self.axes), &half);
        let p = &self.origin;
        // About the parent's origin: -[p][h] - [h][p] - m [p][p].
        let moved = |i: usize, j: usize| {
            let both = first[i] * p[j] + p[i] * first[j] + mass * p[i] * p[j];
            if i == j {
                let trace = dot(&first, p) * 2.0 + mass * dot(p, p);
                turned[i][j] + trace - both
            } else {
                turned[i][j] - both
            }
        };
        [
            mass,
            first[0] + mass * p[0],
            first[1] + mass * p[1],
            first[2] + mass * p[2],
            moved(0, 0),
            moved(0, 1),
            moved(1, 1),
            moved(0, 2),
            moved(1, 2),
            moved(2, 2),
        ]
    }
}

/// Returns `I v`: the momentum of a body with velocity `v`, or the force on a body at rest with
/// acceleration `v`.
///
/// - `body`: inertial parameters, \[10\].
#[must_use]
pub(crate) fn momentum<A: Copy, S: Scalar + Mul<A, Output = S>>(
    body: &[A; BODY],
    v: &Motion<S>,
) -> Force<S> {
    let [m, hx, hy, hz, ixx, ixy, iyy, ixz, iyz, izz] = *body;
    let (w, u) = (&v.angular, &v.linear);
    Force {
        moment: [
            w[0] * ixx + w[1] * ixy + w[2] * ixz + (u[2] * hy - u[1] * hz),
            w[0] * ixy + w[1] * iyy + w[2] * iyz + (u[0] * hz - u[2] * hx),
            w[0] * ixz + w[1] * iyz + w[2] * izz + (u[1] * hx - u[0] * hy),
        ],
        force: [
            u[0] * m + (w[1] * hz - w[2] * hy),
            u[1] * m + (w[2] * hx - w[0] * hz),
            u[2] * m + (w[0] * hy - w[1] * hx),
        ],
    }
}

/// Returns the row whose product with the inertial parameters of a body is `s^T I v`. It is
/// symmetric and bilinear in `s` and `v`.
///
/// Every column of a link row (momentum, kinetic energy, gravity or torque) is this kernel at a
/// pair of motions. The product `s · I v` is linear in mass, first moments and inertia, because
/// `a · (h × u) = h · (u × a)` and `-b · (h × w) = h · (b × w)`.
#[must_use]
pub(crate) fn kernel<S: Scalar>(s: &Motion<S>, v: &Motion<S>) -> [S; BODY] {
    let (a, b) = (&s.angular, &s.linear);
    let (w, u) = (&v.angular, &v.linear);
    let first = add(&cross(u, a), &cross(b, w));
    [
        dot(b, u),
        first[0],
        first[1],
        first[2],
        a[0] * w[0],
        a[0] * w[1] + a[1] * w[0],
        a[1] * w[1],
        a[0] * w[2] + a[2] * w[0],
        a[1] * w[2] + a[2] * w[1],
        a[2] * w[2],
    ]
}

/// Returns the rotation matrix of a rotation by `angle`, rad, about a unit axis.
///
/// # Source
///
/// Rodrigues' formula.
#[must_use]
pub fn rotation<S: Scalar>(axis: &Vector, angle: S) -> [Vector<S>; 3] {
    let (sin, cos) = angle.sin_cos();
    let [x, y, z] = *axis;
    let c = S::constant(1.0) - cos;
    [
        [
            cos + c * (x * x),
            c * (x * y) - sin * z,
            c * (x * z) + sin * y,
        ],
        [
            c * (x * y) + sin * z,
            cos + c * (y * y),
            c * (y * z) - sin * x,
        ],
        [
            c * (x * z) - sin * y,
            c * (y * z) + sin * x,
            cos + c * (z * z),
        ],
    ]
}

/// Returns the product of two 3 × 3 matrices.
#[must_use]
pub fn product<A: Copy, S: Scalar + Mul<A, Output = S>>(
    a: &[Vector<A>; 3],
    b: &[Vector<S>; 3],
) -> [Vector<S>; 3] {
    a.map(|row| core::array::from_fn(|j| b[0][j] * row[0] + b[1][j] * row[1] + b[2][j] * row[2]))
}

/// Returns the transpose of a 3 × 3 matrix.
#[must_use]
pub fn transposed<S: Scalar>(a: &[Vector<S>; 3]) -> [Vector<S>; 3] {
    core::array::from_fn(|i| core::array::from_fn(|j| a[j][i]))
}

/// Returns the product of a 3 × 3 matrix and a vector.
#[must_use]
pub fn times<S: Scalar>(matrix: &[Vector<S>; 3], v: &Vector<S>) -> Vector<S> {
    matrix.map(|row| dot(&row, v))
}

/// Returns the scalar product.
#[must_use]
pub fn dot<S: Scalar>(a: &Vector<S>, b: &Vector<S>) -> S {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Returns the sum of two vectors.
#[must_use]
pub fn add<S: Scalar>(a: &Vector<S>, b: &Vector<S>) -> Vector<S> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Returns the difference `a − b`.
#[must_use]
pub fn difference<S: Scalar>(a: &Vector<S>, b: &Vector<S>) -> Vector<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Returns the vector product `a × b`.
#[must_use]
pub fn cross<S: Scalar>(a: &Vector<S>, b: &Vector<S>) -> Vector<S> {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: Motion = Motion {
        angular: [0.3, -0.7, 0.2],
        linear: [1.1, 0.4, -0.9],
    };
    const V: Motion = Motion {
        angular: [-0.5, 0.1, 0.8],
        linear: [0.6, -1.3, 0.7],
    };

    #[test]
    fn kernel_is_symmetric_and_gives_twice_the_kinetic_energy() {
        let swapped = kernel(&V, &S);
        assert!(
            kernel(&S, &V)
                .iter()
                .zip(swapped)
                .all(|(a, b)| (a - b).abs() < 1e-15)
        );
        // Four point masses: their energy is a sum over points.
        let points = [
            (0.7, [0.1, 0.2, -0.3]),
            (1.3, [-0.4, 0.5, 0.2]),
            (0.2, [0.9, -0.1, 0.4]),
            (0.5, [0.0, 0.3, 0.6]),
        ];
        let mut pi = [0.0; BODY];
        let mut energy = 0.0;
        for (m, [x, y, z]) in points {
            let terms = [
                1.0,
                x,
                y,
                z,
                y * y + z * z,
                -x * y,
                x * x + z * z,
                -x * z,
                -y * z,
                x * x + y * y,
            ];
            for (sum, term) in pi.iter_mut().zip(terms) {
                *sum += m * term;
            }
            let velocity = add(&V.linear, &cross(&V.angular, &[x, y, z]));
            energy += m * dot(&velocity, &velocity);
        }
        let found: f64 = kernel(&V, &V).iter().zip(pi).map(|(e, p)| e * p).sum();
        assert!((found - energy).abs() < 1e-14);
    }

    #[test]
    fn transforms_keep_power_energy_and_the_cross_product() {
        let frame = Transform {
            axes: transposed(&rotation(&[0.6, 0.0, 0.8], 0.7)),
            origin: [0.2, -0.5, 0.1],
        };
        let body = [1.3, 0.2, -0.1, 0.4, 0.9, 0.05, 0.8, -0.07, 0.02, 0.6];
        // Power and kinetic energy do not depend on the frame.
        let force = momentum(&body, &frame.apply(&V));
        let power = frame.apply(&S).power(&force);
        assert!((S.power(&frame.back(&force)) - power).abs() < 1e-14);
        let moved = momentum(&frame.back_body(&body), &V);
        assert!((S.power(&moved) - power).abs() < 1e-14);
        let columns = kernel(&frame.apply(&S), &frame.apply(&V));
        let product: f64 = columns.iter().zip(body).map(|(e, p)| e * p).sum();
        assert!((product - power).abs() < 1e-14);

        let outside = frame.apply(&S.cross(&V));
        let inside = frame.apply(&S).cross(&frame.apply(&V));
        for (a, b) in [
            (outside.angular, inside.angular),
            (outside.linear, inside.linear),
        ] {
            assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-14));
        }
    }
}
