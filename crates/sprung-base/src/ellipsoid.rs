//! Ellipsoids about points.
//!
//! # Source
//!
//! Khachiyan, "Rounding of polytopes in the real number model of computation", Mathematics of Operations Research, 1996;
//! Todd and Yıldırım, "On Khachiyan's algorithm for the computation of minimum-volume enclosing ellipsoids", Discrete
//! Applied Mathematics, 2007, for the steps that take weight from a point.

type Vector = [f64; 3];
type Matrix = [Vector; 3];

/// Lines along which the outermost points are kept: neighbours are 14° apart.
const LINES: usize = 100;

/// Difference of the squared distances of the outermost points at which the search ends: the ellipsoid is then 0.1 %
/// too long at most.
const TOLERANCE: f64 = 1e-3;

/// Largest number of steps of the search, 0.5 ms. Fewer suffice for most bodies; then the result is hardly longer.
const MAX_STEPS: usize = 1000;

/// Least thickness over length; the inverse of the shape of a thinner ellipsoid would have few correct digits.
const THINNEST: f64 = 1e-3;

/// Least thickness, m: for a single point.
const MIN_THICKNESS_M: f64 = 1e-6;

/// The points x with `(x − c)ᵀ Q⁻¹ (x − c) ≤ 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    /// Centre c, m.
    pub centre: Vector,
    /// Shape Q, m²: symmetric; the roots of its eigenvalues are the half axes.
    pub shape: Matrix,
}

impl Ellipsoid {
    /// Returns a ball.
    #[must_use]
    pub fn ball(centre: Vector, radius: f64) -> Self {
        Self {
            centre,
            shape: diagonal(radius * radius),
        }
    }

    /// Returns the smallest ellipsoid that contains points, to 0.1 % of its length; a thin one for points in a plane or
    /// on a line. `None` without points.
    #[must_use]
    pub fn about(points: &[Vector]) -> Option<Self> {
        let first = points.first()?;
        let [least, largest] = points.iter().fold([*first; 2], |[least, largest], point| {
            [
                std::array::from_fn(|i| least[i].min(point[i])),
                std::array::from_fn(|i| largest[i].max(point[i])),
            ]
        });
        let middle: Vector = std::array::from_fn(|i| f64::midpoint(least[i], largest[i]));
        let length = (0..3).map(|i| largest[i] - least[i]).fold(0.0, f64::max);
        let thinnest = (THINNEST * length).max(MIN_THICKNESS_M);
        let mut from_middle: Vec<Vector> = (points.iter())
            .map(|point| std::array::from_fn(|i| point[i] - middle[i]))
            .collect();
        for axis in 0..3 {
            for side in [-thinnest, thinnest] {
                let mut point = [0.0; 3];
                point[axis] = side;
                from_middle.push(point);
            }
        }
        let ellipsoid = smallest(&from_middle);
        Some(Self {
            centre: std::array::from_fn(|i| middle[i] + ellipsoid.centre[i]),
            shape: ellipsoid.shape,
        })
    }

    /// Returns an ellipsoid that contains all points within a distance of this one.
    ///
    /// # Source
    ///
    /// Kurzhanski and Vályi, "Ellipsoidal calculus for estimation and control", 1997: the external ellipsoid of a sum
    /// with the least trace.
    #[must_use]
    pub fn widened(&self, by: f64) -> Self {
        let trace: f64 = (0..3).map(|i| self.shape[i][i]).sum();
        let ratio = (trace / 3.0).sqrt() / by;
        let wider = diagonal((1.0 + ratio) * by * by);
        let entry = |i: usize, j: usize| (1.0 + ratio.recip()) * self.shape[i][j] + wider[i][j];
        Self {
            shape: std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))),
            ..*self
        }
    }

    /// Returns the root mean square of the half axes, m.
    #[must_use]
    pub fn radius(&self) -> f64 {
        ((0..3).map(|i| self.shape[i][i]).sum::<f64>() / 3.0).sqrt()
    }

    /// Returns the inverse of the shape, 1/m².
    #[must_use]
    pub fn inverse(&self) -> Matrix {
        inverse(&self.shape)
    }
}

/// Returns the outermost points in directions all around, at most 200: an ellipsoid about them nearly contains the
/// others.
#[must_use]
pub fn outermost(points: &[Vector]) -> Vec<Vector> {
    let mut kept = Vec::new();
    for line in lines() {
        let (mut least, mut largest) = ((f64::INFINITY, 0), (f64::NEG_INFINITY, 0));
        for (at, point) in points.iter().enumerate() {
            let along = dot(&line, point);
            if along < least.0 {
                least = (along, at);
            }
            if along > largest.0 {
                largest = (along, at);
            }
        }
        kept.extend([least.1, largest.1]);
    }
    kept.sort_unstable();
    kept.dedup();
    (kept.iter())
        .filter_map(|at| points.get(*at))
        .copied()
        .collect()
}

/// Returns unit vectors all around: the axes, and a spiral.
pub fn directions() -> impl Iterator<Item = Vector> {
    lines().flat_map(|line| [line, line.map(|x| -x)])
}

fn lines() -> impl Iterator<Item = Vector> {
    let turn = std::f64::consts::PI * (3.0 - 5_f64.sqrt());
    let spiral = (0..LINES - 3).map(move |k| {
        let z = (k as f64 + 0.5) / (LINES - 3) as f64;
        let (sin, cos) = (turn * k as f64).sin_cos();
        let across = (1.0 - z * z).sqrt();
        [across * cos, across * sin, z]
    });
    diagonal(1.0).into_iter().chain(spiral)
}

/// Returns the smallest ellipsoid of points that fill the space.
fn smallest(points: &[Vector]) -> Ellipsoid {
    let mut weights = vec![(points.len() as f64).recip(); points.len()];
    let mut found = moments(points, &weights);
    for _ in 0..MAX_STEPS {
        let inverse = inverse(&found.shape);
        let squares = points
            .iter()
            .map(|point| square(&inverse, &found.centre, point));
        let (mut inner, mut outer) = ((f64::INFINITY, 0), (0.0, 0));
        for (at, square) in squares.enumerate() {
            if square > outer.0 {
                outer = (square, at);
            }
            if square < inner.0 && weights[at] > 0.0 {
                inner = (square, at);
            }
        }
        if (outer.0 - 3.0).max(3.0 - inner.0) <= 3.0 * TOLERANCE {
            break;
        }
        let step = |square: f64| (square - 3.0) / (4.0 * square);
        let (by, at) = if outer.0 - 3.0 > 3.0 - inner.0 {
            (step(outer.0), outer.1)
        } else {
            let all = -weights[inner.1] / (1.0 - weights[inner.1]);
            let by = if inner.0 > 0.0 { step(inner.0) } else { all };
            (by.max(all), inner.1)
        };
        for weight in &mut weights {
            *weight *= 1.0 - by;
        }
        weights[at] = (weights[at] + by).max(0.0);
        found = moments(points, &weights);
    }
    let inverse = inverse(&found.shape);
    let largest = (points.iter())
        .map(|point| square(&inverse, &found.centre, point))
        .fold(0.0, f64::max);
    Ellipsoid {
        shape: found.shape.map(|row| row.map(|entry| largest * entry)),
        ..found
    }
}

/// Returns mean and covariance of weighted points.
fn moments(points: &[Vector], weights: &[f64]) -> Ellipsoid {
    let weighted = || points.iter().zip(weights).filter(|(_, w)| **w > 0.0);
    let centre = std::array::from_fn(|i| weighted().map(|(point, w)| w * point[i]).sum());
    let mut shape = [[0.0; 3]; 3];
    for (point, w) in weighted() {
        let from: Vector = difference(point, &centre);
        for (row, x) in shape.iter_mut().zip(from) {
            for (entry, y) in row.iter_mut().zip(from) {
                *entry += w * x * y;
            }
        }
    }
    Ellipsoid { centre, shape }
}

fn square(inverse: &Matrix, centre: &Vector, point: &Vector) -> f64 {
    let from = difference(point, centre);
    (0..3).map(|i| from[i] * dot(&inverse[i], &from)).sum()
}

fn inverse(m: &Matrix) -> Matrix {
    let cross = |a: &Vector, b: &Vector| -> Vector {
        std::array::from_fn(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            a[j] * b[k] - a[k] * b[j]
        })
    };
    let adjugate = [
        cross(&m[1], &m[2]),
        cross(&m[2], &m[0]),
        cross(&m[0], &m[1]),
    ];
    let determinant = dot(&m[0], &adjugate[0]);
    adjugate.map(|row| row.map(|entry| entry / determinant))
}

fn diagonal(entry: f64) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { entry } else { 0.0 }))
}

fn difference(a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|i| a[i] - b[i])
}

fn dot(a: &Vector, b: &Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn half_axes(of: &Ellipsoid) -> Vector {
        for (i, row) in of.shape.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                assert!(i == j || entry.abs() < 1e-3 * of.shape[i][i], "{of:?}");
            }
        }
        std::array::from_fn(|i| of.shape[i][i].sqrt())
    }

    fn assert_near(found: Vector, expected: Vector) {
        let near = |(a, b): (f64, f64)| (a - b).abs() < 2e-3 * b;
        assert!(found.into_iter().zip(expected).all(near), "{found:?}");
    }

    fn contains(of: &Ellipsoid, point: &Vector) -> bool {
        square(&of.inverse(), &of.centre, point) <= 1.0 + 1e-9
    }

    #[test]
    fn a_box_has_half_axes_of_root_three_half_sides() {
        let corners: Vec<Vector> = (0..8)
            .map(|k| {
                std::array::from_fn(|i| {
                    if k >> i & 1 == 1 {
                        [0.3, 0.7, 1.1][i]
                    } else {
                        0.1
                    }
                })
            })
            .collect();
        let found = Ellipsoid::about(&corners).unwrap();
        assert_near(
            half_axes(&found),
            [0.1, 0.3, 0.5].map(|half| half * 3_f64.sqrt()),
        );
        assert_near(found.centre, [0.2, 0.4, 0.6]);
        assert!(corners.iter().all(|corner| contains(&found, corner)));
    }

    #[test]
    fn outermost_points_make_a_ball_of_a_sphere_and_leave_out_little_of_a_cloud() {
        let sphere: Vec<Vector> = directions().collect();
        let found = Ellipsoid::about(&outermost(&sphere)).unwrap();
        assert_near(half_axes(&found), [1.0; 3]);
        // Points of a body with edges, in no special place.
        let mut seed = 7_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 40) as f64 / f64::from(1 << 24)
        };
        let cloud: Vec<Vector> = (0..5000)
            .map(|_| {
                let [x, y, z] = [random(), random(), random()];
                [
                    0.4 * x + 0.1 * y,
                    0.1 * y * y - 0.2 * x,
                    0.05 * z * x + 0.02 * y,
                ]
            })
            .collect();
        let few = outermost(&cloud);
        assert!(few.len() <= 200, "{}", few.len());
        let found = Ellipsoid::about(&few).unwrap();
        let inverse = found.inverse();
        let farthest = (cloud.iter())
            .map(|point| square(&inverse, &found.centre, point).sqrt())
            .fold(0.0, f64::max);
        assert!(farthest < 1.02, "{farthest}");
    }

    #[test]
    fn a_wider_ellipsoid_contains_all_points_near() {
        let flat = Ellipsoid {
            centre: [0.1, 0.0, 0.0],
            shape: [[0.25, 0.1, 0.0], [0.1, 0.09, 0.0], [0.0, 0.0, 1e-6]],
        };
        let wider = flat.widened(0.03);
        for way in directions() {
            // The point of the surface with this normal.
            let by: Vector = std::array::from_fn(|i| dot(&flat.shape[i], &way));
            let to_surface = dot(&by, &way).sqrt();
            let beyond =
                std::array::from_fn(|i| flat.centre[i] + by[i] / to_surface + 0.03 * way[i]);
            assert!(contains(&wider, &beyond));
        }
        let volume = |of: &Ellipsoid| inverse(&of.shape)[2][2];
        assert!(volume(&wider) < volume(&flat));
    }

    #[test]
    fn points_without_a_volume_have_an_ellipsoid() {
        assert_eq!(Ellipsoid::about(&[]), None);
        assert!(outermost(&[]).is_empty());
        for points in [
            vec![[1.0, 2.0, 3.0]],
            vec![[0.0; 3], [1e20, 0.0, 0.0]],
            vec![[0.0; 3], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]],
        ] {
            let found = Ellipsoid::about(&points).unwrap();
            assert!(
                points.iter().all(|point| contains(&found, point)),
                "{found:?}"
            );
            let wider = found.widened(0.03);
            assert!(
                wider
                    .inverse()
                    .iter()
                    .flatten()
                    .all(|entry| entry.is_finite())
            );
        }
    }
}
