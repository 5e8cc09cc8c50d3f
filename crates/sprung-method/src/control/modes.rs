//! Vibrations of linearised equations.

use std::f64::consts::TAU;

use faer::linalg::solvers::Solve;
use faer::{Mat, c64};

use super::linear::Linear;

/// Least part of a vibration's energy in a spring to which it belongs.
const LEAST_SPRING_SHARE: f64 = 0.05;

/// A vibration.
#[derive(Clone, Debug)]
pub(super) struct Mode {
    /// Eigenvalue with a positive imaginary part, rad/s.
    eigenvalue: c64,
    /// Shape, \[rows\].
    shape: Vec<c64>,
}

impl Mode {
    /// Returns the vibrations that are not overdamped.
    #[must_use]
    pub(super) fn all(linear: &Linear) -> Vec<Self> {
        let rows = linear.mass.nrows();
        let factors = linear.mass.partial_piv_lu();
        let (spring, damper) = (
            factors.solve(&linear.stiffness),
            factors.solve(&linear.damping),
        );
        let matrix = Mat::from_fn(2 * rows, 2 * rows, |i, j| match (i < rows, j < rows) {
            (true, _) => f64::from(u8::from(j == i + rows)),
            (false, true) => -spring[(i - rows, j)],
            (false, false) => -damper[(i - rows, j - rows)],
        });
        let Ok(eigen) = matrix.eigen() else {
            return Vec::new();
        };
        let (vectors, values) = (eigen.U(), eigen.S().column_vector());
        (0..2 * rows)
            .filter(|&k| values[k].im > 0.0)
            .map(|k| Self {
                eigenvalue: values[k],
                shape: (0..rows).map(|i| vectors[(i, k)]).collect(),
            })
            .collect()
    }

    /// Returns the part of the vibration's energy in a spring.
    ///
    /// - `ends`: coordinates of its motor and link; `None` if the motor is held.
    pub(super) fn spring_share(
        &self,
        linear: &Linear,
        stiffness: f64,
        ends: (Option<usize>, usize),
    ) -> f64 {
        let moves = quadratic(&linear.mass, &self.shape, |x| x.conj()).re;
        let motor = ends.0.map_or(c64::new(0.0, 0.0), |motor| self.shape[motor]);
        let stretch = motor - self.shape[ends.1];
        stiffness * stretch.norm_sqr() / (self.eigenvalue.norm_sqr() * moves)
    }

    /// Returns the natural frequency, Hz.
    pub(super) fn hz(&self) -> f64 {
        self.eigenvalue.norm() / TAU
    }

    /// Returns the damping ratio.
    pub(super) fn damping(&self) -> f64 {
        -self.eigenvalue.re / self.eigenvalue.norm()
    }
}

fn quadratic(matrix: &Mat<f64>, shape: &[c64], left: impl Fn(c64) -> c64) -> c64 {
    let rows = shape.len();
    (0..rows)
        .flat_map(|i| (0..rows).map(move |j| (i, j)))
        .map(|(i, j)| left(shape[i]) * shape[j] * matrix[(i, j)])
        .sum()
}

/// Assigns one vibration to each spring: repeatedly the pair with the largest part of the energy.
///
/// - `shares`: part of each vibration's energy in each spring, \[springs\]\[vibrations\].
pub(super) fn assigned(shares: &[Vec<f64>]) -> Vec<Option<usize>> {
    let mut owners = vec![None; shares.len()];
    let mut pairs: Vec<(f64, usize, usize)> = (shares.iter().enumerate())
        .flat_map(|(spring, of)| of.iter().enumerate().map(move |(k, x)| (*x, spring, k)))
        .filter(|(share, _, _)| *share >= LEAST_SPRING_SHARE)
        .collect();
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut taken = Vec::new();
    for (_, spring, mode) in pairs {
        if owners[spring].is_none() && !taken.contains(&mode) {
            owners[spring] = Some(mode);
            taken.push(mode);
        }
    }
    owners
}
