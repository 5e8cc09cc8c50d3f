//! Standard errors by the jackknife: segments of the log are left out in turn.

use faer::Mat;
use faer::linalg::solvers::Solve;

use crate::regression::{Solution, Triangle};

/// Returns the change of each unknown when each group is left out, \[p × groups\].
///
/// - `columns`: unknowns in each row; `groups`: factors of each row, group by group.
///
/// With `N = AᵀA` of all groups and `N_g` of one group, the change is `(I - N⁻¹ N_g)⁻¹ N⁻¹` times
/// the group's gradient. If the other groups do not determine all unknowns, the change is
/// approximated by `N⁻¹` times the gradient.
///
/// # Source
///
/// The delete-one-group jackknife. Unlike the scatter of the gradients, it contains the reduction
/// of the residuals by the fit of many parameters to few groups.
pub(super) fn influences(
    solution: &Solution,
    columns: &[Vec<usize>],
    groups: &[Vec<Triangle>],
) -> Mat<f64> {
    let p = solution.x.len();
    let inverse = &solution.inverse;
    // Scaled by the size of each unknown, the matrices are of order one.
    let unit: Vec<f64> = (0..p)
        .map(|i| match inverse[(i, i)].sqrt() {
            unit if unit > 0.0 => unit,
            _ => 1.0,
        })
        .collect();
    let mut moved = Mat::<f64>::zeros(p, groups.len());
    for (g, factors) in groups.iter().enumerate() {
        let mut gradient = Mat::<f64>::zeros(p, 1);
        let mut gram = Mat::<f64>::zeros(p, p);
        for (columns, factor) in columns.iter().zip(factors) {
            let x: Vec<f64> = columns.iter().map(|&c| solution.x[c]).collect();
            for (&c, value) in columns.iter().zip(factor.gradient(&x)) {
                gradient[(c, 0)] += value;
            }
            for (i, &row) in columns.iter().enumerate() {
                for (j, &column) in columns.iter().enumerate() {
                    let product: f64 = (0..=i.min(j))
                        .map(|k| factor.entry(k, i) * factor.entry(k, j))
                        .sum();
                    gram[(row, column)] += product;
                }
            }
        }
        let kept_in = inverse * &gradient;
        let share = inverse * &gram;
        let rest = Mat::from_fn(p, p, |i, j| {
            f64::from(u8::from(i == j)) - share[(i, j)] * unit[j] / unit[i]
        });
        let scaled = Mat::from_fn(p, 1, |i, _| kept_in[(i, 0)] / unit[i]);
        let left_out = rest.partial_piv_lu().solve(&scaled);
        let finite = (0..p).all(|i| left_out[(i, 0)].is_finite());
        for i in 0..p {
            moved[(i, g)] = if finite {
                left_out[(i, 0)] * unit[i]
            } else {
                kept_in[(i, 0)]
            };
        }
    }
    moved
}

/// Returns the standard errors of the unknowns; infinite for fewer than two groups.
pub(super) fn scatter(moved: &Mat<f64>) -> Vec<f64> {
    let groups = moved.ncols();
    let count = groups as f64;
    if groups < 2 {
        return vec![f64::INFINITY; moved.nrows()];
    }
    let correction = (count - 1.0) / count;
    (0..moved.nrows())
        .map(|i| {
            let squares: f64 = (0..groups).map(|g| moved[(i, g)].powi(2)).sum();
            (correction * squares).sqrt()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regression::{SystemPart, solve};

    /// Rows `[A | b]` of a group.
    fn group(g: u32) -> [[f64; 3]; 4] {
        std::array::from_fn(|k| {
            let t = f64::from(g) * 1.7 + k as f64;
            [
                t.sin(),
                1e3 * (0.3 * t).cos(),
                t.cos() + 0.2 * (t * t).sin(),
            ]
        })
    }

    #[test]
    fn influences_equal_solutions_without_each_group() {
        let factors: Vec<Triangle> = (0..8).map(|g| Triangle::of(&group(g))).collect();
        let solved = |left_out: Option<usize>| {
            let kept = (factors.iter().enumerate()).filter(|(g, _)| Some(*g) != left_out);
            let parts: Vec<SystemPart<'_>> = kept
                .map(|(_, factor)| SystemPart {
                    columns: &[0, 1],
                    factor,
                })
                .collect();
            solve(&parts, 2).unwrap()
        };
        let all = solved(None);
        let groups: Vec<Vec<Triangle>> = factors.iter().map(|f| vec![f.clone()]).collect();
        let moved = influences(&all, &[vec![0, 1]], &groups);
        for g in 0..8 {
            let without = solved(Some(g));
            for i in 0..2 {
                let expected = without.x[i] - all.x[i];
                assert!((moved[(i, g)] - expected).abs() < 1e-9 * all.x[i].abs());
            }
        }
        assert!(scatter(&moved).iter().all(|error| *error > 0.0));
        assert!(scatter(&Mat::zeros(2, 1)).iter().all(|e| e.is_infinite()));
    }
}
