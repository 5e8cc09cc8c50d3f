//! Finds the stiffnesses of joints with torque sensor from the beginning of a log.
//!
//! Beside a link encoder, the row of the sensor gives the stiffness. Without link encoder the link
//! position depends on the stiffness, so successive estimates are needed. They are steps in the
//! compliance, in which the link position is linear.

use sprung_core::parameters::JointParameter;

use super::excerpt::Excerpt;
use crate::finding::{Finding, Severity};
use crate::fit::{Fitted, fit, fit_values};
use crate::log::Signal;
use crate::model::{Model, Theta};
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

/// Standard error over value from which a stiffness counts as open.
const OPEN_STIFFNESS: f64 = 0.3;

/// Returns the reading with the stiffnesses of joints with torque sensor, and findings about joints
/// without link encoder; the same reading without torque sensors.
#[must_use]
pub(super) fn find_springs(reading: &Reading, excerpt: &Excerpt) -> (Reading, Vec<Finding>) {
    let (model, channels) = (reading.model(), reading.channels());
    let sensors: Vec<(usize, usize, usize)> = (0..model.joint_count())
        .filter_map(|joint| {
            let channel = channels.telling(Signal::Spring, joint)?;
            Some((joint, channel, model.index(JointParameter::Stiffness, joint)?))
        })
        .collect();
    if sensors.is_empty() {
        return (reading.clone(), Vec::new());
    }
    let mut theta = vec![0.0; model.parameters().len()];
    for &(_, channel, stiffness) in &sensors {
        let largest = (excerpt.channel(channel)).fold(0.0_f64, |most, torque| most.max(torque.abs()));
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
    let mut findings = Vec::new();
    let fitted = last.filter(|_| !without_link.is_empty());
    let fitted = fitted.and_then(|(own, system)| fit(own.model(), &system, own.memory()));
    if let Some(fitted) = fitted {
        for &joint in &without_link {
            let Some((finding, is_open)) = about(model, &fitted, joint) else {
                continue;
            };
            findings.push(finding);
            if is_open && let Some(index) = model.index(JointParameter::Stiffness, joint) {
                theta[index] = first[index];
            }
        }
    }
    (reading.with_springs(&theta), findings)
}

fn reduced(reading: &Reading, excerpt: &Excerpt, theta: &Theta) -> Option<(Reading, System)> {
    let own = reading.with_springs(theta);
    let system = (excerpt.smoothed(&own)?.thinned(reading)).reduce(&own)?;
    Some((own, system))
}

/// Returns a finding about a joint without link encoder, the uncertainty of its stiffness, and whether
/// the log leaves the stiffness open; `None` if it is known.
fn about(model: &Model, fitted: &Fitted, joint: usize) -> Option<(Finding, bool)> {
    let index = model.index(JointParameter::Stiffness, joint)?;
    let parameter = &model.parameters()[index];
    if parameter.fixed.is_some() {
        return None;
    }
    let share = fitted.standard_error[index] / fitted.theta[index].abs();
    let is_open = !fitted.identifiable[index] || share.is_nan() || share > OPEN_STIFFNESS;
    let name = &model.joints()[joint];
    let (severity, code, certainty, remedy) = if is_open {
        (
            Severity::Warning,
            "stiffness-open",
            "hardly determines it: the deflection has too little effect on the motion".to_owned(),
            "record a log with higher accelerations, or give the stiffness of the maker under \
             [robot.fixed], or write transmission = \"rigid\": then the torque sensor is not used",
        )
    } else {
        (
            Severity::Info,
            "link-by-torque-sensor",
            format!(
                "determines it within {} % (one standard error)",
                Shown((1000.0 * share).round() / 10.0)
            ),
            "nothing; a link encoder determines the stiffness more accurately",
        )
    };
    let finding = Finding::new(
        severity,
        code,
        format!(
            "{name} has a torque sensor and no link encoder: its link position is the motor position \
             minus torque over stiffness, and the stiffness follows from the motion of the links. The \
             beginning of the log {certainty}"
        ),
        remedy,
    )
    .about(Some(parameter.name.clone()));
    Some((finding, is_open))
}
