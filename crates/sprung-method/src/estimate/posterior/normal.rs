//! The normal distribution of the unknowns without the set of robots that can exist.

use faer::Mat;
use faer::linalg::solvers::DenseSolveCore;
use sprung_core::spatial::BODY;

use super::evidence::Evidence;
use super::rest::Rest;
use crate::estimate::possible::{Robots, inverse};
use crate::estimate::result::EstimateResult;
use crate::estimate::statistics::LARGE_SHARE;
use crate::model::Program;

/// The posterior without the set.
pub(super) struct Normal {
    pub(super) mean: Vec<f64>,
    pub(super) precision: Mat<f64>,
    /// Second derivatives of minus the logarithm of the prior, \[unknowns × unknowns\].
    prior: Mat<f64>,
}

impl Normal {
    /// The prior decides only directions that the log does not determine: the distribution of the parameters that the
    /// log determines is that of the log.
    ///
    /// - `bodies`: most likely bodies by the prior, \[unknowns\].
    pub(super) fn new(
        robots: &Robots<'_>,
        bodies: &[f64],
        evidence: &Evidence,
        rest: &Rest,
    ) -> Option<Self> {
        let (n, count) = (robots.columns.len(), robots.standard.len());
        let of_bodies = Program {
            blocks: (robots.prior.blocks.iter())
                .filter(|block| block.entropy > 0.0)
                .cloned()
                .collect(),
            ..robots.prior.clone()
        };
        let hessian = of_bodies.hessian(bodies)?;
        let mut prior = Mat::from_fn(n, n, |i, j| hessian[i * n + j]);
        let mut middle = bodies.to_vec();
        for (at, [value, error]) in (count..).zip(&rest.others) {
            prior[(at, at)] = error.powi(-2);
            middle[at] = *value;
        }
        let known = &evidence.known;
        let t = Mat::from_fn(known.len(), n, |i, j| robots.columns[j][known[i]]);
        let moved = inverse(&prior)? * t.transpose();
        // Information about the known parameters by the prior alone; that by the log takes its place.
        let before = inverse(&(&t * &moved))?;
        let precision = &prior + t.transpose() * (&evidence.information - &before) * &t;
        let of_middle = &t * Mat::from_fn(n, 1, |i, _| middle[i]);
        let rest = Mat::from_fn(known.len(), 1, |i, _| {
            evidence.values[i] - robots.constant[known[i]] - of_middle[(i, 0)]
        });
        let by = &moved * (&before * &rest);
        let mean: Vec<f64> = (0..n).map(|i| middle[i] + by[(i, 0)]).collect();
        let precision = Mat::from_fn(n, n, |i, j| {
            f64::midpoint(precision[(i, j)], precision[(j, i)])
        });
        let is_finite = mean.iter().all(|value| value.is_finite())
            && (0..n * n).all(|at| precision[(at / n, at % n)].is_finite());
        is_finite.then_some(Self {
            mean,
            precision,
            prior,
        })
    }

    /// Returns the names of inertial parameters whose variance is that of the prior.
    pub(super) fn undetermined(&self, robots: &Robots<'_>) -> Vec<String> {
        let (Some(links), Some(before), Some(after)) = (
            robots.model.links(),
            inverse(&self.prior),
            inverse(&self.precision),
        ) else {
            return Vec::new();
        };
        (robots.standard.iter().enumerate())
            .filter(|(i, _)| after[(*i, *i)] > (1.0 - LARGE_SHARE) * before[(*i, *i)])
            .map(|(_, index)| links.name(*index).to_owned())
            .collect()
    }
}

/// Returns the most likely bodies by the prior, \[unknowns\]: nominal bodies, else bodies in the middle between
/// ordinary ones and those of the result. Ordinary bodies alone may be ten times too small for the log, and those of
/// the result may be thin.
pub(super) fn bodies(robots: &Robots<'_>, result: &EstimateResult) -> Vec<f64> {
    let links = robots.model.joint_count() * BODY;
    let mut bodies = robots.start.clone();
    for (value, &index) in bodies.iter_mut().zip(&robots.standard) {
        let is_nominal = (robots.priors.get(index / BODY)).is_some_and(|prior| prior.is_nominal);
        if let Some(found) = result.standard_parameters.get(index)
            && index < links
            && !is_nominal
        {
            *value = f64::midpoint(*value, found.value);
        }
    }
    bodies
}

/// Returns vectors whose products give the inverse of a positive definite matrix: independent standard normal numbers
/// times these have this covariance.
///
/// - `matrix`: \[n × n\].
pub(super) fn coordinates(matrix: &Mat<f64>) -> Option<Vec<Vec<f64>>> {
    let n = matrix.nrows();
    let scale: Vec<f64> = (0..n).map(|i| matrix[(i, i)].sqrt().recip()).collect();
    // The last unknowns, the drives, come first, so their coordinates change no body.
    let back = |i: usize| n - 1 - i;
    let scaled = Mat::from_fn(n, n, |i, j| {
        matrix[(back(i), back(j))] * scale[back(i)] * scale[back(j)]
    });
    let factor = scaled.llt(faer::Side::Lower).ok()?;
    let inverse = factor.L().to_owned().partial_piv_lu().inverse();
    let entry = |k: usize, i: usize| {
        if back(i) <= k {
            scale[i] * inverse[(k, back(i))]
        } else {
            0.0
        }
    };
    let directions: Vec<Vec<f64>> = (0..n)
        .map(|k| (0..n).map(|i| entry(k, i)).collect())
        .collect();
    let is_finite = directions.iter().flatten().all(|entry| entry.is_finite());
    is_finite.then_some(directions)
}
