//! Normal equations with values that must not be negative.

use sprung_core::linear::{factor, solve};

use crate::regression::SystemPart;

/// Ridge of unit columns, which keeps collinear columns solvable.
pub(crate) const RIDGE: f64 = 1e-9;

/// Solves normal equations whose marked values must not be negative.
///
/// The most negative values are left out, those of more than half of the largest together, until none is negative. Then a value that would be positive beside the others
/// is taken up again, and those that it would make negative leave on the way, until none is left.
///
/// # Source
///
/// Lawson and Hanson, "Solving least squares problems", 1974, chapter 23, with a start near the solution.
///
/// - `free`: values that are not zero in a solution nearby; all if none is known. The solution is the same, found sooner.
pub(crate) fn non_negative(
    matrix: &[f64],
    rhs: &[f64],
    positive: &[bool],
    mut free: Vec<usize>,
) -> Vec<f64> {
    let n = rhs.len();
    let solved = |free: &[usize]| -> Option<Vec<f64>> {
        let mut of_free: Vec<f64> = (free.iter())
            .flat_map(|&i| free.iter().map(move |&j| matrix[i * n + j]))
            .collect();
        let mut value: Vec<f64> = free.iter().map(|&i| rhs[i]).collect();
        factor(&mut of_free, free.len()).then(|| {
            solve(&of_free, &mut value);
            let mut x = vec![0.0; n];
            for (&i, value) in free.iter().zip(value) {
                x[i] = value;
            }
            x
        })
    };
    let mut x = vec![0.0; n];
    while let Some(next) = solved(&free) {
        x = next;
        let worst = (free.iter().copied())
            .filter(|&i| positive[i])
            .fold(0.0, |worst: f64, i| worst.min(x[i]));
        if worst >= 0.0 {
            break;
        }
        free.retain(|&i| !positive[i] || x[i] > 0.5 * worst);
        for i in (0..n).filter(|i| positive[*i]) {
            x[i] = x[i].max(0.0);
        }
    }
    for _ in 0..2 * n {
        let slope = |i: usize| rhs[i] - (0..n).map(|j| matrix[i * n + j] * x[j]).sum::<f64>();
        let again = (0..n)
            .filter(|i| !free.contains(i) && slope(*i) > RIDGE * rhs[*i].abs())
            .max_by(|&a, &b| slope(a).total_cmp(&slope(b)));
        let Some(again) = again else { break };
        free.push(again);
        free.sort_unstable();
        while let Some(next) = solved(&free) {
            let leaving = (free.iter().copied())
                .filter(|&i| positive[i] && next[i] <= 0.0)
                .map(|i| (x[i] / (x[i] - next[i]), i))
                .min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((share, leaving)) = leaving else {
                x = next;
                break;
            };
            for (x, next) in x.iter_mut().zip(next) {
                *x += share * (next - *x);
            }
            x[leaving] = 0.0;
            free.retain(|&i| i != leaving);
        }
    }
    x
}

/// Returns the least-squares solution of factors with marked unknowns that must not be negative.
pub(super) fn with_signs(parts: &[SystemPart<'_>], positive: &[bool]) -> Vec<f64> {
    let n = positive.len();
    let (mut matrix, mut rhs) = (vec![0.0; n * n], vec![0.0; n]);
    for SystemPart { columns, factor } in parts {
        let width = columns.len();
        for (i, &row) in columns.iter().enumerate() {
            for k in 0..=i {
                let entry = factor.entry(k, i);
                rhs[row] += entry * factor.entry(k, width);
                for (j, &column) in columns.iter().enumerate().skip(k) {
                    matrix[row * n + column] += entry * factor.entry(k, j);
                }
            }
        }
    }
    let length: Vec<f64> = (0..n)
        .map(|i| matrix[i * (n + 1)].sqrt().max(f64::MIN_POSITIVE))
        .collect();
    for i in 0..n {
        for j in 0..n {
            matrix[i * n + j] /= length[i] * length[j];
        }
        matrix[i * (n + 1)] += RIDGE;
        rhs[i] /= length[i];
    }
    let x = non_negative(&matrix, &rhs, positive, (0..n).collect());
    (x.iter().zip(&length))
        .map(|(x, length)| x / length)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regression::Triangle;

    #[test]
    fn a_negative_value_becomes_zero_and_the_others_fit_without_it() {
        // y = 2 a − 0.5 b + c with columns that are not orthogonal.
        let lines: Vec<Vec<f64>> = (0..40)
            .map(|k| {
                let t = f64::from(k) * 0.3;
                let (a, b, c) = (t.sin() + 0.2, t.cos() + 0.5 * t.sin(), 1.0);
                vec![a, b, c, 2.0 * a - 0.5 * b + c]
            })
            .collect();
        let factor = Triangle::of_lines(&lines);
        let part = |columns: &'static [usize]| SystemPart {
            columns,
            factor: &factor,
        };
        let free = with_signs(&[part(&[0, 1, 2])], &[false; 3]);
        for (found, expected) in free.iter().zip([2.0, -0.5, 1.0]) {
            assert!((found - expected).abs() < 1e-6);
        }
        let signed = with_signs(&[part(&[0, 1, 2])], &[true; 3]);
        assert!(signed[1].abs() < 1e-12);
        let without: Vec<Vec<f64>> = lines.iter().map(|l| vec![l[0], l[2], l[3]]).collect();
        let without = Triangle::of_lines(&without);
        let alone = [SystemPart {
            columns: &[0, 1],
            factor: &without,
        }];
        let expected = with_signs(&alone, &[false; 2]);
        assert!((signed[0] - expected[0]).abs() < 1e-6 && (signed[2] - expected[1]).abs() < 1e-6);
    }
}
