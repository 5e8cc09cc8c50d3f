//! Frames and rigid bodies, and how they are merged.

use sprung_core::spatial::{Vector, dot, product};

/// A frame relative to another frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    /// Rotation matrix, by rows; its columns are the axes.
    pub(super) rotation: [Vector; 3],
    /// Its origin, m.
    pub(super) origin: Vector,
}

impl Placement {
    pub(super) const IDENTITY: Self = Self {
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        origin: [0.0; 3],
    };

    /// Returns the frame at `xyz`, m, rotated by roll, pitch and yaw, rad, about the fixed axes x, y
    /// and z in this order.
    pub(super) fn new(xyz: Vector, [roll, pitch, yaw]: Vector) -> Self {
        let (sr, cr) = roll.sin_cos();
        let (sp, cp) = pitch.sin_cos();
        let (sy, cy) = yaw.sin_cos();
        Self {
            rotation: [
                [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                [-sp, cp * sr, cp * cr],
            ],
            origin: xyz,
        }
    }

    /// Returns the frame with placement `inner` in this frame.
    pub(super) fn then(&self, inner: &Self) -> Self {
        Self {
            rotation: product(&self.rotation, &inner.rotation),
            origin: self.point(&inner.origin),
        }
    }

    /// Returns a point of this frame in the frame that carries it.
    pub(super) fn point(&self, p: &Vector) -> Vector {
        std::array::from_fn(|i| self.origin[i] + dot(&self.rotation[i], p))
    }
}

/// A rigid body in the frame of its link.
#[derive(Clone, Copy, Debug)]
pub(super) struct Body {
    /// Mass, kg.
    pub(super) mass: f64,
    /// Frame of its inertia, at the centre of mass.
    pub(super) placement: Placement,
    /// Inertia about the centre of mass, in that frame's axes, kg·m².
    pub(super) inertia: [Vector; 3],
}

impl Body {
    /// Returns whether a distribution of mass has this inertia: its second moments are positive semidefinite.
    ///
    /// - `rounded`: part of the sum of the moments that may be rounded.
    pub(super) fn is_possible(&self, rounded: f64) -> bool {
        let inertia = &self.inertia;
        let half = 0.5 * (0..3).map(|i| inertia[i][i]).sum::<f64>();
        let slack = 2.0 * rounded * half.abs();
        let second = |i: usize, j: usize| {
            if i == j {
                half - inertia[i][j] + slack
            } else {
                -inertia[i][j]
            }
        };
        let minor = |i: usize, j: usize| second(i, i) * second(j, j) - second(i, j).powi(2);
        let determinant = second(0, 0) * minor(1, 2)
            - second(0, 1) * (second(0, 1) * second(2, 2) - second(1, 2) * second(0, 2))
            + second(0, 2) * (second(0, 1) * second(1, 2) - second(1, 1) * second(0, 2));
        (0..3).all(|i| second(i, i) >= 0.0)
            && [(0, 1), (0, 2), (1, 2)]
                .iter()
                .all(|&(i, j)| minor(i, j) >= 0.0)
            && determinant >= 0.0
    }

    /// Returns the ten inertial parameters about the origin of the frame that carries the body.
    ///
    /// - `link`: placement of the body's link in this frame.
    pub(super) fn parameters(&self, link: &Placement) -> [f64; 10] {
        let frame = link.then(&self.placement);
        let turned = product(&frame.rotation, &self.inertia);
        let (m, c) = (self.mass, frame.origin);
        let squared = dot(&c, &c);
        // The parallel axis theorem: R I Rᵀ + m (cᵀc 1 − c cᵀ).
        let inertia = |i: usize, j: usize| {
            let diagonal = if i == j { squared } else { 0.0 };
            dot(&turned[i], &frame.rotation[j]) + m * (diagonal - c[i] * c[j])
        };
        [
            m,
            m * c[0],
            m * c[1],
            m * c[2],
            inertia(0, 0),
            inertia(0, 1),
            inertia(1, 1),
            inertia(0, 2),
            inertia(1, 2),
            inertia(2, 2),
        ]
    }
}
