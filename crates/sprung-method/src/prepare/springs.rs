//! Finds the stiffnesses of joints with torque sensor from the beginning of a log.
//!
//! Beside a link encoder, the row of the sensor gives the stiffness. Without link encoder the link
//! position depends on the stiffness, so successive estimates are needed. They are steps in the
//! compliance, in which the link position is linear.

use sprung_core::parameters::JointParameter;

use super::excerpt::Excerpt;
use crate::description::SpringTorque;
use crate::finding::{Finding, Severity};
use crate::fit::{fit, fit_values};
use crate::log::Signal;
use crate::model::Theta;
use crate::numbers::Shown;
use crate::regression::{Reading, System};

/// Largest number of successive estimates, and relative change of a compliance at which they end.
const MAX_ESTIMATES: usize = 10;
const SETTLED: f64 = 1e-3;

/// Deflection under the largest torque at the first stiffness without nominal value, rad (m).
const FIRST_DEFLECTION: f64 = 1e-3;

/// Limit of the change of a stiffness in one step, and of its ratio to the start with and without
/// nominal value.
const MAX_STEP: f64 = 5.0;
const MAX_RATIO_TO_NOMINAL: f64 = 4.0;
const MAX_RATIO_TO_GUESS: f64 = 1e3;

/// Half width of a 95 % interval from the segments of the beginning of a log, in standard errors.
const STUDENT_SIGMAS: f64 = 2.0;

/// Standard error over value from which a stiffness counts as open.
pub(crate) const OPEN_STIFFNESS: f64 = 0.3;

/// Returns the reading with the stiffnesses of joints with torque sensor, and findings about joints
/// without link encoder; the same reading without torque sensors.
#[must_use]
pub(super) fn find_springs(reading: &Reading, excerpt: &Excerpt) -> (Reading, Vec<Finding>) {
    let (model, channels) = (reading.model(), reading.channels());
    let sensors: Vec<(usize, usize, usize)> = (0..model.joint_count())
        .filter(|&joint| channels.instruments.at(joint).spring_torque() == SpringTorque::Measured)
        .filter_map(|joint| {
            let channel = channels.telling(Signal::Spring, joint)?;
            Some((
                joint,
                channel,
                model.index(JointParameter::Stiffness, joint)?,
            ))
        })
        .collect();
    if sensors.is_empty() {
        return (reading.clone(), Vec::new());
    }
    let mut theta = vec![0.0; model.parameters().len()];
    for &(_, channel, stiffness) in &sensors {
        let largest =
            (excerpt.channel(channel)).fold(0.0_f64, |most, torque| most.max(torque.abs()));
        let parameter = &model.parameters()[stiffness];
        let known = parameter.fixed.or(parameter.nominal).filter(|k| *k > 0.0);
        theta[stiffness] = known.unwrap_or((largest / FIRST_DEFLECTION).max(f64::MIN_POSITIVE));
    }
    let first = theta.clone();
    let without_link = model.joints_without_link();
    let mut last = None;
    for estimate in 0..MAX_ESTIMATES {
        let Some((reading, system)) = reduced(reading, excerpt, &theta) else {
            break;
        };
        let Some(mut found) = fit_values(model, &system) else {
            break;
        };
        let mut moved = 0.0_f64;
        for &(joint, _, stiffness) in &sensors {
            let before = theta[stiffness];
            if !without_link.contains(&joint) {
                if found[stiffness].is_nan() || found[stiffness] <= 0.0 {
                    found[stiffness] = before;
                }
            } else if estimate == 0 {
                // The columns of the stiffnesses need an estimate of the other parameters.
                found[stiffness] = before;
                moved = f64::INFINITY;
            } else {
                let ratio = 1.0 - (found[stiffness] - before) / before;
                let ratio = ratio.clamp(MAX_STEP.recip(), MAX_STEP);
                let reach = match model.parameters()[stiffness].nominal {
                    Some(_) => MAX_RATIO_TO_NOMINAL,
                    None => MAX_RATIO_TO_GUESS,
                };
                let start = first[stiffness];
                found[stiffness] = (before / ratio).clamp(start / reach, start * reach);
                let ratio = before / found[stiffness];
                moved = moved.max((ratio - 1.0).abs());
            }
        }
        theta = found;
        last = Some((reading, system));
        if moved < SETTLED {
            break;
        }
    }
    let fitted = last.filter(|_| !without_link.is_empty());
    let fitted = fitted.and_then(|(reading, system)| {
        let about = reading.model().springs()?.clone();
        Some((fit(reading.model(), &system, reading.memory())?, about))
    });
    // A refinement starts from the first values.
    let is_refined = reading.is_refined();
    let (mut open, mut known) = (Vec::new(), Vec::new());
    for &(joint, _, stiffness) in &sensors {
        let (parameter, name) = (&model.parameters()[stiffness], &model.joints()[joint]);
        let Some((fitted, about)) = fitted.as_ref().filter(|_| without_link.contains(&joint))
        else {
            continue;
        };
        let share = fitted.standard_error[stiffness] / fitted.theta[stiffness].abs();
        if parameter.fixed.is_some() {
            continue;
        }
        if !fitted.identifiable[stiffness] || share.is_nan() || share > OPEN_STIFFNESS {
            let estimate = (fitted.theta[stiffness], fitted.standard_error[stiffness]);
            theta[stiffness] = least_stiffness(about[stiffness], estimate)
                .filter(|_| fitted.identifiable[stiffness] && !is_refined)
                .unwrap_or(first[stiffness]);
            open.push((name.clone(), parameter.name.clone()));
        } else {
            let percent = Shown((1000.0 * share).round() / 10.0);
            known.push((format!("{name} within {percent} %"), parameter.name.clone()));
        }
    }
    let findings = [is_open(open), is_known(known)].into_iter().flatten();
    (reading.with_springs(&theta), findings.collect())
}

/// Returns the least stiffness that an estimate allows whose compliance is not significant, N·m/rad (N/m).
///
/// - `about`: stiffness about which the equations are linear; `stiffness`: estimate and standard error.
fn least_stiffness(about: f64, (stiffness, error): (f64, f64)) -> Option<f64> {
    let compliance = (2.0 - stiffness / about) / about;
    let half = STUDENT_SIGMAS * error / about.powi(2);
    let least = (compliance.max(0.0) + half).recip();
    (compliance < half && least.is_finite()).then_some(least)
}

fn reduced(reading: &Reading, excerpt: &Excerpt, theta: &Theta) -> Option<(Reading, System)> {
    let with_springs = reading.with_springs(theta);
    let system = (excerpt.smoothed(&with_springs)?.thinned(reading)).reduce(&with_springs)?;
    Some((with_springs, system))
}

/// Returns a finding that the log leaves stiffnesses open.
///
/// - `joints`: names of joints and of their stiffnesses.
fn is_open(joints: Vec<(String, String)>) -> Option<Finding> {
    if joints.is_empty() {
        return None;
    }
    let (names, parameters): (Vec<String>, Vec<String>) = joints.into_iter().unzip();
    Some(
        Finding::new(
            Severity::Warning,
            "stiffness-open",
            format!(
                "joints with torque sensor and without link encoder: the beginning of the log hardly \
                 determines the stiffness of {}, because the deflection has too little effect on the motion. \
                 Their links are taken to move almost with the motors",
                names.join(", ")
            ),
            "use the prediction-error estimator, record higher accelerations, or give the stiffness of the \
             maker under [robot.fixed]",
        )
        .about(parameters),
    )
}

/// Returns a finding about the uncertainty of stiffnesses.
///
/// - `joints`: names of joints with their uncertainties, and names of their stiffnesses.
fn is_known(joints: Vec<(String, String)>) -> Option<Finding> {
    if joints.is_empty() {
        return None;
    }
    let (names, parameters): (Vec<String>, Vec<String>) = joints.into_iter().unzip();
    Some(
        Finding::new(
            Severity::Info,
            "link-by-torque-sensor",
            format!(
                "joints with torque sensor and without link encoder: the link position is the motor position \
                 minus torque over stiffness, and the stiffness follows from the motion of the links. The \
                 beginning of the log determines it by least squares (one standard error): {}",
                names.join(", ")
            ),
            "nothing; the prediction-error estimator is more accurate, and a link encoder gives the stiffness \
             directly",
        )
        .about(parameters),
    )
}
