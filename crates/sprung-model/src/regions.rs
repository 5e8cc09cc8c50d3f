//! Where the mass of a link can be.

use crate::description::Tree;

/// Length by which a link may reach beyond the origins of its joints, m: half the length of a joint module of a cobot.
const MARGIN: f64 = 0.15;

/// A ball that contains the mass of a link, in the frame of its joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Centre, m.
    pub centre: [f64; 3],
    /// Radius, m.
    pub radius: f64,
}

impl Region {
    /// Returns the regions of all links: the ball about the origins of the own joint and of the joints that the link
    /// carries, with a margin; `None` for a link that carries no joint, because it may carry a tool.
    #[must_use]
    pub fn all(tree: &Tree) -> Vec<Option<Self>> {
        (0..tree.joints.len())
            .map(|link| {
                let carried = (tree.joints.iter()).filter(|joint| joint.parent == Some(link));
                let origins: Vec<[f64; 3]> = std::iter::once([0.0; 3])
                    .chain(carried.map(|joint| joint.origin))
                    .collect();
                (origins.len() > 1).then(|| Self::about(&origins))
            })
            .collect()
    }

    fn about(points: &[[f64; 3]]) -> Self {
        let ends = |axis: usize| {
            let of = points.iter().map(|point| point[axis]);
            of.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, largest], x| {
                [least.min(x), largest.max(x)]
            })
        };
        let centre = std::array::from_fn(|axis| {
            let [least, largest] = ends(axis);
            f64::midpoint(least, largest)
        });
        let distance = |point: &[f64; 3]| {
            let squares = (0..3).map(|axis| (point[axis] - centre[axis]).powi(2));
            squares.sum::<f64>().sqrt()
        };
        Self {
            centre,
            radius: points.iter().map(distance).fold(0.0, f64::max) + MARGIN,
        }
    }

    /// Returns the factors of the ten inertial parameters in `∫ (r² − |x − c|²) dm`, which is positive for a body
    /// inside.
    ///
    /// # Source
    ///
    /// Wensing, Kim and Slotine 2018, section III.C, with a ball as the ellipsoid.
    #[must_use]
    pub fn factors(&self) -> [f64; 10] {
        let c = self.centre;
        let squares: f64 = c.iter().map(|x| x * x).sum();
        let mut factors = [0.0; 10];
        factors[0] = self.radius.powi(2) - squares;
        for (axis, x) in c.iter().enumerate() {
            factors[1 + axis] = 2.0 * x;
        }
        // The trace of the second moments is half the trace of the inertia.
        for diagonal in [4, 6, 9] {
            factors[diagonal] = -0.5;
        }
        factors
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_mass_is_inside_up_to_the_radius() {
        let region = Region::about(&[[0.0; 3], [0.2, 0.0, 0.0]]);
        assert!((region.centre[0] - 0.1).abs() < 1e-12);
        assert!((region.radius - 0.25).abs() < 1e-12);
        let inside = |x: f64, y: f64| {
            let squares = [y * y, -x * y, x * x, 0.0, 0.0, x * x + y * y];
            let body = [1.0, x, y, 0.0].into_iter().chain(squares);
            let factors = region.factors();
            factors.iter().zip(body).map(|(a, b)| a * b).sum::<f64>()
        };
        assert!((inside(0.1, 0.0) - 0.0625).abs() < 1e-12);
        assert!(inside(0.1, 0.249) > 0.0 && inside(0.1, 0.251) < 0.0);
        assert!(inside(0.349, 0.0) > 0.0 && inside(-0.151, 0.0) < 0.0);
    }
}
