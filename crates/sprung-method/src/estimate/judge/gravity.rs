//! Tests whether a tilt of gravity, or another zero of a joint, explains the residual.

use crate::description::Experiment;
use crate::estimate::statistics::{LARGE_SHARE, NEGLIGIBLE_SHARE};
use crate::finding::{Finding, Severity};
use crate::fit::{fit_quickly, residual};
use crate::model::Model;
use crate::numbers::in_percent;
use crate::prepare::Excerpt;
use crate::regression::Reading;

/// A tilt is reported if the residual with it is below this fraction of the residual with the given
/// gravity.
const BETTER_RESIDUAL_SHARE: f64 = 0.7;

/// Number of samples used for the test, rounded up to whole blocks.
const SAMPLES_TESTED: usize = 4096;

/// Successive angles by which the search turns the best direction, degrees.
const TURNS_DEG: [f64; 5] = [20.0, 10.0, 5.0, 2.5, 1.25];

/// Angles by which the zero of a joint is tried, degrees: descriptions differ by right angles.
const ZEROS_DEG: [f64; 3] = [90.0, -90.0, 180.0];

/// Returns whether the test of a tilt of gravity is worthwhile.
///
/// - `worst`: largest residual of a torque row relative to its torque.
#[must_use]
pub(crate) fn tilt_is_possible(experiment: &Experiment, worst: f64) -> bool {
    let robot = &experiment.robot;
    robot.tree.is_some() && robot.gravity().iter().any(|g| *g != 0.0) && worst >= NEGLIGIBLE_SHARE
}

/// Reports a direction of gravity or a zero of a joint that explains the motor torques far better than the given ones, if
/// the search finds one. [`tilt_is_possible`] tells whether the search is worthwhile.
#[must_use]
pub(crate) fn tilted(
    experiment: &Experiment,
    reading: &Reading,
    excerpt: &Excerpt,
) -> Option<Finding> {
    let given = experiment.robot.gravity();
    let excerpt = excerpt.first(SAMPLES_TESTED);
    let now = unexplained(experiment, reading, &excerpt, given)?;
    let counts = |cost: f64| cost <= BETTER_RESIDUAL_SHARE * now;
    let cost = |direction| unexplained(experiment, reading, &excerpt, direction);
    let tilt = best_tilt(given, now, cost).filter(|(_, cost)| counts(*cost));
    let zero = best_zero(experiment, reading, &excerpt).filter(|zero| counts(zero.cost));
    let clearly =
        |one: f64, other: Option<f64>| other.is_none_or(|other| one < (1.0 - LARGE_SHARE) * other);
    let shares = |cost: f64| {
        format!(
            "the model leaves {:.1} % of the motor torques unexplained instead of {:.1} % (root mean \
             squares)",
            in_percent(cost),
            in_percent(now)
        )
    };
    if let Some(zero) = &zero
        && clearly(zero.cost, tilt.map(|(_, cost)| cost))
    {
        return Some(Finding::new(
            Severity::Warning,
            "zero-off",
            format!(
                "with {:.0}° added to the positions of {} {}: the zero of the log differs from that of the model",
                zero.moved_deg,
                zero.joint,
                shares(zero.cost)
            ),
            &format!("set {}", zero.remedy()),
        ));
    }
    let (direction, cost) = tilt?;
    let zero = zero.filter(|zero| !clearly(cost, Some(zero.cost)));
    let product: f64 = direction.iter().zip(given).map(|(a, b)| a * b).sum();
    let angle = (product / given.iter().map(|g| g * g).sum::<f64>())
        .clamp(-1.0, 1.0)
        .acos()
        .to_degrees();
    let shown = direction.map(|g| format!("{:.2}", g + 0.0)).join(", ");
    let (or_zero, or_set) = zero.map_or_else(Default::default, |zero| {
        (
            format!(
                ", or the zero of {} differs from that of the model by {:.0}°, which explains the torques as well",
                zero.joint,
                zero.moved_deg.abs()
            ),
            format!("; if the base is mounted as the file says, set {}", zero.remedy()),
        )
    });
    Some(Finding::new(
        Severity::Warning,
        "gravity-tilted",
        format!(
            "with gravity turned by {angle:.0}° in the base frame {}: the base is mounted differently from \
             what the file says{or_zero}",
            shares(cost)
        ),
        &format!("set gravity_m_per_s2 = [{shown}] in [robot]{or_set}"),
    ))
}

/// Returns the direction of gravity that explains the motor torques best, and the residual with it; `None` if none is
/// promising.
///
/// - `now`: the residual with the given direction; `cost`: that with another direction.
fn best_tilt(
    given: [f64; 3],
    now: f64,
    cost: impl Fn([f64; 3]) -> Option<f64>,
) -> Option<([f64; 3], f64)> {
    let size = given.iter().map(|g| g * g).sum::<f64>().sqrt();
    let mut best = (given, now);
    let attempt = |direction: [f64; 3], best: &mut ([f64; 3], f64)| {
        let cost = cost(direction).unwrap_or(f64::INFINITY);
        if cost < best.1 {
            *best = (direction, cost);
        }
    };
    for axis in 0..3 {
        for sign in [-size, size] {
            let mut direction = [0.0; 3];
            direction[axis] = sign;
            attempt(direction, &mut best);
        }
    }
    for towards in 0..6 {
        attempt(turned(given, towards, TURNS_DEG[2].to_radians()), &mut best);
    }
    if best.1 > (1.0 - LARGE_SHARE) * now {
        return None;
    }
    for turn in TURNS_DEG {
        for towards in 0..6 {
            attempt(turned(best.0, towards, turn.to_radians()), &mut best);
        }
    }
    Some(best)
}

/// Another zero of a joint.
struct Zero {
    joint: String,
    // Added to the positions, and the resulting offset of the experiment file, degrees.
    moved_deg: f64,
    offset_deg: f64,
    cost: f64,
}

impl Zero {
    fn remedy(&self) -> String {
        format!(
            "position_offset_deg = {:.0} in the block of {}",
            self.offset_deg, self.joint
        )
    }
}

/// Returns the zero of a joint that explains the motor torques best.
fn best_zero(experiment: &Experiment, reading: &Reading, excerpt: &Excerpt) -> Option<Zero> {
    let given = experiment.robot.gravity();
    let mut best: Option<Zero> = None;
    for (i, joint) in experiment.robot.joint.iter().enumerate() {
        if !reading.channels().turns[i] {
            continue;
        }
        for moved_deg in ZEROS_DEG {
            let mut channels = reading.channels().clone();
            channels.offsets[i] += moved_deg.to_radians();
            let moved = reading.with_channels(channels);
            let Some(cost) = unexplained(experiment, &moved, excerpt, given) else {
                continue;
            };
            if best.as_ref().is_none_or(|best| cost < best.cost) {
                let offset_deg = joint.position_offset_deg + moved_deg;
                best = Some(Zero {
                    joint: joint.name.clone(),
                    moved_deg,
                    offset_deg: 180.0 - (180.0 - offset_deg).rem_euclid(360.0),
                    cost,
                });
            }
        }
    }
    best
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
    let system = excerpt.reduce_thinned(&reading.with_model(model.clone()))?;
    let theta = fit_quickly(&model, &system)?;
    let rows = residual(&model, &system, &theta);
    // Each row is scaled by its joint's torque, so that small joints count as much as large ones.
    let parts = (0..model.rows()).map(|row| {
        let torque = rows[model.torque_row(model.joint_of(row))].1;
        (rows[row].0 / torque).powi(2)
    });
    Some((parts.sum::<f64>() / model.joint_count() as f64).sqrt())
}
