//! Least squares over the robots that can exist.

use faer::Mat;

use crate::description::Physical;
use crate::estimate::possible::{BESIDE_LOG, Normal, Robots};
use crate::fit::Fitted;
use crate::model::{Model, NoSolution, Theta};
use crate::regression::System;

/// Distance below which the unconstrained estimate counts as that of a robot that can exist, in standard errors.
const SAME: f64 = 1e-3;

/// Returns the parameters of the robot that can exist and has the least squared residuals, \[p\].
///
/// - `fitted`: least squares without constraints, with weighted rows.
/// - `speeds`: largest speed of each joint in the log, rad/s (m/s), \[n\].
///
/// # Errors
///
/// The reason why there is no such robot.
pub(super) fn possible(
    model: &Model,
    settings: &Physical,
    system: &System,
    fitted: &Fitted,
    speeds: &[f64],
) -> Result<Theta, String> {
    let robots = Robots::new(model, (settings, BESIDE_LOG), speeds);
    let known: Vec<usize> = (0..fitted.theta.len())
        .filter(|&i| fitted.identifiable[i] && model.parameters()[i].fixed.is_none())
        .filter(|&i| fitted.standard_error[i] > 0.0 && fitted.standard_error[i].is_finite())
        .collect();
    let normal = Normal::new(model, system, fitted.weights())
        .and_then(|normal| normal.scaled(&known, &fitted.standard_error));
    let Some(normal) = normal else {
        return Err(robots.why(NoSolution::Singular));
    };
    let found = robots
        .best(&normal.information, &normal.gradient, &fitted.theta)
        .map_err(|reason| robots.why(reason))?;
    let moved = Mat::from_fn(found.theta.len(), 1, |i, _| {
        found.theta[i] - fitted.theta[i]
    });
    let squares = (moved.transpose() * &normal.information * &moved)[(0, 0)];
    if squares < SAME * SAME {
        return Ok(fitted.theta.clone());
    }
    Ok(found.theta)
}
