//! Borders of the set of robots that can exist along the directions of the coordinates.

use crate::model::{Block, ROWS};

const SIZE: usize = ROWS * ROWS;

/// Part of the distance to a border that a step keeps, so that rounding puts no robot outside.
const MARGIN: f64 = 1e-9;

/// Rotations after which the eigenvalues of a small matrix are exact: each sweep squares the relative rest.
const MAX_SWEEPS: usize = 12;

/// Rest of a matrix beside its diagonal at which its eigenvalues are exact to the margin, relative to its size.
const NEGLIGIBLE: f64 = 1e-10;

/// Numbers and small matrices that must be positive, as linear functions of coordinates.
#[derive(Clone, Debug)]
pub(super) struct Borders {
    /// Values at the origin.
    origin: Place,
    /// Rows of each matrix.
    rows: Vec<usize>,
    /// Changes by each coordinate.
    along: Vec<Change>,
}

/// Change of numbers and matrices by one coordinate: index, and change.
#[derive(Clone, Debug)]
struct Change {
    numbers: Vec<(usize, f64)>,
    matrices: Vec<(usize, [f64; SIZE])>,
}

/// Values of numbers and matrices.
#[derive(Clone, Debug)]
pub(super) struct Place {
    numbers: Vec<f64>,
    matrices: Vec<[f64; SIZE]>,
}

impl Borders {
    /// - `origin`: unknowns at the origin of the coordinates; `directions`: change of the unknowns by each coordinate.
    pub(super) fn new(blocks: &[Block], origin: &[f64], directions: &[Vec<f64>]) -> Self {
        let (single, more): (Vec<&Block>, Vec<&Block>) =
            blocks.iter().partition(|block| block.rows == 1);
        let change = |block: &Block, by: &[f64]| -> [f64; SIZE] {
            let mut matrix = [0.0; SIZE];
            for (unknown, entries) in &block.terms {
                for entry in entries {
                    let (i, j) = (entry.row, entry.column);
                    matrix[i * block.rows + j] += by[*unknown] * entry.by;
                    if i != j {
                        matrix[j * block.rows + i] += by[*unknown] * entry.by;
                    }
                }
            }
            matrix
        };
        let is_moved = |matrix: &[f64; SIZE]| matrix.iter().any(|entry| entry.abs() > 0.0);
        let along = directions.iter().map(|by| Change {
            numbers: (single.iter().enumerate())
                .map(|(at, block)| (at, change(block, by)[0]))
                .filter(|(_, number)| number.abs() > 0.0)
                .collect(),
            matrices: (more.iter().enumerate())
                .map(|(at, block)| (at, change(block, by)))
                .filter(|(_, matrix)| is_moved(matrix))
                .collect(),
        });
        Self {
            along: along.collect(),
            rows: more.iter().map(|block| block.rows).collect(),
            origin: Place {
                numbers: single.iter().map(|block| block.at(origin)[0]).collect(),
                matrices: more.iter().map(|block| block.at(origin)).collect(),
            },
        }
    }

    /// Returns the place of coordinates.
    pub(super) fn at(&self, coordinates: &[f64]) -> Place {
        let mut place = self.origin.clone();
        for (coordinate, by) in coordinates.iter().enumerate() {
            self.go(&mut place, coordinate, *by);
        }
        place
    }

    /// Moves a place along a coordinate.
    pub(super) fn go(&self, place: &mut Place, coordinate: usize, by: f64) {
        let change = &self.along[coordinate];
        for (at, number) in &change.numbers {
            place.numbers[*at] += by * number;
        }
        for (at, matrix) in &change.matrices {
            for (entry, slope) in place.matrices[*at].iter_mut().zip(matrix) {
                *entry += by * slope;
            }
        }
    }

    /// Returns whether all numbers and matrices are positive at a place.
    pub(super) fn contain(&self, place: &Place) -> bool {
        place.numbers.iter().all(|number| *number > 0.0)
            && (place.matrices.iter().zip(&self.rows))
                .all(|(matrix, rows)| is_positive(matrix, *rows))
    }

    /// Moves a place along a coordinate if all numbers and matrices stay positive. Returns whether they do.
    pub(super) fn may_go(&self, place: &mut Place, coordinate: usize, by: f64) -> bool {
        let change = &self.along[coordinate];
        let mut numbers = change.numbers.iter();
        if !numbers.all(|(at, number)| place.numbers[*at] + by * number > 0.0) {
            return false;
        }
        let mut matrices = change.matrices.iter();
        let is_inside = matrices.all(|(at, matrix)| {
            let mut there = place.matrices[*at];
            for (entry, slope) in there.iter_mut().zip(matrix) {
                *entry += by * slope;
            }
            is_positive(&there, self.rows[*at])
        });
        if is_inside {
            self.go(place, coordinate, by);
        }
        is_inside
    }

    /// Returns the distances to the borders along a coordinate, down and up; `None` if rounding put the place on a
    /// border.
    pub(super) fn ends(&self, place: &Place, coordinate: usize) -> Option<[f64; 2]> {
        let change = &self.along[coordinate];
        let (mut least, mut largest) = (0.0_f64, 0.0_f64);
        // The place is inside up to t with 1 + t λ > 0 for the relative changes λ.
        for (at, by) in &change.numbers {
            let number = place.numbers[*at];
            if number <= 0.0 {
                return None;
            }
            least = least.min(by / number);
            largest = largest.max(by / number);
        }
        for (at, by) in &change.matrices {
            let [low, high] = relative(&place.matrices[*at], by, self.rows[*at])?;
            least = least.min(low);
            largest = largest.max(high);
        }
        Some([(MARGIN - 1.0) / largest, (1.0 - MARGIN) / least.abs()])
    }
}

/// Returns whether a matrix is positive definite.
fn is_positive(matrix: &[f64; SIZE], rows: usize) -> bool {
    match rows {
        2 => root::<2>(matrix).is_some(),
        3 => root::<3>(matrix).is_some(),
        _ => root::<ROWS>(matrix).is_some(),
    }
}

/// Returns the least and the largest eigenvalue of a change relative to a matrix; `None` if this is not positive definite.
fn relative(matrix: &[f64; SIZE], change: &[f64; SIZE], rows: usize) -> Option<[f64; 2]> {
    match rows {
        2 => relative_of::<2>(matrix, change),
        3 => relative_of::<3>(matrix, change),
        _ => relative_of::<ROWS>(matrix, change),
    }
}

/// Returns the Cholesky factor of a matrix of N rows, with the inverses of its diagonal; `None` if it is not positive
/// definite.
fn root<const N: usize>(matrix: &[f64; SIZE]) -> Option<[[f64; N]; N]> {
    let mut factor = [[0.0; N]; N];
    for i in 0..N {
        for j in 0..=i {
            let mut rest = matrix[i * N + j];
            for (a, b) in factor[i].iter().zip(&factor[j]).take(j) {
                rest -= a * b;
            }
            if i != j {
                factor[i][j] = rest * factor[j][j];
            } else if rest > 0.0 {
                factor[i][i] = rest.sqrt().recip();
            } else {
                return None;
            }
        }
    }
    Some(factor)
}

fn relative_of<const N: usize>(matrix: &[f64; SIZE], change: &[f64; SIZE]) -> Option<[f64; 2]> {
    let factor = root::<N>(matrix)?;
    let mut half = [[0.0; N]; N];
    for (i, row) in half.iter_mut().enumerate() {
        row.copy_from_slice(&change[i * N..(i + 1) * N]);
    }
    // L⁻¹ D, then L⁻¹ (L⁻¹ D)ᵀ.
    for _ in 0..2 {
        for (i, by) in factor.iter().enumerate() {
            let (before, after) = half.split_at_mut(i);
            for (column, entry) in after[0].iter_mut().enumerate() {
                for (row, share) in before.iter().zip(by) {
                    *entry -= share * row[column];
                }
                *entry *= by[i];
            }
        }
        half = std::array::from_fn(|i| std::array::from_fn(|j| half[j][i]));
    }
    Some(extremes(half))
}

/// Returns the least and the largest eigenvalue of a symmetric matrix by rotations.
///
/// # Source
///
/// Golub and Van Loan, "Matrix computations", section 8.5, the cyclic Jacobi method.
fn extremes<const N: usize>(mut a: [[f64; N]; N]) -> [f64; 2] {
    for _ in 0..MAX_SWEEPS {
        let (mut beside, mut all) = (0.0, 0.0);
        for (i, row) in a.iter().enumerate() {
            all += row[i] * row[i];
            beside += row[..i].iter().map(|entry| entry * entry).sum::<f64>();
        }
        if beside <= NEGLIGIBLE * NEGLIGIBLE * all {
            break;
        }
        for p in 0..N {
            for q in p + 1..N {
                rotate(&mut a, p, q);
            }
        }
    }
    let diagonal = a.iter().enumerate().map(|(k, row)| row[k]);
    diagonal.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
        [low.min(value), high.max(value)]
    })
}

/// Makes an entry beside the diagonal zero.
fn rotate<const N: usize>(a: &mut [[f64; N]; N], p: usize, q: usize) {
    let entry = a[p][q];
    if entry.abs() <= f64::MIN_POSITIVE {
        return;
    }
    let tau = (a[q][q] - a[p][p]) / (2.0 * entry);
    let t = tau.signum() / (tau.abs() + (1.0 + tau * tau).sqrt());
    let c = (1.0 + t * t).sqrt().recip();
    let s = t * c;
    a[p][p] -= t * entry;
    a[q][q] += t * entry;
    a[p][q] = 0.0;
    a[q][p] = 0.0;
    for k in (0..N).filter(|k| *k != p && *k != q) {
        let (kp, kq) = (a[k][p], a[k][q]);
        let (new_p, new_q) = (c * kp - s * kq, s * kp + c * kq);
        a[k][p] = new_p;
        a[p][k] = new_p;
        a[k][q] = new_q;
        a[q][k] = new_q;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Entry;

    #[test]
    fn the_ends_are_where_a_matrix_stops_being_positive_definite() {
        // F = [[2 + x, 1, 0], [1, 3, y], [0, y, 1]] beside the number 4 − x.
        let entries = vec![
            (0, vec![Entry::at(0, 0, 1.0)]),
            (1, vec![Entry::at(1, 2, 1.0)]),
        ];
        let mut block = Block::new(3, entries);
        block.add_constant(
            &[
                Entry::at(0, 0, 2.0),
                Entry::at(0, 1, 1.0),
                Entry::at(1, 1, 3.0),
                Entry::at(2, 2, 1.0),
            ],
            1.0,
        );
        let blocks = [block, Block::scalar(4.0, [(0, -1.0)])];
        let directions = [vec![1.0, 0.0], vec![0.0, 1.0], vec![0.3, -0.8]];
        let borders = Borders::new(&blocks, &[0.1, 0.2], &directions);
        let place = borders.at(&[0.1, -0.3, 0.2]);
        for coordinate in 0..3 {
            let ends = borders.ends(&place, coordinate).unwrap();
            for end in ends {
                let at = |share: f64| {
                    let mut there = place.clone();
                    borders.go(&mut there, coordinate, share * end);
                    borders.contain(&there)
                };
                assert!(at(1.0) && !at(1.0 + 1e-6), "{coordinate} {ends:?}");
            }
        }
        let x = borders.ends(&place, 0).unwrap();
        assert!((x[1] - (4.0 - 0.26)).abs() < 1e-6, "{x:?}");
    }

    #[test]
    fn a_coordinate_without_border_has_no_end() {
        let blocks = [Block::scalar(1.0, [(0, 1.0)])];
        let borders = Borders::new(&blocks, &[0.0, 0.0], &[vec![1.0, 0.0], vec![0.0, 1.0]]);
        let place = borders.at(&[0.0, 0.0]);
        assert_eq!(
            borders.ends(&place, 1),
            Some([f64::NEG_INFINITY, f64::INFINITY])
        );
        let [low, high] = borders.ends(&place, 0).unwrap();
        assert!((low + 1.0).abs() < 1e-6 && high == f64::INFINITY);
    }
}
