//! Least squares over the robots that can exist.

use faer::Mat;

use crate::description::Physical;
use crate::estimate::possible::{Beside, Normal, Robots, known};
use crate::fit::Fitted;
use crate::model::{Model, Theta};
use crate::regression::System;

/// Distance below which the unconstrained estimate counts as that of a robot that can exist, in standard errors.
const SAME: f64 = 1e-3;

/// Returns the parameters of the robot that can exist and has the least squared residuals, \[p\]; `None` if the limits
/// contradict each other.
///
/// - `fitted`: least squares without constraints, with weighted rows.
/// - `speeds`: largest speed of each joint in the log, rad/s (m/s), \[n\].
pub(super) fn possible(
    model: &Model,
    settings: &Physical,
    system: &System,
    fitted: &Fitted,
    speeds: &[f64],
) -> Option<Theta> {
    let errors = &fitted.standard_error;
    let known = known(model, &fitted.identifiable, errors);
    let normal = Normal::new(model, system, fitted.weights())?;
    let normal = normal.scaled(&known, errors)?;
    let robots = Robots::new(model, settings, &fitted.theta, Beside::Log(speeds));
    let found = robots
        .best(&normal.information, &normal.gradient, &fitted.theta)
        .ok()?;
    let moved = Mat::from_fn(found.theta.len(), 1, |i, _| {
        found.theta[i] - fitted.theta[i]
    });
    let squares = (moved.transpose() * &normal.information * &moved)[(0, 0)];
    let is_same = squares < SAME * SAME;
    Some(if is_same {
        fitted.theta.clone()
    } else {
        found.theta
    })
}
