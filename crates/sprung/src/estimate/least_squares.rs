//! Least squares on the filtered regression.

use faer::Mat;
use sprung_core::drives::MOTOR_SIDE;

use crate::model::{JOINT_COUNT, Model, ROWS, Theta};
use crate::regression::{Solution, System, SystemPart, Triangle, solve, solve_quickly};

/// Stretches of the log whose scatter gives the standard errors, at most.
const GROUPS: usize = 32;

/// A parameter vector with its uncertainty.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// Solution of the stacked system.
    pub solution: Solution,
    /// Standard error of each parameter.
    pub standard_error: Vec<f64>,
    /// Half width of a 95 % interval in standard errors.
    pub interval: f64,
    /// The motor rows alone, one per joint.
    pub motor_rows: Vec<MotorRow>,
}

impl Fitted {
    /// Returns the parameter vector.
    #[must_use]
    pub fn theta(&self) -> Theta {
        let mut theta = Theta::default();
        theta.copy_from_slice(&self.solution.x);
        theta
    }
}

/// What the motor row of a joint says by itself.
///
/// It has a right-hand side, the torque, so nothing pulls its scale down.
#[derive(Clone, Debug)]
pub struct MotorRow {
    /// Values of the kinds in [`MOTOR_SIDE`].
    pub values: [f64; MOTOR_SIDE.len()],
    /// Their standard errors.
    pub standard_error: [f64; MOTOR_SIDE.len()],
    /// Whether the row determines them.
    pub identifiable: [bool; MOTOR_SIDE.len()],
    /// Condition number, columns as they stand.
    pub condition_number: f64,
    /// Residual over torque, root mean squares.
    pub relative_residual: f64,
}

/// Solves the stacked system and each motor row alone.
///
/// Returns nothing if the log is empty or a number is not finite.
///
/// Standard errors come from the scatter of the normal equations between up to
/// 32 stretches of the log, so they hold for residuals of any colour and level.
/// They say how much the stretches disagree, which is more than repeated runs
/// scatter; a bias that all stretches share, as by quantised positions through
/// the Coulomb transition, is not in them.
///
/// # Source
///
/// Eq. (28).
#[must_use]
pub fn fit(model: &Model, system: &System) -> Option<Fitted> {
    let whole = system.whole()?;
    let groups = system.groups(GROUPS);
    let columns: Vec<&[usize]> = (0..ROWS).map(|row| model.row_columns(row)).collect();
    let solution = solve(&parts(&columns, &whole), model.parameters().len())?;
    let standard_error = scatter(&solution, &columns, &groups);

    let motor_rows = (0..JOINT_COUNT)
        .map(|joint| {
            let row = JOINT_COUNT + joint;
            let local: Vec<usize> = (0..MOTOR_SIDE.len()).collect();
            let part = SystemPart {
                columns: &local,
                factor: &whole[row],
            };
            let solution = solve(&[part], MOTOR_SIDE.len())?;
            let own: Vec<Vec<Triangle>> = groups.iter().map(|g| vec![g[row].clone()]).collect();
            let errors = scatter(&solution, &[&local], &own);
            let length = |v: &[f64]| v.iter().map(|r| r * r).sum::<f64>().sqrt();
            Some(MotorRow {
                values: std::array::from_fn(|i| solution.x[i]),
                standard_error: std::array::from_fn(|i| errors[i]),
                identifiable: std::array::from_fn(|i| solution.identifiable[i]),
                condition_number: solution.condition_number,
                relative_residual: length(&whole[row].residual(&solution.x))
                    / whole[row].rhs_norm(),
            })
        })
        .collect::<Option<_>>()?;
    Some(Fitted {
        solution,
        standard_error,
        interval: student_95(groups.len().saturating_sub(1)),
        motor_rows,
    })
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
) -> impl Iterator<Item = (f64, Option<Vec<f64>>)> + 'a {
    let columns: Vec<&[usize]> = (0..ROWS).map(|row| model.row_columns(row)).collect();
    system.growing().map(move |(time, factors)| {
        let x = solve_quickly(&parts(&columns, &factors), model.parameters().len());
        (time, x)
    })
}

/// Returns root mean squares of the residual and of the right-hand side of
/// each row, N·m.
#[must_use]
pub fn residual(model: &Model, system: &System, theta: &Theta) -> Vec<(f64, f64)> {
    let scale = 1.0 / (system.samples().max(1) as f64).sqrt();
    system
        .whole()
        .unwrap_or_default()
        .iter()
        .enumerate()
        .map(|(row, factor)| {
            let x: Vec<f64> = model.row_columns(row).iter().map(|&c| theta[c]).collect();
            let squares: f64 = factor.residual(&x).iter().map(|r| r * r).sum();
            (scale * squares.sqrt(), scale * factor.rhs_norm())
        })
        .collect()
}

/// Returns the torque that each parameter stands for in the log: the root mean
/// square of its column times its value, N·m, and its share of the largest such
/// torque of the row; for a parameter of two rows, where the torque is larger.
#[must_use]
pub fn torques(model: &Model, system: &System, theta: &Theta) -> Vec<(f64, f64)> {
    let scale = 1.0 / (system.samples().max(1) as f64).sqrt();
    let mut torques = vec![(0.0, 0.0); theta.len()];
    for (row, factor) in system.whole().unwrap_or_default().iter().enumerate() {
        let columns = model.row_columns(row);
        let own: Vec<f64> = (columns.iter().enumerate())
            .map(|(j, &column)| scale * factor.column_norm(j) * theta[column].abs())
            .collect();
        let largest = own.iter().copied().fold(0.0, f64::max);
        for (&column, torque) in columns.iter().zip(own) {
            if torque > torques[column].0 {
                torques[column] = (torque, torque / largest);
            }
        }
    }
    torques
}

fn parts<'a>(columns: &[&'a [usize]], factors: &'a [Triangle]) -> Vec<SystemPart<'a>> {
    columns
        .iter()
        .zip(factors)
        .map(|(columns, factor)| SystemPart { columns, factor })
        .collect()
}

/// Standard errors from the scatter of the gradients of the groups.
fn scatter(solution: &Solution, columns: &[&[usize]], groups: &[Vec<Triangle>]) -> Vec<f64> {
    let p = solution.x.len();
    let mut gradients = Mat::<f64>::zeros(p, groups.len());
    for (g, factors) in groups.iter().enumerate() {
        for (columns, factor) in columns.iter().zip(factors) {
            let x: Vec<f64> = columns.iter().map(|&c| solution.x[c]).collect();
            for (&c, value) in columns.iter().zip(factor.gradient(&x)) {
                gradients[(c, g)] += value;
            }
        }
    }
    let spread = &solution.inverse * &gradients;
    let count = groups.len() as f64;
    let correction = if count > 1.0 {
        count / (count - 1.0)
    } else {
        f64::INFINITY
    };
    (0..p)
        .map(|i| {
            let squares: f64 = (0..groups.len()).map(|g| spread[(i, g)].powi(2)).sum();
            (correction * squares).sqrt()
        })
        .collect()
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
