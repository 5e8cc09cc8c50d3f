//! Objective of a design, as a function of the information with its gradient.

use faer::{Mat, Side};
use sprung_core::linear::{factor, invert};

use crate::description::Objective;

/// Exponent of the mean that approximates the largest relative error.
const LARGEST: f64 = 6.0;

/// The value of an objective, smaller is better, and its derivatives by the information.
#[derive(Clone, Debug)]
pub(super) struct Judged {
    /// A logarithm of standard errors: 0.1 less means errors that are 10 % smaller.
    pub(super) value: f64,
    pub(super) by_matrix: Mat<f64>,
}

/// What a search makes best.
#[derive(Clone, Debug)]
pub(super) struct Aim {
    pub(super) objective: Objective,
    /// Of the free parameters.
    pub(super) scales: Vec<f64>,
    /// Places of the parameters that count among the free ones.
    pub(super) chosen: Vec<usize>,
}

impl Aim {
    /// Returns how good the information of a motion is; `None` if it determines too little.
    pub(super) fn judge(&self, matrix: &Mat<f64>) -> Option<Judged> {
        judge(self.objective, matrix, &self.scales, &self.chosen)
    }
}

/// Judges an information matrix; `None` if it does not determine all parameters.
///
/// - `scales`: values to which errors are relative, of the free parameters, \[free\]; nuisance parameters follow
///   in the matrix.
/// - `chosen`: parameters that count, places in the matrix.
pub(super) fn judge(
    objective: Objective,
    matrix: &Mat<f64>,
    scales: &[f64],
    chosen: &[usize],
) -> Option<Judged> {
    let count = matrix.nrows();
    if objective == Objective::ConditionNumber {
        return condition(matrix, chosen);
    }
    let inverse = inverse(matrix)?;
    let variance = |i: usize| inverse[(i, i)];
    let logs = |i: usize| 0.5 * variance(i).ln();
    match objective {
        Objective::DOptimal => {
            // The determinant of the covariance of the chosen parameters.
            let covariance = Mat::from_fn(chosen.len(), chosen.len(), |i, j| {
                inverse[(chosen[i], chosen[j])]
            });
            let back = self::inverse(&covariance)?;
            let log = log_determinant(&covariance)?;
            let p = chosen.len() as f64;
            // d log det(E' A E) = tr(back E' dA E), with dA = -A dI A.
            let part = Mat::from_fn(count, chosen.len(), |i, j| inverse[(i, chosen[j])]);
            let by = &part * &back * part.transpose() * faer::Scale(-0.5 / p);
            Some(Judged {
                value: 0.5 * log / p,
                by_matrix: by,
            })
        }
        Objective::StandardErrors => {
            let p = chosen.len() as f64;
            let value = chosen.iter().map(|&i| logs(i)).sum::<f64>() / p;
            let weights = chosen.iter().map(|&i| (i, 0.5 / (p * variance(i))));
            Some(Judged {
                value,
                by_matrix: by_variances(&inverse, weights),
            })
        }
        Objective::WorstError => {
            let relative = |i: usize| logs(i) - scales[i].ln();
            let most = chosen.iter().map(|&i| relative(i)).fold(f64::MIN, f64::max);
            let sum: f64 = (chosen.iter())
                .map(|&i| (LARGEST * (relative(i) - most)).exp())
                .sum();
            let weights = chosen.iter().map(|&i| {
                let share = (LARGEST * (relative(i) - most)).exp() / sum;
                (i, 0.5 * share / variance(i))
            });
            Some(Judged {
                value: most + (sum / chosen.len() as f64).ln() / LARGEST,
                by_matrix: by_variances(&inverse, weights),
            })
        }
        Objective::ConditionNumber => None,
    }
}

/// Returns the derivatives of a function of the variances.
fn by_variances(inverse: &Mat<f64>, weights: impl Iterator<Item = (usize, f64)>) -> Mat<f64> {
    let count = inverse.nrows();
    let mut scaled = Mat::zeros(count, count);
    for (i, weight) in weights {
        for j in 0..count {
            scaled[(i, j)] = -weight * inverse[(i, j)];
        }
    }
    inverse * scaled
}

/// Half the logarithm of the condition number of the information of the chosen parameters with columns of length one.
pub(super) fn condition(matrix: &Mat<f64>, chosen: &[usize]) -> Option<Judged> {
    let p = chosen.len();
    let length = |i: usize| matrix[(chosen[i], chosen[i])].sqrt();
    let scaled = Mat::from_fn(p, p, |i, j| {
        matrix[(chosen[i], chosen[j])] / (length(i) * length(j))
    });
    if !(0..p).all(|i| (0..p).all(|j| scaled[(i, j)].is_finite())) {
        return None;
    }
    let decomposition = scaled.self_adjoint_eigen(Side::Lower).ok()?;
    let (values, vectors) = (decomposition.S(), decomposition.U());
    let (least, most) = (values[0], values[p - 1]);
    if least <= 0.0 {
        return None;
    }
    let by_scaled = Mat::from_fn(p, p, |i, j| {
        0.5 * (vectors[(i, p - 1)] * vectors[(j, p - 1)] / most
            - vectors[(i, 0)] * vectors[(j, 0)] / least)
    });
    let mut by = Mat::zeros(matrix.nrows(), matrix.nrows());
    for i in 0..p {
        for j in 0..p {
            if i == j {
                let sum: f64 = (0..p)
                    .filter(|&k| k != i)
                    .map(|k| by_scaled[(i, k)] * scaled[(i, k)])
                    .sum();
                by[(chosen[i], chosen[i])] = -sum / matrix[(chosen[i], chosen[i])];
            } else {
                by[(chosen[i], chosen[j])] = by_scaled[(i, j)] / (length(i) * length(j));
            }
        }
    }
    Some(Judged {
        value: 0.5 * (most / least).ln(),
        by_matrix: by,
    })
}

/// Returns the inverse of a symmetric positive definite matrix, through columns of length one.
pub(super) fn inverse(matrix: &Mat<f64>) -> Option<Mat<f64>> {
    let (factors, length) = factors(matrix)?;
    let p = matrix.nrows();
    let mut out = vec![0.0; p * p];
    invert(&factors, p, &mut out);
    Some(Mat::from_fn(p, p, |i, j| {
        out[i.max(j) * p + i.min(j)] / (length[i] * length[j])
    }))
}

fn log_determinant(matrix: &Mat<f64>) -> Option<f64> {
    let (factors, length) = factors(matrix)?;
    let p = matrix.nrows();
    // The diagonal of the factors has the reciprocals of the pivots.
    Some(
        (0..p)
            .map(|i| 2.0 * length[i].ln() - factors[i * p + i].ln())
            .sum(),
    )
}

fn factors(matrix: &Mat<f64>) -> Option<(Vec<f64>, Vec<f64>)> {
    let p = matrix.nrows();
    let length: Vec<f64> = (0..p).map(|i| matrix[(i, i)].sqrt()).collect();
    if length
        .iter()
        .any(|value| !(value.is_finite() && *value > 0.0))
    {
        return None;
    }
    let mut scaled = vec![0.0; p * p];
    for i in 0..p {
        for j in 0..p {
            scaled[i * p + j] = matrix[(i, j)] / (length[i] * length[j]);
        }
    }
    factor(&mut scaled, p).then_some((scaled, length))
}
