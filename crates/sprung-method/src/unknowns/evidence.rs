//! Normal equations of consecutive parts of a log, with columns for parameters and unknowns.

use faer::Mat;
use sprung_core::linear::{factor, invert, solve};

use super::rows::Row;
use crate::fit::{RIDGE, non_negative};

/// Number of consecutive parts; each is predicted by a fit of the others.
pub(super) const PARTS: usize = 8;

/// Products of the columns of one row, part by part.
struct RowProducts {
    /// `None` for innovations, which concern all joints.
    joint: Option<usize>,
    columns: Vec<usize>,
    /// \[(columns + 1) × (columns + 1)\] of each part, and their sum.
    parts: Vec<Mat<f64>>,
    all: Mat<f64>,
}

impl RowProducts {
    fn new(joint: Option<usize>, columns: Vec<usize>, parts: Vec<Mat<f64>>) -> Self {
        let size = columns.len() + 1;
        let mut all = Mat::zeros(size, size);
        for part in &parts {
            all += part;
        }
        Self {
            joint,
            columns,
            parts,
            all,
        }
    }
}

/// What a set of columns explains.
pub(super) struct HeldOut {
    /// Squared residual of each row in each part, \[parts\]\[rows\].
    pub(super) squares: Vec<Vec<f64>>,
    /// Values without each part, \[parts\]\[columns\].
    pub(super) values: Vec<Vec<f64>>,
}

impl HeldOut {
    /// Returns the squares of some rows in some parts.
    pub(super) fn sum(&self, rows: &[usize], parts: &[usize]) -> f64 {
        parts
            .iter()
            .map(|&part| rows.iter().map(|&row| self.squares[part][row]).sum::<f64>())
            .sum()
    }

    /// Returns mean and jackknife standard error of a value over some parts.
    pub(super) fn mean_and_error(&self, column: usize, parts: &[usize]) -> (f64, f64) {
        let values = parts.iter().map(|&part| self.values[part][column]);
        mean_and_error(&values.collect::<Vec<f64>>())
    }
}

/// Returns mean and jackknife standard error of a value without each part.
pub(super) fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, ((count - 1.0) / count * squares).sqrt())
}

/// The normal equations.
pub(super) struct Evidence {
    rows: Vec<RowProducts>,
    pub(super) free: usize,
    pub(super) columns: usize,
    /// Sum over all rows and parts, \[(columns + 1)²\].
    all: Mat<f64>,
    /// Sums of all parts but one.
    others: Vec<Mat<f64>>,
    /// Length of each column.
    lengths: Vec<f64>,
    /// Weight of each row, and what its prior adds to the diagonal and, with a size that is applied, to the right-hand side.
    pub(super) weights: Vec<f64>,
    ridge: Vec<f64>,
    pull: Vec<f64>,
    /// Whether a column's value must not be negative, and whether it is a stiffness.
    positive: Vec<bool>,
    stiff: Vec<bool>,
    /// Whether it consists of white innovations, so that the significance of an unknown decides and not what it explains.
    pub(super) is_white: bool,
}

/// Which values a parameter can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sign {
    Any,
    NotNegative,
    /// The same, and with the value zero the positions of a joint are not in its equations.
    Stiffness,
}

/// Prior of an unknown.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prior {
    /// Standard deviation of its size.
    pub(super) scale: f64,
    /// Size that is applied already; the column's value is added to it.
    pub(super) applied: f64,
    pub(super) is_positive: bool,
}

/// A normal prior of a value that follows every unknown.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pull {
    /// Index of the value.
    pub(crate) at: usize,
    /// Inverse variance.
    pub(crate) weight: f64,
    /// Distance of the value from the mean.
    pub(crate) away: f64,
}

fn products(row: &Row) -> RowProducts {
    let samples = row.values.nrows();
    let width = row.values.ncols();
    let weighted = Mat::from_fn(samples, width, |i, j| row.reliable[i] * row.values[(i, j)]);
    let parts = (0..PARTS)
        .map(|part| {
            let (from, to) = (part * samples / PARTS, (part + 1) * samples / PARTS);
            let block = weighted.as_ref().subrows(from, to - from);
            block.transpose() * block
        })
        .collect();
    RowProducts::new(Some(row.joint), row.columns.clone(), parts)
}

impl Evidence {
    /// - `signs`: of the free parameters.
    /// - `priors`: of the unknowns.
    /// - `weights`: of the rows; `None` to take them from what remains when everything acts.
    /// - `repeats`: number of neighbouring samples that say the same.
    pub(super) fn new(
        rows: &[Row],
        signs: &[Sign],
        priors: &[Prior],
        weights: Option<Vec<f64>>,
        repeats: f64,
    ) -> Self {
        let products: Vec<RowProducts> = rows.iter().map(products).collect();
        let free = signs.len();
        let columns = free + priors.len();
        let positive = signs.iter().map(|sign| *sign != Sign::Any);
        let positive = positive.chain(priors.iter().map(|prior| prior.is_positive));
        let mut stiff: Vec<bool> = signs.iter().map(|sign| *sign == Sign::Stiffness).collect();
        stiff.resize(columns, false);
        let mut evidence = Self {
            free,
            columns,
            all: Mat::zeros(columns + 1, columns + 1),
            others: Vec::new(),
            lengths: Vec::new(),
            weights: Vec::new(),
            ridge: vec![0.0; columns],
            pull: vec![0.0; columns],
            positive: positive.collect(),
            stiff,
            is_white: false,
            rows: products,
        };
        let given = weights.unwrap_or_else(|| {
            let torque: Vec<f64> = rows.iter().map(row_rms).collect();
            let by_torque: Vec<f64> = torque.iter().map(|rms| rms.recip()).collect();
            evidence.weigh_all(&by_torque);
            evidence.set_priors(priors, 0.01 * repeats);
            let every: Vec<usize> = (0..columns).collect();
            let x = evidence.unsigned(&evidence.all, &every);
            let left = |(r, row): (usize, &RowProducts)| {
                let all = quadratic(&row.all, &row.columns, &x);
                let count: f64 = rows[r].reliable.iter().map(|w| w * w).sum();
                (all.max(0.0) / count.max(1.0))
                    .sqrt()
                    .max(LEAST_RESIDUAL * torque[r])
                    .recip()
            };
            evidence.rows.iter().enumerate().map(left).collect()
        });
        evidence.weigh(given);
        evidence.set_priors(priors, repeats);
        evidence
    }

    /// Returns the evidence of whitened innovations.
    ///
    /// - `parts`: products of the columns and of the innovations of each part.
    /// - `pulls`: priors of the free parameters; `priors`: of the unknowns.
    pub(super) fn of_innovations(parts: Vec<Mat<f64>>, pulls: &[Pull], priors: &[Prior]) -> Self {
        let columns = parts.first().map_or(0, |part| part.ncols() - 1);
        let free = columns - priors.len();
        let mut positive = vec![false; free];
        positive.extend(priors.iter().map(|prior| prior.is_positive));
        let mut evidence = Self {
            free,
            columns,
            all: Mat::zeros(0, 0),
            others: Vec::new(),
            lengths: Vec::new(),
            weights: Vec::new(),
            ridge: vec![0.0; columns],
            pull: vec![0.0; columns],
            positive,
            stiff: vec![false; columns],
            is_white: true,
            rows: vec![RowProducts::new(None, (0..columns).collect(), parts)],
        };
        evidence.weigh(vec![1.0]);
        evidence.set_priors(priors, 1.0);
        for pull in pulls {
            evidence.ridge[pull.at] = pull.weight;
            evidence.pull[pull.at] = pull.weight * pull.away;
        }
        evidence
    }

    fn weigh(&mut self, weights: Vec<f64>) {
        self.weigh_all(&weights);
        let without = |part: usize| &self.all - self.sum(&weights, |row| &row.parts[part]);
        self.others = (0..PARTS).map(without).collect();
        self.weights = weights;
    }

    /// Sums all parts of weighted rows.
    fn weigh_all(&mut self, weights: &[f64]) {
        self.all = self.sum(weights, |row| &row.all);
        let rhs = self.all[(self.columns, self.columns)].sqrt();
        self.lengths = (0..self.columns)
            .map(|i| self.all[(i, i)].max(0.0).sqrt() + 1e-12 * rhs)
            .collect();
    }

    /// Returns the sum of products of weighted rows.
    fn sum(&self, weights: &[f64], products: impl Fn(&RowProducts) -> &Mat<f64>) -> Mat<f64> {
        let size = self.columns + 1;
        let mut sum = Mat::zeros(size, size);
        for (row, weight) in self.rows.iter().zip(weights) {
            let products = products(row);
            let places: Vec<usize> = row.columns.iter().copied().chain([self.columns]).collect();
            for (j, &column) in places.iter().enumerate() {
                let (from, to) = (products.col_as_slice(j), sum.col_as_slice_mut(column));
                for (&place, value) in places.iter().zip(from) {
                    to[place] += weight * weight * value;
                }
            }
        }
        sum
    }

    fn set_priors(&mut self, priors: &[Prior], repeats: f64) {
        for (k, prior) in priors.iter().enumerate() {
            let at = self.free + k;
            self.ridge[at] = repeats / (prior.scale * prior.scale);
            self.pull[at] = prior.applied * self.ridge[at];
        }
    }

    /// Returns the fit of some columns with values of any sign; the others are zero.
    fn unsigned(&self, normal: &Mat<f64>, columns: &[usize]) -> Vec<f64> {
        let mut values = self.target(normal, columns);
        match self.factored(normal, columns, true) {
            Some(factors) => solve(&factors, &mut values),
            None => values.fill(0.0),
        }
        let mut x = vec![0.0; self.columns];
        for (&column, value) in columns.iter().zip(values) {
            x[column] = value / self.lengths[column];
        }
        x
    }

    /// Returns the standard error of each value if values may have any sign: the larger one of the jackknife over eight parts, which
    /// is often too small by chance, and of the weighted residual, \[columns\].
    ///
    /// - `repeats`: number of neighbouring samples that say the same.
    pub(super) fn unsigned_errors(&self, columns: &[usize], repeats: f64) -> Vec<f64> {
        let without: Vec<Vec<f64>> = (self.others.iter())
            .map(|normal| self.unsigned(normal, columns))
            .collect();
        let jackknife = |column: usize| {
            let values: Vec<f64> = without.iter().map(|x| x[column]).collect();
            mean_and_error(&values).1
        };
        let mut errors: Vec<f64> = (0..self.columns).map(jackknife).collect();
        let Some(factors) = self.factored(&self.all, columns, true) else {
            return errors;
        };
        let n = columns.len();
        let mut inverse = vec![0.0; n * n];
        invert(&factors, n, &mut inverse);
        for (i, &column) in columns.iter().enumerate() {
            let variance = repeats * inverse[i * n + i].max(0.0);
            errors[column] = errors[column].max(variance.sqrt() / self.lengths[column]);
        }
        errors
    }

    /// Returns how each value of some columns changes with that of one of them, \[columns\].
    pub(super) fn slopes(&self, columns: &[usize], of: usize) -> Vec<f64> {
        let others: Vec<usize> = columns.iter().copied().filter(|&i| i != of).collect();
        let mut slopes = vec![0.0; self.columns];
        let mut values = self.against(&self.all, &others, of);
        if let Some(factors) = self.factored(&self.all, &others, true) {
            solve(&factors, &mut values);
            for (&column, value) in others.iter().zip(values) {
                slopes[column] = -value * self.lengths[of] / self.lengths[column];
            }
        }
        slopes
    }

    /// Least squares with priors of some columns; the others are zero or fixed. Values that must not be negative are not.
    ///
    /// - `near`: values of a fit of nearly the same equations.
    fn solve(
        &self,
        normal: &Mat<f64>,
        chosen: &[usize],
        fixed: Option<(usize, f64)>,
        near: Option<&[f64]>,
    ) -> Vec<f64> {
        let n = chosen.len();
        let unit = |i: usize| self.lengths[chosen[i]];
        let mut matrix = vec![0.0; n * n];
        let mut rhs = vec![0.0; n];
        for (i, &row) in chosen.iter().enumerate() {
            for (j, &column) in chosen.iter().enumerate() {
                matrix[i * n + j] = normal[(row, column)] / (unit(i) * unit(j));
            }
            matrix[i * n + i] += RIDGE + self.ridge[row] / unit(i).powi(2);
            let known = fixed.map_or(0.0, |(at, value)| normal[(row, at)] * value);
            rhs[i] = (normal[(row, self.columns)] - known - self.pull[row]) / unit(i);
        }
        let positive: Vec<bool> = (chosen.iter())
            .map(|&column| self.positive[column] && self.pull[column] == 0.0)
            .collect();
        let mut x = vec![0.0; self.columns];
        if let Some((at, value)) = fixed {
            x[at] = value;
        }
        let is_free = |i: &usize| near.is_none_or(|near| !positive[*i] || near[chosen[*i]] != 0.0);
        let free = (0..n).filter(is_free).collect();
        for (i, value) in non_negative(&matrix, &rhs, &positive, free)
            .into_iter()
            .enumerate()
        {
            x[chosen[i]] = value / unit(i);
        }
        x
    }

    /// Returns the fit of all parts.
    pub(super) fn fit(&self, chosen: &[usize]) -> Vec<f64> {
        self.solve(&self.all, chosen, None, None)
    }

    /// Returns the fits without each part and what they leave of it.
    pub(super) fn held_out(&self, chosen: &[usize], fixed: Option<(usize, f64)>) -> HeldOut {
        let (mut squares, mut values) = (Vec::new(), Vec::new());
        let whole = self.solve(&self.all, chosen, fixed, None);
        for (k, others) in self.others.iter().enumerate() {
            let x = self.solve(others, chosen, fixed, Some(&whole));
            squares.push(self.left(k, &x));
            values.push(x);
        }
        HeldOut { squares, values }
    }

    /// Returns the weighted squared residual of each row in a part.
    fn left(&self, part: usize, x: &[f64]) -> Vec<f64> {
        (self.rows.iter().zip(&self.weights))
            .map(|(row, weight)| {
                weight * weight * quadratic(&row.parts[part], &row.columns, x).max(0.0)
            })
            .collect()
    }

    /// Returns the fits of a set of columns, to which single columns can be added quickly.
    pub(super) fn fits(&self, chosen: &[usize]) -> Fits<'_> {
        let whole = self.fit(chosen);
        let of = |normal: &Mat<f64>| {
            let x = self.solve(normal, chosen, None, Some(&whole));
            let active: Vec<usize> = chosen
                .iter()
                .copied()
                .filter(|&i| x[i] != 0.0 || !self.positive[i] || self.stiff[i])
                .collect();
            let factors = self.factored(normal, &active, true);
            // A wrong position may have driven a stiffness to zero, so that no error of this position would seem to matter.
            let is_stuck = active.iter().any(|&i| self.stiff[i] && x[i] == 0.0);
            let x = match &factors {
                Some(factors) if is_stuck => {
                    let mut x = self.target(normal, &active);
                    solve(factors, &mut x);
                    x
                }
                _ => active.iter().map(|&i| x[i] * self.lengths[i]).collect(),
            };
            Fit { active, x, factors }
        };
        Fits {
            evidence: self,
            without: self.others.iter().map(of).collect(),
            whole: Directions {
                columns: chosen.to_vec(),
                factors: self.factored(&self.all, chosen, false),
            },
        }
    }

    /// Returns the factors of the normal equations of some unit columns.
    fn factored(&self, normal: &Mat<f64>, chosen: &[usize], with_priors: bool) -> Option<Vec<f64>> {
        let n = chosen.len();
        let mut matrix = vec![0.0; n * n];
        for (i, &row) in chosen.iter().enumerate() {
            for (j, &other) in chosen[..=i].iter().enumerate() {
                matrix[i * n + j] =
                    normal[(row, other)] / (self.lengths[row] * self.lengths[other]);
            }
            matrix[i * n + i] += RIDGE;
            if with_priors {
                matrix[i * n + i] += self.ridge[row] / (self.lengths[row] * self.lengths[row]);
            }
        }
        factor(&mut matrix, n).then_some(matrix)
    }

    /// Returns the right-hand side of the normal equations of some unit columns.
    fn target(&self, normal: &Mat<f64>, columns: &[usize]) -> Vec<f64> {
        let mut target = self.against(normal, columns, self.columns);
        for (target, &i) in target.iter_mut().zip(columns) {
            *target -= self.pull[i] / self.lengths[i];
        }
        target
    }

    /// Returns the products of some unit columns with another.
    fn against(&self, normal: &Mat<f64>, columns: &[usize], other: usize) -> Vec<f64> {
        let length = if other == self.columns {
            1.0
        } else {
            self.lengths[other]
        };
        columns
            .iter()
            .map(|&i| normal[(i, other)] / (self.lengths[i] * length))
            .collect()
    }

    /// Returns what single columns have beyond some columns.
    pub(super) fn directions(&self, columns: &[usize]) -> Directions {
        Directions {
            columns: columns.to_vec(),
            factors: self.factored(&self.all, columns, false),
        }
    }

    /// Returns the fall of the held-out squares by one of some columns, relative to them.
    pub(super) fn gain_of(
        &self,
        column: usize,
        columns: &[usize],
        (with, parts): (&HeldOut, &[usize]),
    ) -> f64 {
        let rest: Vec<usize> = columns.iter().copied().filter(|c| *c != column).collect();
        let rows: Vec<usize> = (0..self.rows.len()).collect();
        let before = self.held_out(&rest, None).sum(&rows, parts);
        ((before - with.sum(&rows, parts)) / before.max(f64::MIN_POSITIVE)).max(0.0)
    }

    /// Returns the rows of a joint.
    pub(super) fn rows_of(&self, joint: usize) -> Vec<usize> {
        (0..self.rows.len())
            .filter(|&row| self.rows[row].joint.is_none_or(|of| of == joint))
            .collect()
    }

    /// Returns the weighted squares of a row's torque.
    pub(super) fn torque_squares(&self, row: usize) -> f64 {
        let last = self.rows[row].columns.len();
        self.weights[row] * self.weights[row] * self.rows[row].all[(last, last)]
    }

    /// Returns the part of the rows' torques that some columns leave on held-out parts (root mean square over the rows).
    pub(super) fn unexplained(&self, columns: &[usize]) -> f64 {
        let held_out = self.held_out(columns, None);
        let parts: Vec<usize> = (0..PARTS).collect();
        let squares: f64 = (0..self.row_count())
            .map(|row| {
                let torque = self.torque_squares(row).max(f64::MIN_POSITIVE);
                held_out.sum(&[row], &parts) / torque
            })
            .sum();
        (squares / self.row_count().max(1) as f64).sqrt()
    }

    pub(super) fn row_count(&self) -> usize {
        self.rows.len()
    }

    /// Returns whether a column is too short to matter.
    pub(super) fn is_empty(&self, column: usize, scale: f64) -> bool {
        let length = self.all[(column, column)].max(0.0).sqrt();
        length * scale.min(1e12) < 1e-6 * self.all[(self.columns, self.columns)].sqrt()
            || length == 0.0
    }
}

/// The fit of all parts but one.
struct Fit {
    active: Vec<usize>,
    /// Values for unit columns.
    x: Vec<f64>,
    factors: Option<Vec<f64>>,
}

/// Fits of a set of columns.
pub(super) struct Fits<'e> {
    evidence: &'e Evidence,
    without: Vec<Fit>,
    pub(super) whole: Directions,
}

impl Fits<'_> {
    /// Returns the held-out residuals after one column is added. Columns that get a forbidden sign keep it, so this is no exact fit.
    pub(super) fn with(&self, column: usize) -> Option<HeldOut> {
        let evidence = self.evidence;
        let (mut squares, mut values) = (Vec::new(), Vec::new());
        for (k, (fit, normal)) in self.without.iter().zip(&evidence.others).enumerate() {
            let length = evidence.lengths[column];
            let a = evidence.against(normal, &fit.active, column);
            let mut z = a.clone();
            solve(fit.factors.as_ref()?, &mut z);
            let product =
                |x: &[f64], y: &[f64]| -> f64 { x.iter().zip(y).map(|(x, y)| x * y).sum() };
            let schur = (normal[(column, column)] + evidence.ridge[column]) / (length * length)
                + RIDGE
                - product(&a, &z);
            let rhs = (normal[(column, evidence.columns)] - evidence.pull[column]) / length
                - product(&a, &fit.x);
            let mut value = rhs / schur.max(RIDGE);
            if evidence.positive[column] && evidence.pull[column] == 0.0 {
                value = value.max(0.0);
            }
            let mut x = vec![0.0; evidence.columns];
            for ((&i, fitted), z) in fit.active.iter().zip(&fit.x).zip(&z) {
                x[i] = (fitted - z * value) / evidence.lengths[i];
            }
            x[column] = value / length;
            squares.push(evidence.left(k, &x));
            values.push(x);
        }
        Some(HeldOut { squares, values })
    }
}

/// A set of columns, beyond which others are judged.
pub(super) struct Directions {
    columns: Vec<usize>,
    factors: Option<Vec<f64>>,
}

impl Directions {
    /// Returns the product of two columns without the part that the set explains, and the length of the first.
    fn product(&self, evidence: &Evidence, one: usize, two: usize) -> f64 {
        let Some(factors) = &self.factors else {
            return 0.0;
        };
        let a = evidence.against(&evidence.all, &self.columns, one);
        let mut b = evidence.against(&evidence.all, &self.columns, two);
        solve(factors, &mut b);
        let explained: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
        evidence.all[(one, two)] - explained * evidence.lengths[one] * evidence.lengths[two]
    }

    /// Returns the part of a column's length that the set cannot mimic.
    pub(super) fn own(&self, evidence: &Evidence, column: usize) -> f64 {
        let length = evidence.all[(column, column)].max(f64::MIN_POSITIVE);
        (self.product(evidence, column, column).max(0.0) / length).sqrt()
    }

    /// Returns the standard error of a column's value beside the set, if the rows are white.
    pub(super) fn error(&self, evidence: &Evidence, column: usize) -> f64 {
        let information = self.product(evidence, column, column) + evidence.ridge[column];
        information.max(f64::MIN_POSITIVE).sqrt().recip()
    }

    /// Returns the correlation of two columns beyond the set.
    pub(super) fn correlation(&self, evidence: &Evidence, one: usize, two: usize) -> f64 {
        let length = |column: usize| {
            self.product(evidence, column, column)
                .max(f64::MIN_POSITIVE)
                .sqrt()
        };
        self.product(evidence, one, two) / (length(one) * length(two))
    }
}

/// Smallest residual of a row that counts, relative to its torque.
const LEAST_RESIDUAL: f64 = 1e-4;

/// Returns the root mean square of a row's torque.
pub(super) fn row_rms(row: &Row) -> f64 {
    let last = row.values.ncols() - 1;
    let squares: f64 = (0..row.values.nrows())
        .map(|i| row.values[(i, last)].powi(2))
        .sum();
    (squares / row.values.nrows().max(1) as f64)
        .sqrt()
        .max(1e-12)
}

/// Returns the squared residual of a row.
fn quadratic(products: &Mat<f64>, columns: &[usize], x: &[f64]) -> f64 {
    let mut used: Vec<(usize, f64)> = (columns.iter().enumerate())
        .map(|(place, &column)| (place, x[column]))
        .filter(|(_, value)| *value != 0.0)
        .collect();
    used.push((columns.len(), -1.0));
    let mut sum = 0.0;
    for (j, vj) in &used {
        let column = products.col(*j);
        let inner: f64 = used.iter().map(|(i, value)| value * column[*i]).sum();
        sum += vj * inner;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A spring of 2 N·m/rad whose deflection is logged with a drift that drives the fitted stiffness to zero.
    #[test]
    fn the_screening_shows_a_drift_that_hides_a_stiffness() {
        const SAMPLES: usize = 800;
        let row = Row {
            joint: 0,
            columns: vec![0, 1],
            values: Mat::from_fn(SAMPLES, 3, |k, column| {
                let time = 2.0 * k as f64 / SAMPLES as f64 - 1.0;
                let deflection = (40.0 * time).sin() - 0.5 * time;
                [deflection + 5.0 * time, time, 2.0 * deflection][column]
            }),
            reliable: vec![1.0; SAMPLES],
        };
        let prior = Prior {
            scale: 10.0,
            applied: 0.0,
            is_positive: false,
        };
        let of = |sign: Sign| {
            let evidence = Evidence::new(
                std::slice::from_ref(&row),
                &[sign],
                &[prior],
                Some(vec![1.0]),
                1.0,
            );
            assert_eq!(evidence.fit(&[0]), [0.0, 0.0]);
            let parts: Vec<usize> = (0..PARTS).collect();
            let without = evidence.held_out(&[0], None).sum(&[0], &parts);
            let with = evidence.fits(&[0]).with(1).unwrap().sum(&[0], &parts);
            with / without
        };
        assert!(of(Sign::Stiffness) < 0.01);
        assert!(of(Sign::NotNegative) > 0.5);
    }

    /// All parts are equal, so that no part changes a fit. The parameter is a column of ones, and half of the unknown's column.
    #[test]
    fn equal_parts_do_not_make_errors_small() {
        const SAMPLES: usize = 800;
        let row = Row {
            joint: 0,
            columns: vec![0, 1],
            values: Mat::from_fn(SAMPLES, 3, |k, column| {
                let alternating = if k % 2 == 0 { 1.0 } else { -1.0 };
                let noise = if k % 4 < 2 { 1.0 } else { -1.0 };
                [1.0, 0.5 + alternating, 7.0 + noise][column]
            }),
            reliable: vec![1.0; SAMPLES],
        };
        let prior = Prior {
            scale: 1e6,
            applied: 0.0,
            is_positive: false,
        };
        let rows = std::slice::from_ref(&row);
        let evidence = Evidence::new(rows, &[Sign::Any], &[prior], Some(vec![1.0]), 4.0);
        let near = |value: f64, expected: f64| {
            assert!((value / expected - 1.0).abs() < 1e-6, "{value} {expected}");
        };
        let deviation = (4.0 / SAMPLES as f64).sqrt();
        near(evidence.unsigned_errors(&[0], 4.0)[0], deviation);
        let both = evidence.unsigned_errors(&[0, 1], 4.0);
        near(both[0], 1.25_f64.sqrt() * deviation);
        near(both[1], deviation);
        near(evidence.slopes(&[0, 1], 1)[0], -0.5);
    }
}
