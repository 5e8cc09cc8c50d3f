//! Convex programs with linear matrix inequalities, by a barrier method.
//!
//! ```text
//! minimise  ½ xᵀ P x − qᵀ x − Σ w log det F(x)    with every F(x) = F₀ + Σ xᵢ Fᵢ ≻ 0
//! ```
//!
//! Newton steps minimise the function plus `μ Σ (tr F / s − log det F)`, with μ falling until the gap
//! to the optimum, μ times the rows of all F, is small.
//!
//! # Source
//!
//! Boyd and Vandenberghe, "Convex optimization", chapter 11.

use sprung_core::linear::{dot, factor, solve};

/// Factor of μ from stage to stage.
const BARRIER_STEP: f64 = 0.15;

/// Maximum number of Newton steps per stage. A stage that ends before its minimum would return unknowns far from that of
/// the program. The metric of a refinement needs up to 340 steps, because the unknowns start far from its narrow valley.
const MAX_STEPS: usize = 400;

/// A stage ends when a step would lower the function by less than this multiple of μ, or by less than its rounding.
const SMALL_DECREASE: f64 = 1e-2;

/// Part of the expected decrease that a step must reach, and smallest step.
const SUFFICIENT: f64 = 0.1;
const SMALLEST_STEP: f64 = 1e-10;

/// Ridges of the scaled second derivatives, tried in turn. A step with one still lowers the function.
const RIDGES: [f64; 4] = [0.0, 1e-12, 1e-9, 1e-6];

/// Rounding of the function's value, relative to its terms.
const ROUNDING: f64 = 1e-14;

/// Largest number of rows of a [`Block`].
pub const ROWS: usize = 4;

/// An entry of a symmetric matrix. Entries above the diagonal also represent those below it.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// Row.
    pub row: usize,
    /// Column.
    pub column: usize,
    /// Factor.
    pub by: f64,
}

impl Entry {
    /// Returns an entry.
    #[must_use]
    pub const fn at(row: usize, column: usize, by: f64) -> Self {
        Self { row, column, by }
    }
}

/// A symmetric matrix that must be positive definite.
#[derive(Clone, Debug)]
pub struct Block {
    /// Number of rows, at most `ROWS`.
    pub rows: usize,
    /// Constant part, \[rows × rows\].
    pub(crate) constant: [f64; ROWS * ROWS],
    /// Change of the matrix by each unknown: index of the unknown, and entries.
    pub terms: Vec<(usize, Vec<Entry>)>,
    /// Weight of `−log det F` in the function itself.
    pub entropy: f64,
    /// Size s of the matrix in the barrier, which keeps otherwise undetermined unknowns finite.
    pub(crate) size: f64,
}

impl Block {
    /// Returns a block without a constant part, without a size, and not in the function itself.
    #[must_use]
    pub fn new(rows: usize, terms: Vec<(usize, Vec<Entry>)>) -> Self {
        Self {
            rows,
            constant: [0.0; ROWS * ROWS],
            terms,
            entropy: 0.0,
            size: f64::INFINITY,
        }
    }

    /// Returns a number that must be positive.
    pub fn scalar(constant: f64, terms: impl IntoIterator<Item = (usize, f64)>) -> Self {
        let terms = terms
            .into_iter()
            .map(|(x, by)| (x, vec![Entry::at(0, 0, by)]));
        let mut block = Self::new(1, terms.collect());
        block.constant[0] = constant;
        block
    }

    /// Adds a multiple of entries to the constant part.
    pub fn add_constant(&mut self, entries: &[Entry], by: f64) {
        add_entries(&mut self.constant, self.rows, entries, by);
    }

    /// Returns the matrix, \[rows × rows\], in the first entries.
    #[must_use]
    pub fn at(&self, x: &[f64]) -> [f64; ROWS * ROWS] {
        let mut matrix = self.constant;
        for (unknown, entries) in &self.terms {
            add_entries(&mut matrix, self.rows, entries, x[*unknown]);
        }
        matrix
    }

    /// Returns the inverse of the matrix; `None` if it is not positive definite.
    #[must_use]
    pub fn inverse(&self, x: &[f64]) -> Option<[f64; ROWS * ROWS]> {
        inverse(&self.at(x), self.rows)
    }

    fn trace(&self, matrix: &[f64; ROWS * ROWS]) -> f64 {
        (0..self.rows).map(|k| matrix[k * (self.rows + 1)]).sum()
    }
}

fn add_entries(matrix: &mut [f64; ROWS * ROWS], rows: usize, entries: &[Entry], by: f64) {
    for &Entry {
        row,
        column,
        by: share,
    } in entries
    {
        matrix[row * rows + column] += by * share;
        if row != column {
            matrix[column * rows + row] += by * share;
        }
    }
}

/// A convex program.
#[derive(Clone, Debug)]
pub struct Program {
    /// P, \[unknowns × unknowns\].
    pub quadratic: Vec<f64>,
    /// q, \[unknowns\].
    pub linear: Vec<f64>,
    /// The matrices F.
    pub blocks: Vec<Block>,
}

/// Reason why a program has no solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoSolution {
    /// No x makes all matrices positive definite; this block is the farthest from it.
    Contradiction(usize),
    /// A Newton step has no solution.
    Singular,
}

/// Value of the function with its derivatives.
struct Point {
    value: f64,
    gradient: Vec<f64>,
    /// \[unknowns × unknowns\].
    hessian: Vec<f64>,
}

impl Program {
    /// Returns the unknowns that minimise the function.
    ///
    /// - `start`: unknowns; if they do not make all matrices positive definite, others that do are
    ///   searched first.
    /// - `gap`: largest difference of the function from its minimum.
    ///
    /// # Errors
    ///
    /// [`NoSolution`].
    pub fn minimise(&self, start: &[f64], gap: f64) -> Result<Vec<f64>, NoSolution> {
        let mut x = self.feasible(start)?;
        let last = gap / self.rows().max(1) as f64;
        // A large μ makes the way short, but without a size, otherwise undetermined unknowns grow with it.
        let is_bounded = self.blocks.iter().all(|block| block.size.is_finite());
        let value = self.value(&x, 0.0).filter(|_| is_bounded);
        let first = value.map_or(1.0, |value| f64::max(1.0, 0.1 * value.abs()));
        self.follow(&mut x, [first.max(last), last])?;
        Ok(x)
    }

    /// Returns the rows of all matrices together. A point of the central path is farther from the minimum by at most
    /// their number times μ.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.blocks.iter().map(|block| block.rows).sum()
    }

    /// Moves unknowns along the central path, from one μ to a smaller one.
    ///
    /// - `x`: unknowns that make all matrices positive definite.
    ///
    /// # Errors
    ///
    /// [`NoSolution::Singular`].
    pub fn follow(&self, x: &mut [f64], [mut barrier, last]: [f64; 2]) -> Result<(), NoSolution> {
        loop {
            for _ in 0..MAX_STEPS {
                if !self.step(x, barrier).ok_or(NoSolution::Singular)? {
                    break;
                }
            }
            if barrier <= last {
                return Ok(());
            }
            barrier = (barrier * BARRIER_STEP).max(last);
        }
    }

    /// Returns whether unknowns make all matrices positive definite.
    #[must_use]
    pub fn is_inside(&self, x: &[f64]) -> bool {
        self.blocks.iter().all(|block| block.inverse(x).is_some())
    }

    /// Returns the second derivatives of the function without the barrier, \[unknowns × unknowns\].
    #[must_use]
    pub fn hessian(&self, x: &[f64]) -> Option<Vec<f64>> {
        Some(self.point(x, 0.0)?.hessian)
    }

    /// Returns the second derivatives of the function with the barrier, \[unknowns × unknowns\].
    #[must_use]
    pub fn hessian_with_barrier(&self, x: &[f64], barrier: f64) -> Option<Vec<f64>> {
        Some(self.point(x, barrier)?.hessian)
    }

    /// Returns unknowns that make all matrices positive definite, near `start`.
    fn feasible(&self, start: &[f64]) -> Result<Vec<f64>, NoSolution> {
        if self.value(start, 0.0).is_some() {
            return Ok(start.to_vec());
        }
        // One more unknown t widens all matrices by t times their size; t is minimised.
        let n = start.len();
        let width = |block: &Block| -> f64 {
            let matrix = block.at(start);
            let largest = matrix
                .iter()
                .fold(0.0_f64, |max, entry| max.max(entry.abs()));
            largest.max(1e-6)
        };
        let blocks = self.blocks.iter().map(|block| {
            let mut wider = block.clone();
            let width = width(block);
            let entries = (0..block.rows).map(|k| Entry::at(k, k, width)).collect();
            wider.terms.push((n, entries));
            wider.entropy = 0.0;
            wider
        });
        let mut quadratic = vec![0.0; (n + 1) * (n + 1)];
        for (i, value) in start.iter().enumerate() {
            quadratic[i * (n + 2)] = 1e-10 / value.powi(2).max(1e-6);
        }
        let mut linear: Vec<f64> = (start.iter().enumerate())
            .map(|(i, value)| quadratic[i * (n + 2)] * value)
            .collect();
        linear.push(-1.0);
        let wide = Self {
            quadratic,
            linear,
            blocks: blocks.collect(),
        };
        let mut x = start.to_vec();
        x.push(2.0 * ROWS as f64);
        let mut barrier = 1.0;
        while barrier > 1e-9 {
            for _ in 0..MAX_STEPS {
                let goes_on = wide.step(&mut x, barrier).ok_or(NoSolution::Singular)?;
                if self.value(&x[..n], 0.0).is_some() {
                    x.truncate(n);
                    return Ok(x);
                }
                if !goes_on {
                    break;
                }
            }
            barrier *= BARRIER_STEP;
        }
        let shares = self.blocks.iter().map(|block| {
            let matrix = block.at(&x[..n]);
            least_share(&matrix, block.rows, width(block))
        });
        let worst = (shares.enumerate()).min_by(|a, b| a.1.total_cmp(&b.1));
        Err(worst.map_or(NoSolution::Singular, |(at, _)| {
            NoSolution::Contradiction(at)
        }))
    }

    /// Makes a Newton step. Returns whether another step is useful, `None` if there is no step.
    fn step(&self, x: &mut [f64], barrier: f64) -> Option<bool> {
        let n = x.len();
        let here = self.point(x, barrier)?;
        let scale: Vec<f64> = (0..n)
            .map(|i| here.hessian[i * (n + 1)].sqrt().recip())
            .collect();
        // Only the lower triangle is read.
        let scaled = |ridge: f64| -> Vec<f64> {
            let mut scaled = vec![0.0; n * n];
            for i in 0..n {
                let (to, from) = (&mut scaled[i * n..=i * n + i], &here.hessian[i * n..]);
                for ((to, from), by) in to.iter_mut().zip(from).zip(&scale) {
                    *to = from * scale[i] * by;
                }
                to[i] += ridge;
            }
            scaled
        };
        let factors = RIDGES.iter().find_map(|ridge| {
            let mut factors = scaled(*ridge);
            factor(&mut factors, n).then_some(factors)
        })?;
        let mut by: Vec<f64> = (here.gradient.iter().zip(&scale))
            .map(|(derivative, scale)| -derivative * scale)
            .collect();
        solve(&factors, &mut by);
        let mut decrease = 0.0;
        for ((by, scale), derivative) in by.iter_mut().zip(&scale).zip(&here.gradient) {
            *by *= scale;
            decrease -= derivative * *by;
        }
        if decrease.is_nan() {
            return None;
        }
        let slack = ROUNDING * (here.value.abs() + dot(&self.linear, x).abs());
        if decrease < slack.max(SMALL_DECREASE * barrier) {
            return Some(false);
        }
        let mut length = 1.0;
        while length > SMALLEST_STEP {
            let there: Vec<f64> = x.iter().zip(&by).map(|(x, by)| x + length * by).collect();
            let value = self.value(&there, barrier);
            let limit = here.value - SUFFICIENT * length * decrease + slack;
            if let Some(value) = value.filter(|value| *value <= limit) {
                x.copy_from_slice(&there);
                return Some(here.value - value > slack);
            }
            length *= 0.5;
        }
        Some(false)
    }

    /// Returns the value of the function with the barrier; `None` if a matrix is not positive definite.
    pub(crate) fn value(&self, x: &[f64], barrier: f64) -> Option<f64> {
        let n = x.len();
        let mut value = -dot(&self.linear, x);
        for (row, entry) in self.quadratic.chunks(n).zip(x) {
            value += 0.5 * entry * dot(row, x);
        }
        for block in &self.blocks {
            let matrix = block.at(x);
            let mut factors = matrix;
            if !factor(&mut factors, block.rows) {
                return None;
            }
            let diagonal = (0..block.rows).map(|k| factors[k * (block.rows + 1)].ln());
            let log = -diagonal.sum::<f64>();
            value -= (block.entropy + barrier) * log;
            value += barrier * block.trace(&matrix) / block.size;
        }
        Some(value)
    }

    fn point(&self, x: &[f64], barrier: f64) -> Option<Point> {
        let n = x.len();
        let mut hessian = self.quadratic.clone();
        let mut gradient: Vec<f64> = (self.quadratic.chunks(n).zip(&self.linear))
            .map(|(row, linear)| dot(row, x) - linear)
            .collect();
        for block in &self.blocks {
            let weight = block.entropy + barrier;
            if weight == 0.0 {
                continue;
            }
            let inverse = block.inverse(x)?;
            let slopes: Vec<[f64; ROWS * ROWS]> = (block.terms.iter())
                .map(|(_, entries)| product(&inverse, block.rows, entries))
                .collect();
            for ((i, entries), slope) in block.terms.iter().zip(&slopes) {
                let trace: f64 = (entries.iter())
                    .filter(|entry| entry.row == entry.column)
                    .map(|entry| entry.by)
                    .sum();
                gradient[*i] -= weight * block.trace(slope) - barrier * trace / block.size;
                for ((j, _), other) in block.terms.iter().zip(&slopes) {
                    hessian[i * n + j] += weight * of_product(slope, other, block.rows);
                }
            }
        }
        Some(Point {
            value: self.value(x, barrier)?,
            gradient,
            hessian,
        })
    }
}

/// Returns the inverse of a positive definite matrix.
fn inverse(matrix: &[f64; ROWS * ROWS], rows: usize) -> Option<[f64; ROWS * ROWS]> {
    let mut factors = *matrix;
    if !factor(&mut factors, rows) {
        return None;
    }
    let mut inverse = [0.0; ROWS * ROWS];
    for (k, column) in inverse.chunks_mut(rows).take(rows).enumerate() {
        column[k] = 1.0;
        solve(&factors[..rows * rows], column);
    }
    Some(inverse)
}

/// Returns the product of a matrix and a symmetric matrix with few entries.
fn product(left: &[f64; ROWS * ROWS], rows: usize, entries: &[Entry]) -> [f64; ROWS * ROWS] {
    let mut product = [0.0; ROWS * ROWS];
    for &Entry { row, column, by } in entries {
        for i in 0..rows {
            product[i * rows + column] += by * left[i * rows + row];
            if row != column {
                product[i * rows + row] += by * left[i * rows + column];
            }
        }
    }
    product
}

/// Returns the trace of the product of two matrices.
fn of_product(a: &[f64; ROWS * ROWS], b: &[f64; ROWS * ROWS], rows: usize) -> f64 {
    (0..rows * rows)
        .map(|k| a[k] * b[k % rows * rows + k / rows])
        .sum()
}

/// Returns the share of its size by which a matrix may shrink until it is not positive definite;
/// negative if it must grow.
fn least_share(matrix: &[f64; ROWS * ROWS], rows: usize, size: f64) -> f64 {
    let is_positive = |share: f64| {
        let mut smaller = *matrix;
        for k in 0..rows {
            smaller[k * (rows + 1)] -= share * size;
        }
        factor(&mut smaller, rows)
    };
    let (mut low, mut high) = (-2.0 * ROWS as f64, 1.0);
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if is_positive(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::second_moments;

    #[test]
    fn a_point_outside_is_projected_on_the_cone() {
        // The nearest positive semidefinite matrix to diag(1, -1) is diag(1, 0), at distance ½.
        let block = Block::new(
            2,
            vec![
                (0, vec![Entry::at(0, 0, 1.0)]),
                (1, vec![Entry::at(0, 1, 1.0)]),
                (2, vec![Entry::at(1, 1, 1.0)]),
            ],
        );
        let program = Program {
            quadratic: vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            linear: vec![1.0, 0.0, -1.0],
            blocks: vec![block],
        };
        let x = program.minimise(&[0.5, 0.0, 0.5], 1e-10).unwrap();
        assert!((program.value(&x, 0.0).unwrap() + 0.5).abs() < 1e-9);
        assert!((x[0] - 1.0).abs() < 1e-4 && x[1].abs() < 1e-4 && x[2].abs() < 1e-4);
    }

    #[test]
    fn a_start_outside_moves_inside() {
        let program = Program {
            quadratic: vec![1.0],
            linear: vec![0.0],
            blocks: vec![
                Block::scalar(-3.0, [(0, 1.0)]),
                Block::scalar(4.0, [(0, -1.0)]),
            ],
        };
        let x = program.minimise(&[0.0], 1e-9).unwrap();
        assert!((x[0] - 3.0).abs() < 1e-8 && x[0] > 3.0, "{x:?}");
    }

    #[test]
    fn bounds_that_exclude_each_other_are_a_contradiction() {
        let program = Program {
            quadratic: vec![1.0],
            linear: vec![0.0],
            blocks: vec![
                Block::scalar(-3.0, [(0, 1.0)]),
                Block::scalar(2.0, [(0, -1.0)]),
            ],
        };
        let found = program.minimise(&[0.0], 1e-9);
        assert!(
            matches!(found, Err(NoSolution::Contradiction(_))),
            "{found:?}"
        );
    }

    #[test]
    fn entropy_alone_has_its_minimum_at_the_prior() {
        // tr(F / 2) − log det F has its minimum at F = 2.
        let mut block = Block::scalar(0.0, [(0, 1.0)]);
        block.entropy = 1.0;
        let program = Program {
            quadratic: vec![0.0],
            linear: vec![-0.5],
            blocks: vec![block],
        };
        let x = program.minimise(&[7.0], 1e-12).unwrap();
        assert!((x[0] - 2.0).abs() < 1e-5, "{x:?}");
        let hessian = program.hessian(&x).unwrap();
        assert!((hessian[0] - 0.25).abs() < 1e-5, "{hessian:?}");
    }

    /// A least-squares problem of four bodies, and its optima by an independent solver.
    #[derive(serde::Deserialize)]
    struct Golden {
        a: Vec<Vec<f64>>,
        b: Vec<f64>,
        prior: Vec<f64>,
        inverse: [[f64; ROWS]; ROWS],
        optima: Vec<Optimum>,
    }

    #[derive(serde::Deserialize)]
    struct Optimum {
        entropy: f64,
        optimum: f64,
    }

    #[test]
    fn an_independent_solver_finds_the_same_optimum() {
        let golden = include_str!("convex/possible_bodies.json");
        let golden: Golden = serde_json::from_str(golden).unwrap();
        let n = golden.prior.len();
        for wanted in &golden.optima {
            let mut program = Program {
                quadratic: vec![0.0; n * n],
                linear: golden.prior.clone(),
                blocks: (0..n)
                    .step_by(10)
                    .map(|first| second_moments(|k| Ok(first + k)))
                    .collect(),
            };
            for i in 0..n {
                program.quadratic[i * (n + 1)] = 1.0;
            }
            for (row, b) in golden.a.iter().zip(&golden.b) {
                for i in 0..n {
                    program.linear[i] += 100.0 * row[i] * b;
                    for j in 0..n {
                        program.quadratic[i * n + j] += 100.0 * row[i] * row[j];
                    }
                }
            }
            for block in &mut program.blocks {
                block.entropy = wanted.entropy;
                for (unknown, entries) in &block.terms {
                    for &Entry { row, column, by } in entries {
                        let both = if row == column { 1.0 } else { 2.0 };
                        program.linear[*unknown] -=
                            wanted.entropy * both * by * golden.inverse[row][column];
                    }
                }
            }
            let x = program.minimise(&golden.prior, 1e-9).unwrap();
            let constant: f64 = golden.b.iter().map(|b| 50.0 * b * b).sum::<f64>()
                + golden
                    .prior
                    .iter()
                    .map(|entry| 0.5 * entry * entry)
                    .sum::<f64>();
            let found = program.value(&x, 0.0).unwrap() + constant;
            assert!(
                (found / wanted.optimum - 1.0).abs() < 1e-8,
                "{found} and {}",
                wanted.optimum
            );
        }
    }
}
