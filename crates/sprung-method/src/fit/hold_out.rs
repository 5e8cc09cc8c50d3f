//! Blocked cross-validation (hold-out): consecutive parts of the logs are left out in turn and
//! predicted by a fit of the other parts.

use super::least_squares::weighted;
use super::non_negative::with_signs;
use super::unknowns::Free;
use crate::model::{Model, Theta};
use crate::regression::{System, SystemPart, Triangle, solve, solve_quickly};

/// Accuracy of the filtered regression, relative to the torque: the filter of the positions smears
/// reversals of stiff friction, and least squares fits a part of this error.
const REGRESSION_ACCURACY: f64 = 0.005;

/// Returns a residual in the filtered torque over that of a reference, up to the accuracy of the
/// filtered regression. Both are relative to the torque.
pub(crate) fn over_reference(residual: f64, reference: f64) -> f64 {
    residual / reference.hypot(REGRESSION_ACCURACY)
}

/// Returns whether a residual in the filtered torque is smaller than another by more than the accuracy
/// of the filtered regression. Both are relative to the torque.
pub(crate) fn is_clearly_below(residual: f64, other: f64) -> bool {
    other.powi(2) - residual.powi(2) > REGRESSION_ACCURACY.powi(2)
}

/// Consecutive parts of a reduced system, for fits without a part and for the residual of a part.
pub(crate) struct HoldOut<'a> {
    model: &'a Model,
    free: Free,
    // Factors of each row in all its columns, part by part.
    parts: Vec<Vec<Triangle>>,
    // Weight of each row in fits.
    weights: Option<Vec<f64>>,
    // Unknowns that are not negative in fits, if some are not.
    positive: Option<Vec<bool>>,
}

impl<'a> HoldOut<'a> {
    /// Divides a system into at most `count` consecutive parts of about equal length.
    pub(crate) fn new(model: &'a Model, system: &System, count: usize) -> Self {
        Self {
            model,
            free: Free::new(model),
            parts: system.groups(count),
            weights: None,
            positive: None,
        }
    }

    /// Fits without negative friction, stiffnesses and rotor inertias.
    pub(crate) fn with_signs(self) -> Self {
        let is_positive = |&parameter: &usize| {
            let of_joint = self.model.parameters()[parameter].joint;
            of_joint.is_some_and(|(kind, _)| kind.is_vital() || kind.is_friction())
        };
        Self {
            positive: Some(self.free.unknowns.iter().map(is_positive).collect()),
            ..self
        }
    }

    /// Multiplies rows by weights in fits, \[rows\].
    pub(crate) fn weighted(self, weights: &[f64]) -> Self {
        Self {
            weights: Some(weights.to_vec()),
            ..self
        }
    }

    /// Returns the factors of each row in all its columns, part by part.
    pub(crate) fn parts(&self) -> &[Vec<Triangle>] {
        &self.parts
    }

    /// Returns the number of parts.
    pub(crate) fn len(&self) -> usize {
        self.parts.len()
    }

    /// Returns the least-squares fit of the chosen parts, \[p\]; `None` if there are none or a
    /// number is not finite. If they do not determine all parameters, this is the shortest solution
    /// with columns scaled to unit length.
    pub(crate) fn fit(&self, chosen: impl Fn(usize) -> bool) -> Option<Theta> {
        self.fit_of(self.merged(chosen)?)
    }

    /// Returns the least-squares fit of all parts, \[p\]; `None` if they do not determine all
    /// parameters.
    pub(crate) fn fit_determined(&self) -> Option<Theta> {
        let factors = self.free.factors(self.merged(|_| true)?);
        let x = solve_quickly(&self.free.parts(&factors), self.free.unknowns.len())?;
        Some(self.free.whole(&x, |value| value))
    }

    /// Returns the fit without each part, as [`HoldOut::fit`].
    pub(crate) fn fits_without_each(&self) -> Vec<Option<Theta>> {
        let count = self.len();
        if count < 3 {
            return (0..count)
                .map(|left_out| self.fit(|part| part != left_out))
                .collect();
        }
        // Factors of all parts up to each part, and of all parts after it.
        let mut before: Vec<Option<Vec<Triangle>>> = vec![None; count];
        let mut behind: Vec<Option<Vec<Triangle>>> = vec![None; count];
        for part in 1..count {
            let (other, mirror) = (part - 1, count - 1 - part);
            before[part] = joined(before[other].as_deref(), &self.parts[other]);
            behind[mirror] = joined(behind[mirror + 1].as_deref(), &self.parts[mirror + 1]);
        }
        (before.into_iter().zip(behind))
            .map(|pair| match pair {
                (Some(a), Some(b)) => self.fit_of(joined(Some(&a), &b)?),
                (one, other) => self.fit_of(one.or(other)?),
            })
            .collect()
    }

    /// Returns the factors of the chosen parts together; `None` if there are none.
    fn merged(&self, chosen: impl Fn(usize) -> bool) -> Option<Vec<Triangle>> {
        let mut chosen = (self.parts.iter().enumerate()).filter(|(part, _)| chosen(*part));
        let (_, first) = chosen.next()?;
        chosen.try_fold(first.clone(), |sum, (_, part)| joined(Some(&sum), part))
    }

    /// Returns the least-squares fit of one factor per row.
    fn fit_of(&self, factors: Vec<Triangle>) -> Option<Theta> {
        let factors = match &self.weights {
            None => factors,
            Some(weights) => weighted(factors, weights),
        };
        let factors = self.free.factors(factors);
        let parts: Vec<SystemPart<'_>> = self.free.parts(&factors);
        let unknowns = self.free.unknowns.len();
        if let Some(positive) = &self.positive {
            return Some(
                self.free
                    .whole(&with_signs(&parts, positive), |value| value),
            );
        }
        let x = match solve_quickly(&parts, unknowns) {
            Some(x) => x,
            None => solve(&parts, unknowns)?.x,
        };
        Some(self.free.whole(&x, |value| value))
    }

    /// Returns the residual of parameters in the rows of a part.
    pub(crate) fn missed(&self, part: usize, theta: &[f64]) -> Missed {
        Missed::of(self.model, &self.parts[part], theta)
    }

    /// Returns the residual of every part with the least-squares fit of the other parts, summed
    /// over the parts; `None` if a fit has no solution.
    pub(crate) fn missed_by_fits(&self) -> Option<Missed> {
        let mut fits = self.fits_without_each().into_iter().enumerate();
        fits.try_fold(Missed::default(), |sum, (part, theta)| {
            Some(sum.with(&self.missed(part, &theta?)))
        })
    }
}

/// Returns the factors of two parts together, row by row.
fn joined(before: Option<&[Triangle]>, part: &[Triangle]) -> Option<Vec<Triangle>> {
    let Some(before) = before else {
        return Some(part.to_vec());
    };
    (before.iter().zip(part))
        .map(|(a, b)| Triangle::merge([a, b]))
        .collect()
}

/// Squares of the residuals of samples and of their torques, row by row.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Missed {
    /// Sum of the squared residuals of each row, N²·m² (N²).
    pub(crate) residual: Vec<f64>,
    /// Sum of the squared motor torques of each row's joint, filtered, N²·m² (N²).
    pub(crate) torque: Vec<f64>,
    /// Whether each row has the motor torque on its right-hand side.
    is_torque_row: Vec<bool>,
}

impl Missed {
    /// Returns the residual of `theta`, \[p\], in a system of one factor per row.
    pub(crate) fn of(model: &Model, factors: &[Triangle], theta: &[f64]) -> Self {
        let torque_row = |row: usize| model.torque_row(model.joint_of(row));
        Self {
            residual: (factors.iter().enumerate())
                .map(|(row, factor)| {
                    let x: Vec<f64> = model.row_columns(row).iter().map(|&c| theta[c]).collect();
                    factor.residual(&x).iter().map(|r| r * r).sum()
                })
                .collect(),
            torque: (0..factors.len())
                .map(|row| factors[torque_row(row)].rhs_norm().powi(2))
                .collect(),
            is_torque_row: (0..factors.len())
                .map(|row| torque_row(row) == row)
                .collect(),
        }
    }

    /// Adds the squares of other samples of the same system.
    pub(crate) fn with(self, more: &Self) -> Self {
        if self.residual.is_empty() {
            return more.clone();
        }
        let sum = |a: Vec<f64>, b: &[f64]| a.iter().zip(b).map(|(a, b)| a + b).collect();
        Self {
            residual: sum(self.residual, &more.residual),
            torque: sum(self.torque, &more.torque),
            is_torque_row: self.is_torque_row,
        }
    }

    /// Returns the residual of the torque rows relative to the torque: the root mean square over
    /// the joints with torque. `None` if no joint has torque or a number is not finite.
    pub(crate) fn of_torque_rows(&self) -> Option<f64> {
        let shares: Vec<f64> = (0..self.residual.len())
            .filter(|&row| self.is_torque_row[row] && self.torque[row] > 0.0)
            .map(|row| self.residual[row] / self.torque[row])
            .collect();
        let mean = shares.iter().sum::<f64>() / shares.len() as f64;
        Some(mean.sqrt()).filter(|share| share.is_finite())
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::demo;
    use crate::description::{self, DiscretizationName, no_files};
    use crate::fit::{fit_values, fits_of_growing, residual};
    use crate::preprocess::SignalBlock;
    use crate::regression::Reduction;

    fn case() -> (Model, System) {
        let experiment =
            description::read("experiment.toml", demo::EXPERIMENT, &[], &mut no_files).unwrap();
        let model = Model::new(&experiment).unwrap();
        let system = system_of(&model);
        (model, system)
    }

    /// Returns a reduced system of smooth signals of two joints, which need not obey the equations of their robot.
    pub(crate) fn system_of(model: &Model) -> System {
        let mut block = SignalBlock::new(2);
        for k in 0..4096 {
            let t = f64::from(k) * 1e-3;
            block.time.push(t);
            for joint in 0..2 {
                let shift = 0.7 * joint as f64;
                let wave = |f: f64| (f * t + shift + (0.9 * t).sin()).sin();
                let rate =
                    |f: f64| (f + 0.9 * (0.9 * t).cos()) * (f * t + shift + (0.9 * t).sin()).cos();
                block.q[joint].push(wave(5.0 + shift) + 0.02 * wave(31.0));
                block.dq[joint].push(rate(5.0 + shift) + 0.02 * rate(31.0));
                block.phi[joint].push(wave(5.0 + shift) - 0.03 * wave(23.0));
                block.dphi[joint].push(rate(5.0 + shift) - 0.03 * rate(23.0));
                block.tau[joint].push(2.0 * wave(5.0) + 0.3 * wave(17.0) + 0.1);
            }
        }
        let mut reduction = Reduction::new(model);
        reduction
            .push(&block, 30.0, 1e-3, DiscretizationName::Matched)
            .unwrap();
        reduction.finish()
    }

    fn assert_close(found: &[f64], expected: &[f64]) {
        for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
            // Rounding, times the condition number: columns and directions differ by up to three orders of size each.
            let limit = 1e6 * 4.0 * f64::EPSILON;
            let difference = (found - expected).abs() / (1e-3 + expected.abs());
            assert!(difference < limit, "{i}: {found} {expected}");
        }
    }

    #[test]
    fn fits_of_parts_equal_fits_of_their_samples_together() {
        let (model, system) = case();
        let hold_out = HoldOut::new(&model, &system, 4);
        assert_eq!(hold_out.len(), 4);
        let all = hold_out.fit(|_| true);
        assert_close(&all.unwrap(), &fit_values(&model, &system).unwrap());
        let (_, first) = fits_of_growing(&model, &system, 4).nth(2).unwrap();
        assert_close(&hold_out.fit(|part| part != 3).unwrap(), &first.unwrap());
        for (part, theta) in hold_out.fits_without_each().iter().enumerate() {
            let expected = hold_out.fit(|other| other != part).unwrap();
            assert_close(theta.as_ref().unwrap(), &expected);
        }
        assert!(hold_out.fit(|_| false).is_none());
    }

    #[test]
    fn squares_of_all_parts_add_up_to_those_of_the_logs() {
        let (model, system) = case();
        let hold_out = HoldOut::new(&model, &system, 8);
        let theta = fit_values(&model, &system).unwrap();
        let sum = (0..hold_out.len()).fold(Missed::default(), |sum, part| {
            sum.with(&hold_out.missed(part, &theta))
        });
        let rows = residual(&model, &system, &theta);
        let count = system.samples() as f64;
        let expected: Vec<f64> = rows.iter().map(|(rms, _)| rms * rms * count).collect();
        assert_close(&sum.residual, &expected);
        let torque: Vec<f64> = [2, 3, 2, 3]
            .map(|row: usize| rows[row].1.powi(2) * count)
            .into();
        assert_close(&sum.torque, &torque);
        let share = (rows[2].0 / rows[2].1).powi(2) + (rows[3].0 / rows[3].1).powi(2);
        assert_close(&[sum.of_torque_rows().unwrap()], &[(share / 2.0).sqrt()]);
    }

    #[test]
    fn a_part_that_a_fit_did_not_see_is_predicted_worse() {
        let (model, system) = case();
        let hold_out = HoldOut::new(&model, &system, 8);
        let seen = Missed::of(
            &model,
            &system.whole().unwrap(),
            &fit_values(&model, &system).unwrap(),
        );
        let unseen = hold_out.missed_by_fits().unwrap();
        assert!(unseen.of_torque_rows() > seen.of_torque_rows());
        let alone = HoldOut::new(&model, &system, 1);
        assert!(alone.missed_by_fits().is_none());
        assert_eq!(Missed::default().of_torque_rows(), None);
    }
}
