//! Scalar products, and the solution of symmetric positive definite equations. Zeros before the first entry of a row are
//! skipped, so a mass matrix whose links and motors do not couple needs only the operations of its
//! two blocks.

/// Factors a symmetric matrix in place into `L D L^T`.
///
/// - `a`: \[n × n\], row by row. Only the lower triangle is read. Afterwards it contains `L`, and
///   `1 / D` on the diagonal.
///
/// Returns whether the matrix is positive definite. If it is not, `a` contains no valid factors.
pub fn factor(a: &mut [f64], n: usize) -> bool {
    for i in 0..n {
        let (above, row) = a.split_at_mut(i * n);
        let first = first_entry(row, i);
        let mut pivot = row[i];
        for j in first..i {
            // Entries of row i before j are those of L D; entries after j are still those of A.
            let other = &above[j * n..j * n + j];
            row[j] -= dot(&row[first..j], &other[first..]);
        }
        for j in first..i {
            let scaled = row[j] * above[j * n + j];
            pivot -= row[j] * scaled;
            row[j] = scaled;
        }
        row[i] = 1.0 / pivot;
        let positive = pivot > 0.0;
        if !positive {
            return false;
        }
    }
    true
}

/// Solves `A x = b` in place with the factors of [`factor`].
///
/// - `b`: \[n\].
pub fn solve(factors: &[f64], b: &mut [f64]) {
    let n = b.len();
    for i in 1..n {
        let row = &factors[i * n..i * n + i];
        let first = first_entry(row, i);
        let known: f64 = (row[first..].iter().zip(&b[first..i]))
            .map(|(l, x)| l * x)
            .sum();
        b[i] -= known;
    }
    for (i, x) in b.iter_mut().enumerate() {
        *x *= factors[i * n + i];
    }
    for i in (1..n).rev() {
        let row = &factors[i * n..i * n + i];
        let x = b[i];
        for k in first_entry(row, i)..i {
            b[k] -= row[k] * x;
        }
    }
}

/// Writes the inverse of a matrix from the factors of [`factor`].
///
/// - `inverse`: \[n × n\], row by row.
pub fn invert(factors: &[f64], n: usize, inverse: &mut [f64]) {
    inverse.fill(0.0);
    for i in 0..n {
        inverse[i * n + i] = 1.0;
        let row = &factors[i * n..i * n + i];
        for (k, &l) in row.iter().enumerate().skip(first_entry(row, i)) {
            subtract(inverse, n, i, k, l, k + 1);
        }
    }
    for i in 0..n {
        for x in &mut inverse[i * n..=i * n + i] {
            *x *= factors[i * n + i];
        }
    }
    for i in (1..n).rev() {
        let row = &factors[i * n..i * n + i];
        for (k, &l) in row.iter().enumerate().skip(first_entry(row, i)) {
            subtract(inverse, n, k, i, l, n);
        }
    }
}

/// Number of sums that a scalar product of long vectors adds up side by side.
const LANES: usize = 8;

/// Returns the scalar product of two vectors, up to the end of the shorter one. Its bits do not depend on the machine.
#[must_use]
#[inline]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let count = a.len().min(b.len());
    let (a, b) = (&a[..count], &b[..count]);
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut lanes = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for (lane, (a, b)) in lanes.iter_mut().zip(a.iter().zip(b)) {
            *lane += a * b;
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    lanes.iter().sum::<f64>() + rest
}

/// Subtracts `factor` times the first `count` numbers of row `of` from row `row`.
fn subtract(a: &mut [f64], n: usize, row: usize, of: usize, factor: f64, count: usize) {
    let (before, behind) = a.split_at_mut(row.max(of) * n);
    let near = &mut before[row.min(of) * n..];
    let (sum, other) = if row < of {
        (near, &*behind)
    } else {
        (behind, &*near)
    };
    for (sum, x) in sum[..count].iter_mut().zip(&other[..count]) {
        *sum -= factor * x;
    }
}

/// Returns the column of the first non-zero entry of a row, or the diagonal if all entries before
/// it are zero.
fn first_entry(row: &[f64], diagonal: usize) -> usize {
    let before = row[..diagonal].iter();
    before.take_while(|x| x.abs() <= 0.0).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scalar_product_ends_with_the_shorter_vector() {
        let (mut a, mut b) = ([0.0; 11], [0.0; 19]);
        for (k, value) in a.iter_mut().enumerate() {
            *value = k as f64 + 1.0;
        }
        b.fill(2.0);
        assert!((dot(&a, &b) - 132.0).abs() < 1e-12 && (dot(&b, &a) - 132.0).abs() < 1e-12);
    }

    fn assert_close(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-15, "{found} {expected}");
    }

    #[test]
    fn known_system_is_solved() {
        // A = L D L^T with L = [1 0 0; 1/2 1 0; -1/2 2/3 1] and D = diag(4, 9, 1), and b = A [1 -2
        // 3]^T. The upper triangle is not read.
        let unread = f64::NAN;
        let mut a = [4.0, unread, unread, 2.0, 10.0, unread, -2.0, 5.0, 6.0];
        let mut b = [-6.0, -3.0, 6.0];
        assert!(factor(&mut a, 3));
        solve(&a, &mut b);
        for (found, expected) in b.iter().zip([1.0, -2.0, 3.0]) {
            assert_close(*found, expected);
        }
        for (at, expected) in [
            (0, 0.25),
            (3, 0.5),
            (4, 1.0 / 9.0),
            (6, -0.5),
            (7, 2.0 / 3.0),
            (8, 1.0),
        ] {
            assert_close(a[at], expected);
        }
    }

    #[test]
    fn inverse_times_matrix_is_one() {
        let a = [4.0, 2.0, -2.0, 2.0, 10.0, 5.0, -2.0, 5.0, 6.0];
        let (mut factors, mut inverse) = (a, [f64::NAN; 9]);
        assert!(factor(&mut factors, 3));
        invert(&factors, 3, &mut inverse);
        for i in 0..3 {
            for j in 0..3 {
                let entry: f64 = (0..3).map(|k| a[3 * i + k] * inverse[3 * k + j]).sum();
                assert!((entry - f64::from(u8::from(i == j))).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn uncoupled_blocks_are_solved_separately() {
        // [4 2; 2 10], [5], [2 1; 1 3] along the diagonal.
        let mut a = [0.0; 25];
        for (i, j, entry) in [
            (0, 0, 4.0),
            (1, 0, 2.0),
            (1, 1, 10.0),
            (2, 2, 5.0),
            (3, 3, 2.0),
            (4, 3, 1.0),
            (4, 4, 3.0),
        ] {
            a[i * 5 + j] = entry;
        }
        assert!(factor(&mut a, 5));
        let mut b = [8.0, 22.0, 15.0, 6.0, 13.0];
        solve(&a, &mut b);
        for (found, expected) in b.iter().zip([1.0, 2.0, 3.0, 1.0, 4.0]) {
            assert!((found - expected).abs() < 1e-14, "{b:?}");
        }
    }

    #[test]
    fn a_matrix_that_is_not_positive_definite_is_refused() {
        for mut a in [
            [1.0, 2.0, 2.0, 1.0],
            [-1.0, 0.0, 0.0, 1.0],
            [1.0, 0.0, 0.0, -1.0],
            [1.0, 1.0, 1.0, 1.0],
            [0.0; 4],
            [f64::NAN, 0.0, 0.0, 1.0],
        ] {
            assert!(!factor(&mut a, 2), "{a:?}");
        }
    }
}
