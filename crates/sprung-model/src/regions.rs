//! Where the mass of a link can be.

use crate::ellipsoid::Ellipsoid;
use sprung_core::spatial::BODY;

use crate::description::{NoShape, Shape, Tree};

/// Length by which a link may reach beyond the origins of its joints, m: half the length of a joint module of a cobot. A
/// tool may be longer than the link that carries it by as much.
const MARGIN: f64 = 0.15;

/// Length by which mass may lie outside the ellipsoid about the geometry of a link, m: covers, cables and screws
/// outside of the geometry, and corners outside of an ellipsoid about few points.
const BEYOND_GEOMETRY: f64 = 0.03;

/// An ellipsoid that contains the mass of a link, in the frame of its joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// The ellipsoid.
    pub ellipsoid: Ellipsoid,
    /// Whether it is that of the link's geometry.
    pub of_geometry: bool,
}

impl Region {
    /// Returns the regions of all links: the ellipsoid about the geometry of the link, with a margin. Without geometry it
    /// is the ball about the origins of the own joint and of the joints that the link carries, with a larger margin. A link
    /// that carries no joint may carry a tool as long as itself; it has no region without geometry.
    #[must_use]
    pub fn all(tree: &Tree) -> Vec<Option<Self>> {
        let region = |(link, shape): (usize, &Result<Shape, NoShape>)| {
            let carried: Vec<[f64; 3]> = (tree.joints.iter())
                .filter(|joint| joint.parent == Some(link))
                .map(|joint| joint.origin)
                .collect();
            match shape {
                Ok(shape) => {
                    let tool = if carried.is_empty() {
                        shape.reach + MARGIN
                    } else {
                        0.0
                    };
                    Some(Self {
                        ellipsoid: shape.hull.widened(BEYOND_GEOMETRY + tool),
                        of_geometry: true,
                    })
                }
                Err(_) if carried.is_empty() => None,
                Err(_) => Some(Self::about(carried)),
            }
        };
        tree.shapes.iter().enumerate().map(region).collect()
    }

    /// Returns the ball about the origin and the origins of joints.
    fn about(mut points: Vec<[f64; 3]>) -> Self {
        points.push([0.0; 3]);
        let end = |axis: usize, fold: fn(f64, f64) -> f64| {
            points.iter().map(|point| point[axis]).fold(0.0, fold)
        };
        let centre =
            std::array::from_fn(|axis| f64::midpoint(end(axis, f64::min), end(axis, f64::max)));
        let distance = |point: &[f64; 3]| {
            let squares = (0..3).map(|axis| (point[axis] - centre[axis]).powi(2));
            squares.sum::<f64>().sqrt()
        };
        let radius = points.iter().map(distance).fold(0.0, f64::max) + MARGIN;
        Self {
            ellipsoid: Ellipsoid::ball(centre, radius),
            of_geometry: false,
        }
    }

    /// Returns the factors of the ten inertial parameters in `∫ (1 − (x − c)ᵀ Q⁻¹ (x − c)) dm`, which is positive for a
    /// body inside.
    ///
    /// # Source
    ///
    /// Wensing, Kim and Slotine 2018, section III.C.
    #[must_use]
    pub fn factors(&self) -> [f64; BODY] {
        let (c, a) = (self.ellipsoid.centre, self.ellipsoid.inverse());
        let row = |i: usize| (0..3).map(|j| a[i][j] * c[j]).sum::<f64>();
        let trace: f64 = (0..3).map(|i| a[i][i]).sum();
        // The second moments are ½ tr(I) 1 − I.
        let diagonal = |i: usize| a[i][i] - 0.5 * trace;
        [
            1.0 - (0..3).map(|i| c[i] * row(i)).sum::<f64>(),
            2.0 * row(0),
            2.0 * row(1),
            2.0 * row(2),
            diagonal(0),
            2.0 * a[0][1],
            diagonal(1),
            2.0 * a[0][2],
            2.0 * a[1][2],
            diagonal(2),
        ]
    }

    /// Returns whether the mass of a body lies inside.
    ///
    /// - `body`: its ten inertial parameters.
    #[must_use]
    pub fn holds(&self, body: &[f64]) -> bool {
        let factors = self.factors();
        factors.iter().zip(body).map(|(a, b)| a * b).sum::<f64>() > 0.0
    }
}

#[cfg(test)]
mod tests {
    use sprung_core::chain::{ChainJoint, JointKind};

    use super::*;
    use crate::description::Limits;

    fn point_mass([x, y, z]: [f64; 3]) -> [f64; BODY] {
        let [xx, yy, zz] = [x * x, y * y, z * z];
        [
            1.0,
            x,
            y,
            z,
            yy + zz,
            -x * y,
            xx + zz,
            -x * z,
            -y * z,
            xx + yy,
        ]
    }

    fn boxed(least: [f64; 3], largest: [f64; 3]) -> Shape {
        let corners: Vec<[f64; 3]> = (0..8)
            .map(|k| {
                std::array::from_fn(|i| {
                    if k >> i & 1 == 1 {
                        largest[i]
                    } else {
                        least[i]
                    }
                })
            })
            .collect();
        let reach = corners
            .iter()
            .map(|corner| corner.iter().map(|x| x * x).sum::<f64>().sqrt());
        Shape {
            reach: reach.fold(0.0, f64::max),
            hull: Ellipsoid::about(&corners).unwrap(),
        }
    }

    /// Two joints, 0.2 m apart along x.
    fn tree(shapes: &[Result<Shape, NoShape>; 2]) -> Tree {
        let joint = |parent, x| ChainJoint {
            parent,
            rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            origin: [x, 0.0, 0.0],
            axis: [0.0, 0.0, 1.0],
            kind: JointKind::Revolute,
        };
        Tree {
            joints: vec![joint(None, 0.0), joint(Some(0), 0.2)],
            links: ["upper", "fore"].map(str::to_owned).to_vec(),
            inertial: vec![None; 2],
            limits: vec![Limits::default(); 2],
            shapes: shapes.to_vec(),
        }
    }

    #[test]
    fn without_geometry_a_point_mass_is_inside_up_to_the_radius_of_the_ball() {
        let all = Region::all(&tree(&[Err(NoShape::Table), Err(NoShape::Table)]));
        assert_eq!(all[1], None);
        let region = all[0].unwrap();
        assert!(!region.of_geometry);
        // The radius is 0.25 m about x = 0.1 m.
        let inside = |x: f64, y: f64| region.holds(&point_mass([x, y, 0.0]));
        assert!(inside(0.1, 0.249) && !inside(0.1, 0.251));
        assert!(inside(0.349, 0.0) && inside(-0.149, 0.0) && !inside(-0.151, 0.0));
    }

    #[test]
    fn a_point_mass_is_inside_where_it_is_inside_the_ellipsoid() {
        let turned = Ellipsoid {
            centre: [0.1, -0.2, 0.3],
            shape: [[0.05, 0.02, 0.01], [0.02, 0.04, -0.01], [0.01, -0.01, 0.03]],
        };
        let region = Region {
            ellipsoid: turned,
            of_geometry: true,
        };
        // Points of the surface are c + L u with L Lᵀ = Q.
        let mut l = [[0.0_f64; 3]; 3];
        for i in 0..3 {
            for j in 0..=i {
                let rest = turned.shape[i][j] - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
                l[i][j] = if i == j { rest.sqrt() } else { rest / l[j][j] };
            }
        }
        for way in crate::ellipsoid::directions() {
            let at = |share: f64| -> [f64; 3] {
                std::array::from_fn(|i| {
                    turned.centre[i] + share * (0..3).map(|j| l[i][j] * way[j]).sum::<f64>()
                })
            };
            assert!(region.holds(&point_mass(at(0.999))) && !region.holds(&point_mass(at(1.001))));
        }
    }

    #[test]
    fn mass_in_the_geometry_is_inside_and_a_tool_has_room() {
        let shape = boxed([-0.05, -0.05, -0.05], [0.35, 0.05, 0.05]);
        let all = Region::all(&tree(&[Ok(shape), Ok(shape)]));
        let [upper, fore] = [all[0].unwrap(), all[1].unwrap()];
        assert!(upper.of_geometry && fore.of_geometry);
        // On the corners of the box, and up to the margin beyond the ellipsoid about them, 0.2·√3 m from its centre.
        for corner in [[0.35, 0.05, 0.05], [-0.05, 0.05, -0.05]] {
            assert!(upper.holds(&point_mass(corner)));
        }
        let end = 0.15 + 0.2 * 3_f64.sqrt();
        assert!(upper.holds(&point_mass([end + 0.029, 0.0, 0.0])));
        assert!(!upper.holds(&point_mass([end + 0.06, 0.0, 0.0])));
        assert!(!upper.holds(&point_mass([0.15, 0.0, 0.2])));
        // A tool as long as the link.
        assert!(fore.holds(&point_mass([0.7, 0.0, 0.0])));
        assert!(!fore.holds(&point_mass([1.2, 0.0, 0.0])));
    }
}
