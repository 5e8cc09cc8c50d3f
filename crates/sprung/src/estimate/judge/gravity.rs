//! Gravity in the wrong frame: tests whether a tilt of gravity explains the residual.

use crate::description::Experiment;
use crate::finding::{Finding, Severity};
use crate::fit::{fit_quickly, residual};
use crate::model::Model;
use crate::prepare::Excerpt;
use crate::regression::Reading;

/// A tilt is reported if the residual with it is below this fraction of the residual with the given
/// gravity.
const BETTER_RESIDUAL_SHARE: f64 = 0.7;

/// Relative residual of a torque row above which the tilt of gravity is tested.
const SUSPICIOUS_RESIDUAL_SHARE: f64 = 0.01;

/// Number of samples used for the test, rounded up to whole blocks.
const SAMPLES_TESTED: usize = 4096;

/// The search continues after its coarse steps if the residual is below this fraction of the
/// initial residual.
const PROMISING_RESIDUAL_SHARE: f64 = 0.9;

/// Successive angles by which the search turns the best direction, degrees.
const TURNS_DEG: [f64; 5] = [20.0, 10.0, 5.0, 2.5, 1.25];

/// Returns whether the test of a tilt of gravity is worthwhile.
///
/// - `worst`: largest residual of a torque row relative to its torque.
#[must_use]
pub(crate) fn tilt_is_possible(experiment: &Experiment, worst: f64) -> bool {
    let robot = &experiment.robot;
    robot.tree.is_some()
        && robot.gravity().iter().any(|g| *g != 0.0)
        && worst >= SUSPICIOUS_RESIDUAL_SHARE
}

/// Reports a direction of gravity that explains the motor torques far better than the given one, if
/// the search finds one. [`tilt_is_possible`] tells whether the search is worthwhile.
#[must_use]
pub(crate) fn tilted(
    experiment: &Experiment,
    reading: &Reading,
    excerpt: &Excerpt,
) -> Option<Finding> {
    let given = experiment.robot.gravity();
    let size = given.iter().map(|g| g * g).sum::<f64>().sqrt();
    let excerpt = excerpt.first(SAMPLES_TESTED);
    let cost = |direction: [f64; 3]| unexplained(experiment, reading, &excerpt, direction);
    let now = cost(given)?;
    let mut best = (given, now);
    for axis in 0..3 {
        for sign in [-size, size] {
            let mut direction = [0.0; 3];
            direction[axis] = sign;
            let cost = cost(direction).unwrap_or(f64::INFINITY);
            if cost < best.1 {
                best = (direction, cost);
            }
        }
    }
    for towards in 0..6 {
        let direction = turned(given, towards, TURNS_DEG[2].to_radians());
        let cost = cost(direction).unwrap_or(f64::INFINITY);
        if cost < best.1 {
            best = (direction, cost);
        }
    }
    if best.1 > PROMISING_RESIDUAL_SHARE * now {
        return None;
    }
    for turn in TURNS_DEG {
        for towards in 0..6 {
            let direction = turned(best.0, towards, turn.to_radians());
            let cost = cost(direction).unwrap_or(f64::INFINITY);
            if cost < best.1 {
                best = (direction, cost);
            }
        }
    }
    let (direction, cost) = best;
    if cost > BETTER_RESIDUAL_SHARE * now {
        return None;
    }
    let product: f64 = direction.iter().zip(given).map(|(a, b)| a * b).sum();
    let angle = (product / (size * size))
        .clamp(-1.0, 1.0)
        .acos()
        .to_degrees();
    let shown = direction.map(|g| format!("{:.2}", g + 0.0)).join(", ");
    Some(Finding::new(
        Severity::Warning,
        "gravity-tilted",
        format!(
            "with gravity turned by {angle:.0}° in the base frame the model leaves {:.1} % of the \
             motor torques unexplained instead of {:.1} % (root mean squares): the base is mounted \
             differently from what the file says",
            100.0 * cost,
            100.0 * now
        ),
        &format!("set gravity_m_per_s2 = [{shown}] in [robot]"),
    ))
}

/// Returns a vector of the same length, turned towards one of the six half axes.
fn turned(v: [f64; 3], towards: usize, angle: f64) -> [f64; 3] {
    let size = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let mut moved = v;
    moved[towards / 2] += size * angle.tan() * if towards.is_multiple_of(2) { 1.0 } else { -1.0 };
    let length = moved.iter().map(|x| x * x).sum::<f64>().sqrt();
    moved.map(|x| x * size / length)
}

/// Returns the fraction of the motor torques that the model with a direction of gravity does not
/// explain (root mean square over all joints).
fn unexplained(
    experiment: &Experiment,
    reading: &Reading,
    excerpt: &Excerpt,
    direction: [f64; 3],
) -> Option<f64> {
    let mut changed = experiment.clone();
    changed.robot.gravity_m_per_s2 = Some(direction);
    let model = Model::new(&changed).ok()?;
    let system = excerpt.reduce(&reading.with_model(model.clone()))?;
    let theta = fit_quickly(&model, &system)?;
    let rows = residual(&model, &system, &theta);
    // Each row is scaled by its joint's torque, so that small joints count as much as large ones.
    let parts = (0..model.rows()).map(|row| {
        let torque = rows[model.torque_row(model.joint_of(row))].1;
        (rows[row].0 / torque).powi(2)
    });
    Some((parts.sum::<f64>() / model.joint_count() as f64).sqrt())
}
