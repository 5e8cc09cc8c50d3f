//! Least squares on the filtered regression.

use faer::Mat;
use sprung_core::parameters::JointParameter;

use super::jackknife::{influences, scatter};
use crate::model::{Model, Theta};
use crate::regression::{System, SystemPart, Triangle, solve, solve_quickly};

/// Stretches of the log whose scatter gives the standard errors, at most.
const GROUPS: usize = 32;

/// Numbers of a trace, at most: it has fewer points for more parameters.
const TRACE: usize = 8000;

/// A parameter vector with its uncertainty.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The parameter vector, known values included, \[p\].
    pub theta: Theta,
    /// Whether the data determine each parameter, or it is known.
    pub identifiable: Vec<bool>,
    /// Standard error of each parameter; zero for known ones.
    pub standard_error: Vec<f64>,
    /// How much each parameter takes part in the direction seen least, columns
    /// scaled.
    pub weakest_direction: Vec<f64>,
    /// Numerical rank, out of the parameters that are not known.
    pub rank: usize,
    /// Number of parameters that are not known.
    pub unknowns: usize,
    /// Ratio of extreme singular values, as the columns stand.
    pub condition_number: f64,
    /// The same after scaling columns to unit length.
    pub condition_number_scaled: f64,
    /// Half width of a 95 % interval in standard errors.
    pub interval: f64,
    /// The motor rows alone, one per flexible joint.
    pub motor_rows: Vec<MotorRow>,
}

/// What the motor row of a flexible joint says by itself.
///
/// It has a right-hand side, the torque, so nothing pulls its scale down.
#[derive(Clone, Debug)]
pub struct MotorRow {
    /// The joint.
    pub joint: usize,
    /// Indices in theta of its parameters.
    pub columns: Vec<usize>,
    /// Their values.
    pub values: Vec<f64>,
    /// Their standard errors.
    pub standard_error: Vec<f64>,
    /// Standard errors of what the stacked estimate has more.
    pub difference_error: Vec<f64>,
    /// Part of the spring torque that no other column of the row explains over
    /// the row's residual, squared; none without an unknown spring.
    pub scale_number: Option<f64>,
    /// Whether the row determines them.
    pub identifiable: Vec<bool>,
    /// Condition number, columns as they stand.
    pub condition_number: f64,
    /// Residual over torque, root mean squares.
    pub relative_residual: f64,
}

/// Rows of a system without the parameters that are known.
pub(crate) struct Free {
    /// Index in theta of each unknown.
    pub(crate) unknowns: Vec<usize>,
    /// Value of each known parameter.
    known: Vec<Option<f64>>,
    /// Unknowns that each row touches, by their place among the unknowns.
    pub(crate) columns: Vec<Vec<usize>>,
    /// Columns of theta that each row touches.
    touched: Vec<Vec<usize>>,
}

impl Free {
    pub(crate) fn new(model: &Model) -> Self {
        let known: Vec<Option<f64>> = model.parameters().iter().map(|p| p.fixed).collect();
        let unknowns: Vec<usize> = (0..known.len()).filter(|&i| known[i].is_none()).collect();
        let place = |column: &usize| unknowns.binary_search(column).ok();
        let touched: Vec<Vec<usize>> = (0..model.rows())
            .map(|row| model.row_columns(row).to_vec())
            .collect();
        Self {
            columns: (touched.iter())
                .map(|columns| columns.iter().filter_map(place).collect())
                .collect(),
            touched,
            unknowns,
            known,
        }
    }

    /// Moves known parameters to the right-hand side.
    pub(crate) fn factors(&self, factors: Vec<Triangle>) -> Vec<Triangle> {
        if self.unknowns.len() == self.known.len() {
            return factors;
        }
        let known = |columns: &Vec<usize>| -> Vec<Option<f64>> {
            columns.iter().map(|&c| self.known[c]).collect()
        };
        (factors.iter().zip(&self.touched))
            .map(|(factor, columns)| factor.with_known(&known(columns)))
            .collect()
    }

    fn parts<'a>(&'a self, factors: &'a [Triangle]) -> Vec<SystemPart<'a>> {
        (self.columns.iter().zip(factors))
            .map(|(columns, factor)| SystemPart { columns, factor })
            .collect()
    }

    /// Puts values of the unknowns among all parameters.
    pub(crate) fn whole<T: Copy>(&self, of_unknowns: &[T], of_known: impl Fn(f64) -> T) -> Vec<T> {
        let mut next = of_unknowns.iter();
        (self.known.iter())
            .filter_map(|known| match known {
                Some(value) => Some(of_known(*value)),
                None => next.next().copied(),
            })
            .collect()
    }
}

/// Solves the stacked system and each motor row alone.
///
/// Returns nothing if there are no samples or a number is not finite.
///
/// Standard errors come from up to 32 stretches of the log that are left out in
/// turn, so they hold for residuals of any colour and level. They say how much
/// the stretches disagree; a bias that all stretches share, as by quantised
/// positions through the Coulomb transition, is not in them.
///
/// # Source
///
/// Eq. (28).
#[must_use]
pub fn fit(model: &Model, system: &System) -> Option<Fitted> {
    let free = Free::new(model);
    let whole = free.factors(system.whole()?);
    let groups: Vec<Vec<Triangle>> = (system.groups(GROUPS).into_iter())
        .map(|group| free.factors(group))
        .collect();
    let solution = solve(&free.parts(&whole), free.unknowns.len())?;
    let stacked = influences(&solution, &free.columns, &groups);
    let errors = scatter(&stacked);

    let motor_rows = (0..model.joint_count())
        .filter(|&joint| model.is_flexible(joint))
        .map(|joint| {
            let row = model.torque_row(joint);
            let count = free.columns[row].len();
            let local: Vec<usize> = (0..count).collect();
            let part = SystemPart {
                columns: &local,
                factor: &whole[row],
            };
            let solution = solve(&[part], count)?;
            let own: Vec<Vec<Triangle>> = groups.iter().map(|g| vec![g[row].clone()]).collect();
            let alone = influences(&solution, &[local], &own);
            let more = Mat::from_fn(count, groups.len(), |i, g| {
                stacked[(free.columns[row][i], g)] - alone[(i, g)]
            });
            let residual = length(&whole[row].residual(&solution.x));
            let spring = (free.columns[row].iter()).position(|&unknown| {
                let of = model.parameters()[free.unknowns[unknown]].joint;
                of == Some((JointParameter::Stiffness, joint))
            });
            Some(MotorRow {
                joint,
                difference_error: scatter(&more),
                scale_number: spring.map(|at| {
                    solution.x[at].powi(2) / (solution.inverse[(at, at)] * residual.powi(2))
                }),
                columns: (free.columns[row].iter())
                    .map(|&unknown| free.unknowns[unknown])
                    .collect(),
                standard_error: scatter(&alone),
                relative_residual: {
                    let known = model.row_columns(row).iter().map(|&c| {
                        let at = free.unknowns.binary_search(&c).ok()?;
                        let own = free.columns[row]
                            .iter()
                            .position(|&unknown| unknown == at)?;
                        Some(solution.x[own])
                    });
                    let fixed = model.row_columns(row).iter().map(|&c| free.known[c]);
                    let values: Vec<f64> = (known.zip(fixed))
                        .map(|(found, fixed)| found.or(fixed).unwrap_or(0.0))
                        .collect();
                    unweighted(system, row, &values)
                        .unwrap_or_else(|| residual / whole[row].rhs_norm())
                },
                values: solution.x,
                identifiable: solution.identifiable,
                condition_number: solution.condition_number,
            })
        })
        .collect::<Option<_>>()?;
    Some(Fitted {
        theta: free.whole(&solution.x, |value| value),
        identifiable: free.whole(&solution.identifiable, |_| true),
        standard_error: free.whole(&errors, |_| 0.0),
        weakest_direction: free.whole(&solution.weakest_direction, |_| 0.0),
        rank: solution.rank,
        unknowns: free.unknowns.len(),
        condition_number: solution.condition_number,
        condition_number_scaled: solution.condition_number_scaled,
        interval: student_95(groups.len().saturating_sub(1)),
        motor_rows,
    })
}

/// Returns the parameter vector alone, \[p\]; nothing if the data do not
/// determine all of it.
#[must_use]
pub fn fit_quickly(model: &Model, system: &System) -> Option<Theta> {
    let free = Free::new(model);
    let whole = free.factors(system.whole()?);
    let x = solve_quickly(&free.parts(&whole), free.unknowns.len())?;
    Some(free.whole(&x, |value| value))
}

/// Returns the parameter vector alone, \[p\]: the shortest that fits if the data
/// do not determine it, columns scaled.
#[must_use]
pub(crate) fn fit_values(model: &Model, system: &System) -> Option<Theta> {
    let free = Free::new(model);
    let whole = free.factors(system.whole()?);
    let solution = solve(&free.parts(&whole), free.unknowns.len())?;
    Some(free.whole(&solution.x, |value| value))
}

fn length(v: &[f64]) -> f64 {
    v.iter().map(|r| r * r).sum::<f64>().sqrt()
}

/// Returns the 97.5 % quantile of Student's t; within 1 % from three degrees of
/// freedom on, infinite below.
///
/// # Source
///
/// Cornish-Fisher expansion about the normal quantile.
fn student_95(freedom: usize) -> f64 {
    if freedom < 3 {
        return f64::INFINITY;
    }
    let (z, n) = (1.959_964_f64, freedom as f64);
    let first = (z.powi(3) + z) / 4.0;
    let second = (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0;
    let third = (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0;
    z + first / n + second / n.powi(2) + third / n.powi(3)
}

/// Returns the estimate over time: that of the log up to then, \[p\], or
/// nothing while the data do not determine all parameters.
///
/// # Source
///
/// Eq. (28) and Fig. 4.
pub fn trace<'a>(
    model: &'a Model,
    system: &'a System,
) -> impl Iterator<Item = (f64, Option<Theta>)> + 'a {
    let unknowns = Free::new(model).unknowns.len();
    fits_of_growing(model, system, (TRACE / unknowns.max(1)).max(48))
}

/// Returns the parameter vectors of the samples up to ever later times, in s, at
/// most `count` of them; nothing where they are not determined.
pub(crate) fn fits_of_growing<'a>(
    model: &'a Model,
    system: &'a System,
    count: usize,
) -> impl Iterator<Item = (f64, Option<Theta>)> + 'a {
    let free = Free::new(model);
    system.growing(count).map(move |(time, factors)| {
        let factors = free.factors(factors);
        let x = solve_quickly(&free.parts(&factors), free.unknowns.len());
        (time, x.map(|x| free.whole(&x, |value| value)))
    })
}

/// Returns the residual of a row over its right-hand side, root mean squares of
/// the samples that are kept, which have no weights: a model that does not
/// explain its log must not hide behind them. Nothing if all count alike.
///
/// - `values`: parameters of the row's entries.
pub(crate) fn unweighted(system: &System, row: usize, values: &[f64]) -> Option<f64> {
    let kept = system.kept();
    if kept.variance.get(row)?.is_empty() {
        return None;
    }
    let (mut left, mut all) = (0.0, 0.0);
    for sample in &kept.rows[row] {
        let rhs = sample.last()?;
        let fitted: f64 = sample.iter().zip(values).map(|(y, x)| y * x).sum();
        left += (fitted - rhs).powi(2);
        all += rhs.powi(2);
    }
    (all > 0.0).then(|| (left / all).sqrt())
}

/// Returns root mean squares of the residual and of the right-hand side of
/// each row, N·m; of weighted samples if they are.
#[must_use]
pub fn residual(model: &Model, system: &System, theta: &[f64]) -> Vec<(f64, f64)> {
    system
        .whole()
        .unwrap_or_default()
        .iter()
        .enumerate()
        .map(|(row, factor)| {
            let scale = 1.0 / system.weight(row).max(1.0).sqrt();
            let x: Vec<f64> = model.row_columns(row).iter().map(|&c| theta[c]).collect();
            let squares: f64 = factor.residual(&x).iter().map(|r| r * r).sum();
            (scale * squares.sqrt(), scale * factor.rhs_norm())
        })
        .collect()
}

/// The torque that a parameter stands for in a log.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TorqueOf {
    /// Root mean square of its column times its value, N·m (N); of a parameter
    /// of two rows, where it is larger.
    pub rms: f64,
    /// Its share of the largest such torque of that row.
    pub share: f64,
    /// The same over the residual of a row, in the row where that is most.
    pub over_residual: f64,
}

/// Returns what each parameter stands for in the log.
#[must_use]
pub fn torques(model: &Model, system: &System, theta: &[f64]) -> Vec<TorqueOf> {
    let residuals = residual(model, system, theta);
    let mut torques = vec![TorqueOf::default(); theta.len()];
    for (row, factor) in system.whole().unwrap_or_default().iter().enumerate() {
        let columns = model.row_columns(row);
        let scale = 1.0 / system.weight(row).max(1.0).sqrt();
        let own: Vec<f64> = (columns.iter().enumerate())
            .map(|(j, &column)| scale * factor.column_norm(j) * theta[column].abs())
            .collect();
        let largest = own.iter().copied().fold(0.0, f64::max);
        for (&column, rms) in columns.iter().zip(own) {
            let torque = &mut torques[column];
            torque.over_residual = torque.over_residual.max(rms / residuals[row].0);
            if rms > torque.rms {
                torque.rms = rms;
                torque.share = rms / largest;
            }
        }
    }
    torques
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        for (freedom, expected) in [(3, 3.182), (6, 2.447), (16, 2.120), (31, 2.040)] {
            assert!(
                (student_95(freedom) / expected - 1.0).abs() < 0.01,
                "{freedom}"
            );
        }
        assert!(student_95(2).is_infinite());
    }
}
