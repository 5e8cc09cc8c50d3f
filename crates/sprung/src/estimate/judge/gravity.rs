//! Gravity in the wrong frame: a static residual that a tilt explains.

use crate::description::Experiment;
use crate::finding::{Finding, Severity};
use crate::fit::{fit_quickly, residual};
use crate::model::Model;
use crate::prepare::Excerpt;
use crate::regression::Reading;

/// Part of a residual that another direction must stay below to be mentioned.
const BETTER_RESIDUAL_SHARE: f64 = 0.7;

/// Residual of a torque's row from which gravity is looked at, as a part of it.
const SUSPICIOUS_RESIDUAL_SHARE: f64 = 0.01;

/// Samples that are looked at, to the end of their block.
const SAMPLES_LOOKED_AT: usize = 4096;

/// Part of a residual that a first look must come below to be followed.
const PROMISING_RESIDUAL_SHARE: f64 = 0.9;

/// Angles by which the best direction is turned, one after the other, degrees.
const TURNS_DEG: [f64; 5] = [20.0, 10.0, 5.0, 2.5, 1.25];

/// Returns whether a tilt of gravity is worth looking for.
///
/// - `worst`: largest residual of a torque's row, as a part of its torque.
#[must_use]
pub(crate) fn worth_a_look(experiment: &Experiment, worst: f64) -> bool {
    let robot = &experiment.robot;
    robot.tree.is_some()
        && robot.gravity().iter().any(|g| *g != 0.0)
        && worst >= SUSPICIOUS_RESIDUAL_SHARE
}

/// Says which direction of gravity explains the motor torques far better than
/// the one of the file, if there is one; see [`worth_a_look`] before.
#[must_use]
pub(crate) fn tilted(
    experiment: &Experiment,
    reading: &Reading,
    excerpt: &Excerpt,
) -> Option<Finding> {
    let given = experiment.robot.gravity();
    let size = given.iter().map(|g| g * g).sum::<f64>().sqrt();
    let excerpt = excerpt.first(SAMPLES_LOOKED_AT);
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
             otherwise than the file says",
            100.0 * cost,
            100.0 * now
        ),
        &format!("set gravity_m_per_s2 = [{shown}] in [robot]"),
    ))
}

/// Returns a vector turned towards one of the six half axes, its length kept.
fn turned(v: [f64; 3], towards: usize, angle: f64) -> [f64; 3] {
    let size = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let mut moved = v;
    moved[towards / 2] += size * angle.tan() * if towards.is_multiple_of(2) { 1.0 } else { -1.0 };
    let length = moved.iter().map(|x| x * x).sum::<f64>().sqrt();
    moved.map(|x| x * size / length)
}

/// Returns the part of the motor torques that a direction of gravity leaves
/// unexplained, root mean squares over all joints.
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
    // Each row as a part of its joint's torque, so that small joints count.
    let parts = (0..model.rows()).map(|row| {
        let torque = rows[model.torque_row(model.joint_of(row))].1;
        (rows[row].0 / torque).powi(2)
    });
    Some((parts.sum::<f64>() / model.joint_count() as f64).sqrt())
}
