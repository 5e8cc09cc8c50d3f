//! The same equations solved by other methods, whose errors have other causes.

use crate::estimate::statistics::{MAX_ITERATIONS, MAX_ROUNDS, ROUNDING};
use crate::fit::Free;
use crate::model::{Model, Theta};
use crate::regression::{System, SystemPart, Triangle, solve, solve_quickly};
use sprung_core::parameters::JointParameter;

/// A route to the parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Route {
    /// Motor rows first. Then link rows, with the spring torque as their right-hand side.
    TwoStage,
    /// All rows at once. The residual of each link row is divided by the joint's stiffness.
    ScaleInvariant,
}

impl Route {
    /// Returns the name in files and tables.
    #[must_use]
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::TwoStage => "two-stage",
            Self::ScaleInvariant => "scale-invariant",
        }
    }
}

/// Solves the reduced equations by both other routes. Returns parameter vectors, \[p\]; a route
/// without a solution is left out.
///
/// Neither route can shrink links and springs together. In the two-stage route only the motor rows
/// determine the stiffnesses. In the scale-invariant route a common scale of a link row does not
/// change its residual. So the rows can be weighted by their residuals.
#[must_use]
pub(crate) fn cross_checks(model: &Model, system: &System) -> Vec<(Route, Theta)> {
    let free = Free::new(model);
    let has_springs = (0..model.joint_count()).any(|joint| model.is_flexible(joint));
    let Some(whole) = system.whole().filter(|_| has_springs) else {
        return Vec::new();
    };
    let rows = Rows {
        model,
        counts: (0..model.rows()).map(|row| system.weight(row)).collect(),
        factors: free.factors(whole),
        free: &free,
    };
    let Some(two_stage) = rows.two_stage() else {
        return Vec::new();
    };
    let scale_invariant = rows.scale_invariant(&two_stage);
    let all = [
        (Route::TwoStage, Some(two_stage)),
        (Route::ScaleInvariant, scale_invariant),
    ];
    all.into_iter()
        .filter_map(|(route, x)| Some((route, free.whole(&x?, |value| value))))
        .collect()
}

/// Rows without the known parameters.
struct Rows<'a> {
    model: &'a Model,
    free: &'a Free,
    factors: Vec<Triangle>,
    // Effective number of samples of each row: the sum of the squared weights.
    counts: Vec<f64>,
}

impl Rows<'_> {
    /// Solves the motor rows, then the link rows with the parameters of the motor rows known.
    fn two_stage(&self) -> Option<Vec<f64>> {
        let n = self.model.joint_count();
        let columns = &self.free.columns;
        let mut x = vec![None; self.free.unknowns.len()];
        let motors: Vec<usize> = (n..columns.len()).collect();
        let first = self.unknowns_of(&motors, &x);
        let places = self.places(&motors, &first);
        let of_motors = parts(&places, &self.factors[n..]);
        for (at, value) in first.iter().zip(solve(&of_motors, first.len())?.x) {
            x[*at] = Some(value);
        }
        let known = |row: usize| columns[row].iter().map(|&c| x[c]).collect::<Vec<_>>();
        let links: Vec<usize> = (0..n).collect();
        let second = self.unknowns_of(&links, &x);
        let reduced: Vec<Triangle> = (0..n)
            .map(|row| self.factors[row].with_known(&known(row)))
            .collect();
        let touched = self.places(&links, &second);
        let mut scales = vec![1.0; n];
        let mut found = Vec::new();
        for _ in 0..MAX_ROUNDS {
            let weighted: Vec<Triangle> = (reduced.iter().zip(&scales))
                .map(|(factor, scale)| factor.scaled(1.0 / scale))
                .collect();
            found = solve(&parts(&touched, &weighted), second.len())?.x;
            let residuals = touched.iter().zip(&reduced).zip(&self.counts);
            scales = floored(
                residuals
                    .map(|((columns, factor), count)| {
                        let x: Vec<f64> = columns.iter().map(|&c| found[c]).collect();
                        factor.residual_length(&x) / count.max(1.0).sqrt()
                    })
                    .collect(),
            );
        }
        for (at, value) in second.iter().zip(found) {
            x[*at] = Some(value);
        }
        x.into_iter().collect()
    }

    /// Minimises the sum of `|L_i x|² / (k_i s_i)²` over the link rows and `|M_i x - b_i|² / s_i²`
    /// over the other rows by Gauss-Newton steps. The scales `s_i` follow the residuals.
    fn scale_invariant(&self, start: &[f64]) -> Option<Vec<f64>> {
        let mut x = start.to_vec();
        for step in 0..MAX_ITERATIONS {
            let scales = floored(
                (0..self.factors.len())
                    .map(|row| self.relative_residual(row, &x))
                    .collect(),
            );
            let linear: Vec<Triangle> = (self.factors.iter().enumerate())
                .map(|(row, factor)| {
                    let values = self.values_of(row, &x);
                    match self.spring(row) {
                        Some(spring) => factor.over_unknown(&values, spring),
                        None => factor.clone(),
                    }
                    .scaled(1.0 / scales[row])
                })
                .collect();
            let next = solve_quickly(&parts(&self.free.columns, &linear), x.len())?;
            // A stiffness that is not positive is not physical.
            let left = (0..self.factors.len()).any(|row| {
                let spring = |x: &[f64]| self.spring(row).map(|at| self.values_of(row, x)[at]);
                spring(&next).is_some_and(|k| k.is_nan() || k <= 0.0)
            });
            if left {
                return None;
            }
            let settled = (x.iter().zip(&next))
                .all(|(before, after)| (after - before).abs() <= ROUNDING * after.abs());
            x = next;
            if settled && step > 0 {
                return Some(x);
            }
        }
        None
    }

    /// Returns the root mean square residual of a row, divided by the stiffness if it is a link
    /// row.
    fn relative_residual(&self, row: usize, x: &[f64]) -> f64 {
        let values = self.values_of(row, x);
        let scale = self.spring(row).map_or(1.0, |spring| values[spring].abs());
        self.factors[row].residual_length(&values) / (scale * self.counts[row].max(1.0).sqrt())
    }

    /// Returns the position of the joint's stiffness among the unknowns of a link row.
    fn spring(&self, row: usize) -> Option<usize> {
        let model = self.model;
        let joint = (row < model.joint_count() && model.is_flexible(row)).then_some(row)?;
        let column = model.index(JointParameter::Stiffness, joint)?;
        let unknown = self.free.unknowns.binary_search(&column).ok()?;
        self.free.columns[row].iter().position(|c| *c == unknown)
    }

    fn values_of(&self, row: usize, x: &[f64]) -> Vec<f64> {
        self.free.columns[row].iter().map(|&c| x[c]).collect()
    }

    /// Returns the unknowns of some rows that have no value yet, in ascending order.
    fn unknowns_of(&self, rows: &[usize], found: &[Option<f64>]) -> Vec<usize> {
        let mut all: Vec<usize> = (rows.iter())
            .flat_map(|&row| self.free.columns[row].iter().copied())
            .filter(|&c| found[c].is_none())
            .collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Returns the positions of the rows' unknowns in a sorted list. Unknowns that are not in the
    /// list are left out.
    fn places(&self, rows: &[usize], among: &[usize]) -> Vec<Vec<usize>> {
        let place = |c: &usize| among.binary_search(c).ok();
        (rows.iter())
            .map(|&row| self.free.columns[row].iter().filter_map(place).collect())
            .collect()
    }
}

fn parts<'a>(columns: &'a [Vec<usize>], factors: &'a [Triangle]) -> Vec<SystemPart<'a>> {
    (columns.iter().zip(factors))
        .map(|(columns, factor)| SystemPart { columns, factor })
        .collect()
}

/// Limits the smallest residuals, so that a row without a residual gets no infinite weight.
fn floored(scales: Vec<f64>) -> Vec<f64> {
    let largest = scales.iter().copied().fold(0.0, f64::max);
    if largest == 0.0 {
        return vec![1.0; scales.len()];
    }
    (scales.into_iter())
        .map(|scale| scale.max(ROUNDING * largest))
        .collect()
}
