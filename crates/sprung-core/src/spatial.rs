//! Motions of rigid bodies and the kernel that every link column is made of.
//!
//! A motion is a pair of an angular and a linear vector, in a joint's frame and
//! about its origin.

/// A vector in three dimensions.
pub type Vector = [f64; 3];

/// Number of inertial parameters of a body.
pub const BODY: usize = 10;

/// Names of the inertial parameters of a body: mass, first moments and inertia
/// about the origin of the joint's frame, in its axes.
pub const BODY_NAMES: [&str; BODY] = [
    "m", "mx", "my", "mz", "ixx", "ixy", "iyy", "ixz", "iyz", "izz",
];

/// A velocity or an acceleration of a rigid body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Angular part, rad/s or rad/s².
    pub angular: Vector,
    /// Linear part at the origin, m/s or m/s².
    pub linear: Vector,
}

impl Motion {
    /// Returns the motion times a number.
    #[must_use]
    pub fn times(&self, factor: f64) -> Self {
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
}

/// From a parent's frame to a child's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Transform {
    /// Rows: the child's axes in the parent's frame.
    pub axes: [Vector; 3],
    /// The child's origin in the parent's frame, m.
    pub origin: Vector,
}

impl Transform {
    /// Returns a motion of the parent's frame as the child's sees it.
    #[must_use]
    pub fn apply(&self, motion: &Motion) -> Motion {
        let at_origin = add(&motion.linear, &cross(&motion.angular, &self.origin));
        Motion {
            angular: self.axes.map(|axis| dot(&axis, &motion.angular)),
            linear: self.axes.map(|axis| dot(&axis, &at_origin)),
        }
    }
}

/// Returns the row that gives `s^T I v` for a body with inertia `I`, times its
/// inertial parameters; symmetric and bilinear in `s` and `v`.
///
/// Every column of a link row, whether of momentum, of kinetic energy, of
/// gravity or of torque, is this kernel at some pair of motions: since
/// `a · (h × u) = h · (u × a)` and `-b · (h × w) = h · (b × w)`, the product
/// `s · I v` is linear in mass, first moments and inertia.
#[must_use]
pub fn kernel(s: &Motion, v: &Motion) -> [f64; BODY] {
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

/// Returns the rotation matrix of a turn about a unit axis, rad.
///
/// # Source
///
/// Rodrigues' formula.
#[must_use]
pub fn rotation(axis: &Vector, angle: f64) -> [Vector; 3] {
    let (sin, cos) = libm::sincos(angle);
    let [x, y, z] = *axis;
    let c = 1.0 - cos;
    [
        [cos + c * x * x, c * x * y - sin * z, c * x * z + sin * y],
        [c * x * y + sin * z, cos + c * y * y, c * y * z - sin * x],
        [c * x * z - sin * y, c * y * z + sin * x, cos + c * z * z],
    ]
}

/// Returns the product of two matrices.
#[must_use]
pub fn product(a: &[Vector; 3], b: &[Vector; 3]) -> [Vector; 3] {
    a.map(|row| core::array::from_fn(|j| (0..3).map(|k| row[k] * b[k][j]).sum()))
}

/// Returns the transpose.
#[must_use]
pub fn transposed(a: &[Vector; 3]) -> [Vector; 3] {
    core::array::from_fn(|i| core::array::from_fn(|j| a[j][i]))
}

pub(crate) fn dot(a: &Vector, b: &Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn add(a: &Vector, b: &Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn cross(a: &Vector, b: &Vector) -> Vector {
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
    fn transforms_keep_the_cross_product() {
        let frame = Transform {
            axes: transposed(&rotation(&[0.6, 0.0, 0.8], 0.7)),
            origin: [0.2, -0.5, 0.1],
        };
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
