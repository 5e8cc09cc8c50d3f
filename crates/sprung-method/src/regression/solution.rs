//! Least squares on reduced systems.

use faer::Mat;

use super::householder::RowBlock;
use super::triangle::Triangle;

/// Singular values below this fraction of the largest count as zero, columns scaled to unit length.
const RANK_TOLERANCE: f64 = 1e-8;

/// A parameter with at least this component in an unobserved direction is not identifiable.
const UNOBSERVED_SHARE: f64 = 1e-3;

/// The factor of one equation and its unknowns.
#[derive(Clone, Copy, Debug)]
pub struct SystemPart<'a> {
    /// Columns of theta, one per unknown of the factor.
    pub columns: &'a [usize],
    /// The factor.
    pub factor: &'a Triangle,
}

/// The least-squares solution of a system with figures of its conditioning.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Unknowns, \[p\]. If the rank is deficient, this is the shortest solution with columns scaled
    /// to unit length.
    pub x: Vec<f64>,
    /// Whether the data determine each unknown, \[p\].
    pub identifiable: Vec<bool>,
    /// Numerical rank.
    pub rank: usize,
    /// Ratio of the extreme singular values, without column scaling.
    pub condition_number: f64,
    /// Ratio of the extreme singular values, columns scaled to unit length.
    pub condition_number_scaled: f64,
    /// Component of each unknown in the least excited of the observed directions, columns scaled to
    /// unit length, \[p\].
    pub weakest_direction: Vec<f64>,
    /// `(A^T A)^-1` on the observed directions, \[p × p\].
    pub inverse: Mat<f64>,
}

/// Solves the stacked system of several equations.
///
/// - `unknowns`: p, above every column index.
///
/// Columns are scaled to unit length and the triangular factor is decomposed by singular values;
/// `A^T A` is never formed.
///
/// Returns `None` if a number is not finite, or nothing is unknown.
///
/// # Source
///
/// Eq. (28), by a method that does not square the condition number.
#[must_use]
pub fn solve(parts: &[SystemPart<'_>], unknowns: usize) -> Option<Solution> {
    if unknowns == 0 {
        return None;
    }
    let (mut a, b) = assemble(parts, unknowns);
    if !(a.norm_max().is_finite() && b.iter().all(|value| value.is_finite())) {
        return None;
    }
    let raw = a.singular_values().ok()?;
    let norms = scale_columns(&mut a);
    let svd = a.thin_svd().ok()?;
    let (u, v) = (svd.U(), svd.V());
    let sigma: Vec<f64> = svd.S().column_vector().iter().copied().collect();
    let limit = RANK_TOLERANCE * sigma[0];
    let rank = sigma.iter().filter(|&&s| s > limit).count();

    let mut x = vec![0.0; unknowns];
    let mut inverse = Mat::<f64>::zeros(unknowns, unknowns);
    for k in 0..rank {
        let projected: f64 = (0..b.len()).map(|i| u[(i, k)] * b[i]).sum();
        for i in 0..unknowns {
            x[i] += v[(i, k)] * projected / (sigma[k] * norms[i]);
            for j in 0..unknowns {
                inverse[(i, j)] +=
                    v[(i, k)] * v[(j, k)] / (sigma[k] * sigma[k] * norms[i] * norms[j]);
            }
        }
    }
    let identifiable = (0..unknowns)
        .map(|i| (rank..unknowns).all(|k| v[(i, k)].abs() < UNOBSERVED_SHARE))
        .collect();
    let weakest = rank.max(1) - 1;
    Some(Solution {
        x,
        identifiable,
        rank,
        condition_number: ratio(raw[0], raw[unknowns - 1]),
        condition_number_scaled: ratio(sigma[0], sigma[unknowns - 1]),
        weakest_direction: (0..unknowns).map(|i| v[(i, weakest)].abs()).collect(),
        inverse,
    })
}

/// Solves a system for the unknowns alone, faster than [`solve`]; `None` if the data do not
/// determine all of them. Traces use it, because they solve many systems.
#[must_use]
pub(crate) fn solve_quickly(parts: &[SystemPart<'_>], unknowns: usize) -> Option<Vec<f64>> {
    let (order, norms) = order_and_norms(parts, unknowns);
    let mut places = vec![0; unknowns];
    for (place, &column) in order.iter().enumerate() {
        places[column] = place;
    }
    let mut triangle = Triangle::zero(unknowns + 1);
    for part in parts {
        let m = part.columns.len();
        let mut block = RowBlock::zeros(m + 1, unknowns + 1);
        for (j, &column) in part.columns.iter().enumerate() {
            let entries = block.column_mut(places[column]).iter_mut();
            for (i, entry) in entries.enumerate().take(j + 1) {
                *entry = part.factor.entry(i, j) / norms[column];
            }
        }
        let rhs = block.column_mut(unknowns).iter_mut();
        for (i, entry) in rhs.enumerate().take(m + 1) {
            *entry = part.factor.entry(i, m);
        }
        triangle.fold(&mut block, m + 1);
    }
    let mut x = vec![0.0; unknowns];
    for i in (0..unknowns).rev() {
        let pivot = triangle.entry(i, i);
        // Columns have unit length, so a pivot is a fraction of 1.
        if pivot.abs() <= RANK_TOLERANCE || !pivot.is_finite() {
            return None;
        }
        let known: f64 = (i + 1..unknowns).map(|j| triangle.entry(i, j) * x[j]).sum();
        x[i] = (triangle.entry(i, unknowns) - known) / pivot;
    }
    Some(
        (places.iter().zip(norms))
            .map(|(&place, norm)| x[place] / norm)
            .collect(),
    )
}

/// Returns the order in which the columns are eliminated, and their lengths; a column of zeros has
/// length 1. Columns of few equations come first, because they leave most entries of the others
/// zero.
fn order_and_norms(parts: &[SystemPart<'_>], unknowns: usize) -> (Vec<usize>, Vec<f64>) {
    let mut squares = vec![0.0; unknowns];
    let mut uses = vec![0; unknowns];
    for part in parts {
        for (j, &column) in part.columns.iter().enumerate() {
            squares[column] += part.factor.column_norm(j).powi(2);
            uses[column] += 1;
        }
    }
    let mut order: Vec<usize> = (0..unknowns).collect();
    order.sort_by_key(|&column| uses[column]);
    let norms = squares
        .into_iter()
        .map(|squares: f64| match squares.sqrt() {
            norm if norm > 0.0 => norm,
            _ => 1.0,
        });
    (order, norms.collect())
}

/// Stacks the factors in the columns of theta.
fn assemble(parts: &[SystemPart<'_>], unknowns: usize) -> (Mat<f64>, Vec<f64>) {
    let height: usize = parts.iter().map(|part| part.columns.len() + 1).sum();
    let mut a = Mat::<f64>::zeros(height.max(unknowns), unknowns);
    let mut b = vec![0.0; a.nrows()];
    let mut row = 0;
    for part in parts {
        let m = part.columns.len();
        for i in 0..=m {
            for (j, &column) in part.columns.iter().enumerate().skip(i) {
                a[(row, column)] = part.factor.entry(i, j);
            }
            b[row] = part.factor.entry(i, m);
            row += 1;
        }
    }
    (a, b)
}

/// Scales the columns to unit length and returns their former lengths; a column of zeros stays.
fn scale_columns(a: &mut Mat<f64>) -> Vec<f64> {
    (0..a.ncols())
        .map(|j| {
            let norm = match a.col(j).norm_l2() {
                norm if norm > 0.0 => norm,
                _ => 1.0,
            };
            for i in 0..a.nrows() {
                a[(i, j)] /= norm;
            }
            norm
        })
        .collect()
}

fn ratio(largest: f64, smallest: f64) -> f64 {
    if smallest > 0.0 {
        largest / smallest
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factor(rows: &[[f64; 4]]) -> Triangle {
        Triangle::of(rows)
    }

    fn rows(columns: impl Fn(f64) -> [f64; 3]) -> Vec<[f64; 4]> {
        (0..40)
            .map(|k| {
                let [a, b, c] = columns(f64::from(k) * 0.37);
                [a, b, c, 2.0 * a - 3.0 * b + 0.5 * c]
            })
            .collect()
    }

    #[test]
    fn full_rank_is_solved_exactly() {
        let triangle = factor(&rows(|t| [t.sin(), 1e4 * t.cos(), 1e-3 * t]));
        let part = SystemPart {
            columns: &[2, 0, 1],
            factor: &triangle,
        };
        let solution = solve(&[part], 3).unwrap();
        assert_eq!(solution.rank, 3);
        assert!(solution.identifiable.iter().all(|&yes| yes));
        let quick = solve_quickly(&[part], 3).unwrap();
        for (i, expected) in [-3.0, 0.5, 2.0].into_iter().enumerate() {
            assert!((solution.x[i] - expected).abs() < 1e-9);
            assert!((quick[i] - expected).abs() < 1e-9);
        }
    }

    #[test]
    fn unobserved_directions_are_not_identifiable() {
        // The third column repeats the second, so only the sum of their parameters is observed.
        let triangle = factor(&rows(|t| [t.sin(), t.cos(), t.cos()]));
        let part = SystemPart {
            columns: &[0, 1, 2],
            factor: &triangle,
        };
        let solution = solve(&[part], 3).unwrap();
        assert_eq!(solution.rank, 2);
        assert!(solve_quickly(&[part], 3).is_none());
        assert_eq!(solution.identifiable, [true, false, false]);
        assert!((solution.x[0] - 2.0).abs() < 1e-12);
        assert!((solution.x[1] + solution.x[2] + 2.5).abs() < 1e-12);
    }

    #[test]
    fn nothing_unknown_has_no_solution() {
        assert!(solve(&[], 0).is_none());
    }

    #[test]
    fn a_zero_system_has_rank_zero() {
        let triangle = factor(&[[0.0; 4]; 9]);
        let part = SystemPart {
            columns: &[0, 1, 2],
            factor: &triangle,
        };
        let solution = solve(&[part], 3).unwrap();
        assert_eq!(solution.rank, 0);
        assert!(solution.identifiable.iter().all(|&yes| !yes));
        assert!(solution.condition_number.is_infinite());
    }
}
