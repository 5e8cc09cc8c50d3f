//! Normal equations of consecutive parts of a log, with columns that the model lacks.
//!
//! Each part is predicted by a fit of the other parts. A candidate's columns border the factored
//! normal equations, so testing a candidate costs two substitutions and no factorisation.

use crate::estimate::statistics::{HELD_OUT_PARTS, RIDGE};
use sprung_core::linear::{factor, solve};

use crate::fit::Free;
use crate::model::Model;
use crate::regression::{Probe, System, Triangle};

/// Least part of a column's squared length that is independent of the other columns; below it the
/// log does not determine the parameter.
const MIN_OWN_SHARE: f64 = 1e-5;

/// One part of the log.
struct Part {
    /// Factor of each row in its unknowns.
    factors: Vec<Triangle>,
    /// Normal equations of the other parts with unit columns, \[unknowns × unknowns\].
    others: Vec<f64>,
    /// Their right-hand sides, \[unknowns\].
    others_rhs: Vec<f64>,
}

/// Normal equations of a log, part by part.
pub(super) struct Normal {
    parts: Vec<Part>,
    /// Unknowns of each row.
    columns: Vec<Vec<usize>>,
    /// Length of each unknown's column in the whole log.
    lengths: Vec<f64>,
    /// Number of unknowns of the model; those of the probes follow.
    of_model: usize,
}

/// The fit of all parts but one.
struct WithoutPart {
    factors: Vec<f64>,
    x: Vec<f64>,
}

/// The fits of a set of unknowns without each part, and their residuals in the part.
pub(super) struct Fits {
    active: Vec<usize>,
    without: Vec<WithoutPart>,
    /// Sum of the squared residuals of each row in each part, \[parts × rows\].
    pub(super) squares: Vec<Vec<f64>>,
}

impl Normal {
    /// - `system`: the model's rows with `probes`, each with the index of its unknown.
    ///
    /// Returns `None` if the log has too few parts.
    pub(super) fn new(model: &Model, system: &System, probes: &[(Probe, usize)]) -> Option<Self> {
        let free = Free::new(model).unknowns;
        let of_model = free.len();
        let (mut columns, mut known) = (Vec::new(), Vec::new());
        for row in 0..model.rows() {
            let probes_of_row = probes.iter().filter(|(probe, _)| probe.row() == row);
            let of_row = model.row_columns(row).iter();
            let mut unknowns: Vec<usize> = of_row
                .clone()
                .filter_map(|c| free.binary_search(c).ok())
                .collect();
            let mut values: Vec<Option<f64>> =
                of_row.map(|&c| model.parameters()[c].fixed).collect();
            for (_, unknown) in probes_of_row {
                unknowns.push(of_model + unknown);
                values.push(None);
            }
            columns.push(unknowns);
            known.push(values);
        }
        let groups = system.groups(HELD_OUT_PARTS);
        if groups.len() < HELD_OUT_PARTS {
            return None;
        }
        let groups: Vec<Vec<Triangle>> = (groups.into_iter())
            .map(|group| {
                (group.iter().zip(&known))
                    .map(|(factor, known)| factor.with_known(known))
                    .collect()
            })
            .collect();
        let unknowns = of_model + probes.iter().map(|(_, u)| u + 1).max().unwrap_or(0);
        Some(Self::of_groups(groups, columns, unknowns, of_model))
    }

    fn of_groups(
        groups: Vec<Vec<Triangle>>,
        columns: Vec<Vec<usize>>,
        unknowns: usize,
        of_model: usize,
    ) -> Self {
        let products: Vec<(Vec<f64>, Vec<f64>)> = (groups.iter())
            .map(|group| products(group, &columns, unknowns))
            .collect();
        let mut whole = vec![0.0; unknowns * unknowns];
        let mut rhs = vec![0.0; unknowns];
        for (gram, b) in &products {
            whole.iter_mut().zip(gram).for_each(|(sum, x)| *sum += x);
            rhs.iter_mut().zip(b).for_each(|(sum, x)| *sum += x);
        }
        let lengths: Vec<f64> = (0..unknowns)
            .map(|i| match whole[i * unknowns + i].sqrt() {
                length if length > 0.0 => length,
                _ => 1.0,
            })
            .collect();
        let parts = (groups.into_iter().zip(products))
            .map(|(factors, (gram, b))| {
                let scale = |i: usize, j: usize| lengths[i] * lengths[j];
                let others = (0..unknowns * unknowns)
                    .map(|at| (whole[at] - gram[at]) / scale(at / unknowns, at % unknowns));
                Part {
                    factors,
                    others: others.collect(),
                    others_rhs: (0..unknowns)
                        .map(|i| (rhs[i] - b[i]) / lengths[i])
                        .collect(),
                }
            })
            .collect();
        Self {
            parts,
            columns,
            lengths,
            of_model,
        }
    }

    fn unknowns(&self) -> usize {
        self.lengths.len()
    }

    /// Returns the index of a probe's unknown.
    fn probe(&self, unknown: usize) -> usize {
        self.of_model + unknown
    }

    /// Returns the sum of the squared right-hand sides of each row in the whole log.
    pub(super) fn torque_squares(&self, row: usize) -> f64 {
        let parts = self.parts.iter();
        parts.map(|part| part.factors[row].rhs_norm().powi(2)).sum()
    }

    /// Fits the model with some probes without each part; `None` if a fit fails.
    pub(super) fn fit(&self, probes: &[usize]) -> Option<Fits> {
        let mut active: Vec<usize> = (0..self.of_model).collect();
        active.extend(probes.iter().map(|&unknown| self.probe(unknown)));
        let rows: Vec<usize> = (0..self.columns.len()).collect();
        let n = active.len();
        let (mut fits, mut squares) = (Vec::new(), Vec::new());
        for part in &self.parts {
            let mut factors = vec![0.0; n * n];
            for (i, &row) in active.iter().enumerate() {
                for (j, &column) in active[..=i].iter().enumerate() {
                    factors[i * n + j] = part.others[row * self.unknowns() + column];
                }
                factors[i * n + i] += RIDGE;
            }
            if !factor(&mut factors, n) {
                return None;
            }
            let mut x: Vec<f64> = active.iter().map(|&i| part.others_rhs[i]).collect();
            solve(&factors, &mut x);
            let whole = self.scaled_back(active.iter().copied().zip(x.iter().copied()));
            squares.push(self.squares(part, &whole, &rows));
            fits.push(WithoutPart { factors, x });
        }
        Some(Fits {
            active,
            without: fits,
            squares,
        })
    }

    /// Returns the squared residuals of some rows in each part after further probes are added, \[parts × rows\], and the
    /// length in the whole log of the torque that they add; `None` if the log does not determine their parameters.
    pub(super) fn with(
        &self,
        fits: &Fits,
        probes: &[usize],
        rows: &[usize],
    ) -> Option<(Vec<Vec<f64>>, f64)> {
        let mut length = 0.0;
        let squares: Option<Vec<Vec<f64>>> = (self.parts.iter().zip(&fits.without))
            .map(|(part, fit)| {
                let x = self.bordered(part, fit, &fits.active, probes)?;
                let indices = probes.iter().map(|&unknown| self.probe(unknown));
                let of_columns = indices.map(|i| (x[i] * self.lengths[i]).powi(2));
                length += of_columns.sum::<f64>().sqrt() / self.parts.len() as f64;
                Some(self.squares(part, &x, rows))
            })
            .collect();
        Some((squares?, length))
    }

    /// Returns the unknowns of the fit without a part after further probes are added.
    fn bordered(
        &self,
        part: &Part,
        fit: &WithoutPart,
        active: &[usize],
        probes: &[usize],
    ) -> Option<Vec<f64>> {
        let (n, k) = (self.unknowns(), probes.len());
        let added: Vec<usize> = probes.iter().map(|&unknown| self.probe(unknown)).collect();
        let mut solved: Vec<Vec<f64>> = Vec::new();
        for &column in &added {
            let mut x: Vec<f64> = active
                .iter()
                .map(|&i| part.others[i * n + column])
                .collect();
            solve(&fit.factors, &mut x);
            solved.push(x);
        }
        let with_active = |column: usize, x: &[f64]| -> f64 {
            (active.iter().zip(x))
                .map(|(&i, x)| part.others[i * n + column] * x)
                .sum()
        };
        let mut schur = vec![0.0; k * k];
        let mut values = vec![0.0; k];
        for (i, &row) in added.iter().enumerate() {
            for (j, &column) in added.iter().enumerate() {
                schur[i * k + j] = part.others[row * n + column] - with_active(row, &solved[j]);
            }
            if schur[i * k + i] < MIN_OWN_SHARE * part.others[row * n + row].max(MIN_OWN_SHARE) {
                return None;
            }
            schur[i * k + i] += RIDGE;
            values[i] = part.others_rhs[row] - with_active(row, &fit.x);
        }
        if !factor(&mut schur, k) {
            return None;
        }
        solve(&schur, &mut values);
        let moved = active.iter().enumerate().map(|(at, &i)| {
            let taken: f64 = (solved.iter().zip(&values)).map(|(x, v)| x[at] * v).sum();
            (i, fit.x[at] - taken)
        });
        let more = added.iter().copied().zip(values.iter().copied());
        Some(self.scaled_back(moved.chain(more)))
    }

    /// Returns all unknowns in their units from some unknowns of unit columns.
    fn scaled_back(&self, some: impl Iterator<Item = (usize, f64)>) -> Vec<f64> {
        let mut whole = vec![0.0; self.unknowns()];
        for (i, value) in some {
            whole[i] = value / self.lengths[i];
        }
        whole
    }

    /// Returns the squared residuals of some rows in a part.
    fn squares(&self, part: &Part, x: &[f64], rows: &[usize]) -> Vec<f64> {
        (rows.iter())
            .map(|&row| {
                let values: Vec<f64> = self.columns[row].iter().map(|&i| x[i]).collect();
                let residual = part.factors[row].residual(&values);
                residual.iter().map(|r| r * r).sum()
            })
            .collect()
    }
}

/// Returns the products of the columns with one another and with the right-hand side.
fn products(group: &[Triangle], columns: &[Vec<usize>], unknowns: usize) -> (Vec<f64>, Vec<f64>) {
    let mut gram = vec![0.0; unknowns * unknowns];
    let mut rhs = vec![0.0; unknowns];
    for (factor, columns) in group.iter().zip(columns) {
        let m = columns.len();
        let product = |i: usize, j: usize| -> f64 {
            (0..=i.min(j))
                .map(|k| factor.entry(k, i) * factor.entry(k, j))
                .sum()
        };
        for (i, &row) in columns.iter().enumerate() {
            for (j, &column) in columns[..=i].iter().enumerate() {
                let product = product(i, j);
                gram[row * unknowns + column] += product;
                if i != j {
                    gram[column * unknowns + row] += product;
                }
            }
            rhs[row] += product(i, m);
        }
    }
    (gram, rhs)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of one part: three columns of the model, two probes, and the right-hand side, which
    /// needs the first probe. The second probe repeats the first.
    fn rows(part: u32) -> Vec<[f64; 6]> {
        (0..40)
            .map(|k| {
                let t = f64::from(part * 40 + k) * 0.37;
                let [a, b, c] = [t.sin(), 100.0 * t.cos(), 0.1 * (0.3 * t).sin()];
                let probe = (1.7 * t).sin();
                let noise = 1e-3 * (t * t).sin();
                [
                    a,
                    b,
                    c,
                    probe,
                    probe,
                    2.0 * a - 0.03 * b + c + 0.5 * probe + noise,
                ]
            })
            .collect()
    }

    fn normal() -> Normal {
        let groups: Vec<Vec<Triangle>> = (0..8).map(|g| vec![Triangle::of(&rows(g))]).collect();
        Normal::of_groups(groups, vec![vec![0, 1, 2, 3, 4]], 5, 3)
    }

    #[test]
    fn a_bordered_fit_equals_the_fit_with_the_probe() {
        let normal = normal();
        let (without, with) = (normal.fit(&[]).unwrap(), normal.fit(&[0]).unwrap());
        let (bordered, _) = normal.with(&without, &[0], &[0]).unwrap();
        for (part, (found, expected)) in bordered.iter().zip(&with.squares).enumerate() {
            // The ridge moves a solution by the condition number, at most 100 here, and the right-hand side is 5000
            // times as large as the residual.
            let limit = 2.0 * RIDGE * 100.0 * 5000.0;
            assert!((found[0] / expected[0] - 1.0).abs() < limit, "{part}");
            assert!(found[0] < 1e-3 * without.squares[part][0]);
        }
    }

    #[test]
    fn a_probe_that_another_column_repeats_has_no_fit() {
        let normal = normal();
        let with = normal.fit(&[0]).unwrap();
        assert!(normal.with(&with, &[1], &[0]).is_none());
    }
}
