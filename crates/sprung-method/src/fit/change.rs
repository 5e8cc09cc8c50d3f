//! Least squares along a few directions from a given parameter vector.

use super::jackknife::{influences, scatter};
use crate::model::Model;
use crate::regression::{System, SystemPart, Triangle, solve};

/// Number of segments that are left out in turn for the standard errors.
const SEGMENTS: usize = 16;

/// A direction in which a solution may move.
#[derive(Clone, Debug)]
pub(crate) enum Direction {
    /// A change of the parameters, \[p\].
    Parameters(Vec<f64>),
    /// A relative change of the logged torque of a row.
    Torque(usize),
}

/// Steps along directions.
#[derive(Clone, Debug)]
pub(crate) struct Steps {
    /// Step along each direction.
    pub(crate) sizes: Vec<f64>,
    /// Standard error of each step; infinite if it is not determined.
    pub(crate) errors: Vec<f64>,
}

/// Returns the steps from `theta` that minimise the squared residuals, each row divided by its
/// scale; `None` without samples or if a number is not finite. Directions that the system does not
/// separate share the shortest step.
///
/// - `scales`: by row, N·m (N), positive.
pub(crate) fn steps_along(
    model: &Model,
    system: &System,
    theta: &[f64],
    directions: &[Direction],
    scales: &[f64],
) -> Option<Steps> {
    let columns: Vec<usize> = (0..directions.len()).collect();
    let along = |factors: Vec<Triangle>| -> Vec<Triangle> {
        (factors.iter().enumerate())
            .map(|(row, factor)| {
                let with_rhs = |theta: &[f64], rhs: f64| -> Vec<f64> {
                    let of_row = model.row_columns(row).iter().map(|&c| theta[c]);
                    of_row.chain([rhs]).collect()
                };
                let moved: Vec<Vec<f64>> = (directions.iter())
                    .map(|direction| match direction {
                        Direction::Parameters(change) => with_rhs(change, 0.0),
                        Direction::Torque(other) => {
                            let zero = vec![0.0; theta.len()];
                            with_rhs(&zero, if *other == row { -1.0 } else { 0.0 })
                        }
                    })
                    .collect();
                (factor.along(&with_rhs(theta, -1.0), &moved)).scaled(1.0 / scales[row])
            })
            .collect()
    };
    let whole = along(system.whole()?);
    let parts: Vec<SystemPart<'_>> = (whole.iter())
        .map(|factor| SystemPart {
            columns: &columns,
            factor,
        })
        .collect();
    let solution = solve(&parts, directions.len())?;
    let groups: Vec<Vec<Triangle>> = system.groups(SEGMENTS).into_iter().map(along).collect();
    let of_rows = vec![columns.clone(); whole.len()];
    let mut errors = scatter(&influences(&solution, &of_rows, &groups));
    for (error, known) in errors.iter_mut().zip(&solution.identifiable) {
        if !known {
            *error = f64::INFINITY;
        }
    }
    Some(Steps {
        sizes: solution.x,
        errors,
    })
}
