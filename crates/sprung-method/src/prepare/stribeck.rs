//! Finds Stribeck velocities by an outer search, because the regression is not linear in them.

use sprung_core::friction::{Law, Scale};
use sprung_core::parameters::{JointParameter, Side};

use super::excerpt::Excerpt;
use super::velocity_by_likelihood::VelocityByLikelihood;
use crate::finding::{Finding, Severity};
use crate::log::Quantity;
use crate::model::Model;
use crate::regression::{Reading, SystemPart, Triangle, solve};

/// Range of the velocities in the search, as fractions of the joint's fastest motion.
const SLOWEST_SHARE: f64 = 0.003;
const FASTEST_SHARE: f64 = 0.5;

/// Width of the widest element of presliding friction over the root mean square of the joint's velocity, s.
const PRESLIDING_S: f64 = 0.2;

/// Width of the widest element of hysteresis over the standard deviation of the deflection.
const HYSTERESIS_SHARE: f64 = 2.0;

/// Largest width over the range of the deflection.
const SLIDING_SHARE: f64 = 0.25;

/// Velocities in the first scan, in equal ratios.
const VELOCITIES_TRIED: usize = 9;

/// Golden-section steps about the best velocity.
const GOLDEN_SECTIONS: usize = 8;

/// Finds the Stribeck velocities that a description leaves open.
///
/// Returns the model with them, and findings. If the log contains no motion of a joint, the model
/// stays unchanged.
///
/// The rows of different joints do not affect each other, so all joints are searched at once: first
/// velocities in equal ratios, then steps of the golden section about the best velocity.
#[must_use]
pub(crate) fn find_stribeck(
    reading: &Reading,
    excerpt: &Excerpt,
) -> (Model, Vec<(usize, Finding)>) {
    let model = reading.model();
    let joints = model.unknown_stribeck();
    let Some(fastest) = fastest(reading, excerpt) else {
        return (model.clone(), Vec::new());
    };
    let cost = |at: &[f64]| -> Vec<f64> {
        let changed = with(model, joints, at);
        let reading = reading.with_model(changed.clone());
        let whole = excerpt.reduce(&reading).and_then(|system| system.whole());
        joints
            .iter()
            .map(|&joint| {
                let whole = whole.as_deref().unwrap_or_default();
                unexplained(&changed, whole, joint).unwrap_or(f64::INFINITY)
            })
            .collect()
    };
    // The search runs over logarithms of velocities relative to the fastest motion.
    let (low, high) = (SLOWEST_SHARE.ln(), FASTEST_SHARE.ln());
    let distance = (high - low) / (VELOCITIES_TRIED - 1) as f64;
    let velocity = |logs: &[f64]| -> Vec<f64> {
        (logs.iter().zip(joints))
            .map(|(log, &joint)| fastest[joint] * log.exp())
            .collect()
    };
    let mut best: Vec<(f64, f64)> = vec![(low, f64::INFINITY); joints.len()];
    for k in 0..VELOCITIES_TRIED {
        let log = low + distance * k as f64;
        let costs = cost(&velocity(&vec![log; joints.len()]));
        for (best, cost) in best.iter_mut().zip(costs) {
            if cost < best.1 {
                *best = (log, cost);
            }
        }
    }
    let at_edge: Vec<bool> = (best.iter())
        .map(|(log, _)| log - low < 0.5 * distance || high - log < 0.5 * distance)
        .collect();
    let mut reach = distance;
    for _ in 0..GOLDEN_SECTIONS {
        reach *= 0.618;
        for side in [-reach, reach] {
            let tried: Vec<f64> = best.iter().map(|(log, _)| log + side).collect();
            let costs = cost(&velocity(&tried));
            for ((best, tried), cost) in best.iter_mut().zip(tried).zip(costs) {
                if cost < best.1 {
                    *best = (tried, cost);
                }
            }
        }
    }
    let found = velocity(&best.iter().map(|(log, _)| *log).collect::<Vec<_>>());
    let findings = (joints.iter().zip(&found).zip(at_edge))
        .map(|((&joint, velocity), at_edge)| (joint, finding_for(model, joint, *velocity, at_edge)))
        .collect();
    (with(model, joints, &found), findings)
}

fn with(model: &Model, joints: &[usize], velocities: &[f64]) -> Model {
    (joints.iter().zip(velocities)).fold(model.clone(), |model, (&joint, &velocity)| {
        model.with_stribeck(joint, velocity)
    })
}

fn finding_for(model: &Model, joint: usize, velocity: f64, at_edge: bool) -> Finding {
    let name = &model.joints()[joint];
    if at_edge {
        return Finding::new(
            Severity::Warning,
            "stribeck-velocity-not-found",
            format!(
                "{name}: no Stribeck velocity between {SLOWEST_SHARE} and {FASTEST_SHARE} of the fastest motion \
                 explains the log better than its neighbours; {velocity:.3e} rad/s (m/s) is used"
            ),
            "leave \"stribeck\" out, or record slow motion; give stribeck_velocity_rad_per_s if it \
             is known",
        );
    }
    Finding::new(
        Severity::Info,
        "stribeck-velocity",
        format!(
            "{name}: the Stribeck velocity was found by a search over the beginning of the log, \
             {velocity:.4} rad/s (m/s); the standard errors of the other parameters treat it as known"
        ),
        "give it as stribeck_velocity_rad_per_s to keep it fixed",
    )
}

/// Returns the finding about a Stribeck velocity that the likelihood gives.
pub(super) fn by_likelihood(model: &Model, found: &VelocityByLikelihood) -> Finding {
    Finding::new(
        Severity::Info,
        "stribeck-velocity",
        format!(
            "{}: the Stribeck velocity is {:.4} rad/s (m/s) (standard error {:.4}), by the likelihood \
             of the log",
            model.joints()[found.joint],
            found.velocity,
            found.standard_error
        ),
        "give it as stribeck_velocity_rad_per_s to keep it fixed",
    )
}

/// Returns the model with the widths of presliding friction and hysteresis that the description leaves open, of all joints: the
/// search for laws uses them before a joint has these laws.
#[must_use]
pub(crate) fn with_widths(reading: &Reading, excerpt: &Excerpt) -> Model {
    let mut model = reading.model().clone();
    let speeds = rms_speeds(reading, excerpt);
    for &joint in reading.model().open_presliding() {
        if speeds[joint] > 0.0 {
            model.set_scale(joint, Scale::Presliding, PRESLIDING_S * speeds[joint]);
        }
    }
    for &joint in reading.model().open_hysteresis() {
        if let Some(deflection) = deflection(reading, excerpt, joint) {
            // An element that never slides is part of the stiffness.
            let width = (HYSTERESIS_SHARE * deflection.rms).min(SLIDING_SHARE * deflection.range);
            model.set_hysteresis_width(joint, width);
        }
    }
    model
}

/// Deflection of a joint in a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Deflection {
    /// Mean, rad (m).
    pub(super) mean: f64,
    /// Standard deviation, rad (m).
    pub(super) rms: f64,
    /// Largest minus smallest, rad (m).
    pub(super) range: f64,
}

/// Returns the deflection of a joint; `None` if two encoders do not show it.
pub(super) fn deflection(reading: &Reading, excerpt: &Excerpt, joint: usize) -> Option<Deflection> {
    if reading.model().robot().coupling.is_some() {
        return None;
    }
    let channel = |quantity| reading.channels().index(quantity, joint);
    let [motor, link] = [Quantity::MotorPosition, Quantity::LinkPosition].map(channel);
    let (motor, link) = (motor?, link?);
    let (mut count, mut sum, mut squares) = (0.0, 0.0, 0.0);
    let (mut least, mut largest) = (f64::INFINITY, f64::NEG_INFINITY);
    for block in excerpt.blocks() {
        for (phi, q) in block.values[motor].iter().zip(&block.values[link]) {
            let deflection = phi - q;
            count += 1.0;
            sum += deflection;
            squares += deflection * deflection;
            least = least.min(deflection);
            largest = largest.max(deflection);
        }
    }
    let mean = sum / f64::max(count, 1.0);
    let variance = squares / f64::max(count, 1.0) - mean * mean;
    (variance > 0.0).then(|| Deflection {
        mean,
        rms: variance.sqrt(),
        range: largest - least,
    })
}

/// Returns the root mean square of each joint's velocity, rad/s (m/s).
#[must_use]
pub(crate) fn rms_speeds(reading: &Reading, excerpt: &Excerpt) -> Vec<f64> {
    let n = reading.model().joint_count();
    let (mut squares, mut counts) = (vec![0.0_f64; n], vec![0.0_f64; n]);
    speeds(reading, excerpt, |joint, speed| {
        squares[joint] += speed * speed;
        counts[joint] += 1.0;
    });
    (squares.iter().zip(counts))
        .map(|(squares, count)| (squares / count.max(1.0)).sqrt())
        .collect()
}

/// Returns the fastest speed of each joint, rad/s (m/s); `None` if a joint does not move.
fn fastest(reading: &Reading, excerpt: &Excerpt) -> Option<Vec<f64>> {
    let mut fastest = vec![0.0_f64; reading.model().joint_count()];
    speeds(reading, excerpt, |joint, speed| {
        fastest[joint] = fastest[joint].max(speed);
    });
    fastest.iter().all(|v| *v > 0.0).then_some(fastest)
}

/// Calls `see` with joint and speed, rad/s (m/s), at every sample.
fn speeds(reading: &Reading, excerpt: &Excerpt, mut see: impl FnMut(usize, f64)) {
    for (i, channel) in reading.channels().all.iter().enumerate() {
        if channel.quantity != Quantity::MotorPosition {
            continue;
        }
        // Differences over 0.02 s, because the difference over one count would be a high speed.
        let apart = (0.02 / excerpt.period()).round().max(1.0);
        for block in excerpt.blocks() {
            let values = &block.values[i];
            let pairs = values.iter().zip(values.iter().skip(apart as usize));
            for (a, b) in pairs {
                see(channel.joint, (b - a).abs() / (apart * excerpt.period()));
            }
        }
    }
}

/// Returns the sum of squared residuals of the rows with a joint's Stribeck friction. The link row
/// is solved with the stiffness of the motor row, because it has no right-hand side.
fn unexplained(model: &Model, whole: &[Triangle], joint: usize) -> Option<f64> {
    let torque_row = model.torque_row(joint);
    let (x, of_motor) = solved(whole.get(torque_row)?)?;
    let on_link = model
        .index(JointParameter::Friction(Side::Link, Law::Stribeck), joint)
        .is_some();
    if !on_link || torque_row == joint {
        return Some(of_motor);
    }
    let stiffness = model.index(JointParameter::Stiffness, joint)?;
    let at = |row: usize| model.row_columns(row).iter().position(|&c| c == stiffness);
    let mut known = vec![None; model.row_columns(joint).len()];
    known[at(joint)?] = Some(x[at(torque_row)?]);
    let (_, of_link) = solved(&whole.get(joint)?.with_known(&known))?;
    Some(of_motor + of_link)
}

/// Returns the solution of one row and the sum of its squared residuals.
pub(super) fn solved(factor: &Triangle) -> Option<(Vec<f64>, f64)> {
    let local: Vec<usize> = (0..factor.unknowns()).collect();
    let part = SystemPart {
        columns: &local,
        factor,
    };
    let x = solve(&[part], local.len())?.x;
    let squares = factor.residual(&x).iter().map(|r| r * r).sum();
    Some((x, squares))
}
