//! A body by its mass, its centre of mass and its inertia.

use sprung_core::spatial::BODY;

/// A body by its mass, its centre of mass and its inertia about it, in the frame of its joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass, m.
    pub centre_of_mass: [f64; 3],
    /// Moments of inertia about the centre of mass, kg·m², \[3 × 3\].
    pub inertia: [[f64; 3]; 3],
}

impl Body {
    /// - `parameters`: the ten inertial parameters about the origin of the frame, with a positive mass.
    pub(super) fn of(parameters: &[f64; BODY]) -> Self {
        let [mass, mx, my, mz, xx, xy, yy, xz, yz, zz] = *parameters;
        let c = [mx / mass, my / mass, mz / mass];
        let squares: f64 = c.iter().map(|entry| entry * entry).sum();
        let about_origin = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        let entry = |i: usize, j: usize| {
            let of_all = if i == j { squares } else { 0.0 };
            about_origin[i][j] - mass * (of_all - c[i] * c[j])
        };
        Self {
            mass,
            centre_of_mass: c,
            inertia: std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))),
        }
    }
}
