//! Principal axes of a body.

use std::array::from_fn;

use super::robot::quaternion;

/// Largest number of rotations; about ten reach the precision of numbers.
const ROTATIONS: usize = 100;

/// Returns principal moments of inertia, the largest first, and their axes as a quaternion of unit length: w, x, y, z.
///
/// - `inertia`: ixx, ixy, iyy, ixz, iyz, izz, kg·m².
///
/// # Source
///
/// Golub and Van Loan, "Matrix Computations", 4th edition, section 8.5: the method of Jacobi, largest entry first.
pub(super) fn principal(inertia: &[f64; 6]) -> ([f64; 3], [f64; 4]) {
    let [xx, xy, yy, xz, yz, zz] = *inertia;
    let mut a = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    let mut axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..ROTATIONS {
        let mut pairs = [(0, 1), (0, 2), (1, 2)];
        pairs.sort_by(|(i, j), (k, l)| a[*k][*l].abs().total_cmp(&a[*i][*j].abs()));
        let (p, q) = pairs[0];
        if a[p][q].abs() <= f64::EPSILON * (a[p][p] * a[q][q]).abs().sqrt() {
            break;
        }
        let tau = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
        let tan = tau.signum() / (tau.abs() + tau.hypot(1.0));
        let cos = tan.hypot(1.0).recip();
        let sin = tan * cos;
        for row in &mut a {
            (row[p], row[q]) = (cos * row[p] - sin * row[q], sin * row[p] + cos * row[q]);
        }
        let (up, down) = (a[p], a[q]);
        a[p] = from_fn(|k| cos * up[k] - sin * down[k]);
        a[q] = from_fn(|k| sin * up[k] + cos * down[k]);
        for row in &mut axes {
            (row[p], row[q]) = (cos * row[p] - sin * row[q], sin * row[p] + cos * row[q]);
        }
        (a[p][q], a[q][p]) = (0.0, 0.0);
    }
    let mut moments = [a[0][0], a[1][1], a[2][2]];
    for k in [0, 1, 0] {
        if moments[k] < moments[k + 1] {
            moments.swap(k, k + 1);
            // A quarter turn keeps the frame right-handed.
            for row in &mut axes {
                (row[k], row[k + 1]) = (row[k + 1], -row[k]);
            }
        }
    }
    (moments, quaternion(&axes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanism::rotation_of;

    #[test]
    fn moments_and_axes_give_the_inertia() {
        for inertia in [
            [0.12, 0.03, 0.15, -0.02, 0.025, 0.2],
            [4.0e-9, 1.0e-9, 5.0e-9, 2.0e-10, -3.0e-10, 6.0e-9],
            [0.2, 0.0, 0.2, 0.0, 0.0, 0.2],
            [1.0, 0.0, 2.0, 0.0, 0.0, 3.0],
            [2.0, 1.0, 2.0, 1.0, 1.0, 2.0],
        ] {
            let (moments, axes) = principal(&inertia);
            assert!(moments[0] >= moments[1] && moments[1] >= moments[2]);
            let r = rotation_of(axes);
            let entry = |i: usize, j: usize| -> f64 {
                (0..3).map(|k| r[i][k] * moments[k] * r[j][k]).sum()
            };
            let places = [(0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)];
            for ((i, j), expected) in places.into_iter().zip(inertia) {
                assert!(
                    (entry(i, j) - expected).abs() < 1e-14 * moments[0],
                    "{inertia:?}"
                );
            }
        }
    }
}
