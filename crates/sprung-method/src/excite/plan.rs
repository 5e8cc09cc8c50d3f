//! From a task to a certified motion: a motion that breaks a limit is designed again with narrower limits.

use super::bounds::{Bounds, Limited};
use super::certify::{certify_followed, certify_reference};
use super::checked_loop::{Simulation, check_loop};
use super::design::{Designed, design};
use super::fourier::Series;
use super::kept::{Broken, Kept, Peaks};
use super::starts::NoPose;
use super::task::{Frequencies, Task, possible_values};
use crate::description::Controller;
use crate::progress::Listener;

/// A motion that keeps its limits.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The search.
    pub designed: Designed,
    /// The limits that it keeps.
    pub certificate: Certificate,
}

/// The limits that a motion keeps for all values that the robot may have.
#[derive(Clone, Debug)]
pub struct Certificate {
    /// How near the motion comes to its limits between samples.
    pub certified: Vec<Kept>,
    /// How near the simulated motion comes to its limits.
    pub simulated: Vec<Kept>,
    /// The simulated motion.
    pub simulation: Simulation,
}

/// The loop that will run.
#[derive(Clone, Debug)]
pub struct Loop {
    /// The controller; its reference is replaced by the motion.
    pub controller: Controller,
    /// Its period, s.
    pub period: f64,
}

/// Why no motion keeps the limits.
#[derive(Clone, Debug, PartialEq)]
pub enum Refused {
    /// No pose keeps them at rest.
    Pose(NoPose),
    /// No motion that was tried keeps them.
    Motion(Broken),
}

/// Repairs by another search after a broken limit, and the part of the steps that they take.
const REPAIRS: usize = 5;
const REPAIR_PART: usize = 5;

/// If a limit is broken by less, the motion is made smaller, at most this number of times.
const SLIGHT: f64 = 1.05;
const SLIGHT_SHRINKS: usize = 4;

/// Factor of amplitudes if no repair helps, and the largest number of all changes.
const SMALLER: f64 = 0.9;
const SHRINKS: usize = 60;

/// Designs a certified motion.
///
/// # Errors
///
/// [`Refused`] with the limit that no motion keeps.
pub fn plan(
    task: &Task<'_>,
    frequencies: &Frequencies,
    runs: &Loop,
    progress: &mut dyn Listener,
) -> Result<Plan, Refused> {
    let mut parts = [1.0 - task.settings.margin; Limited::ALL.len()];
    let mut designed = design(task, frequencies, &parts, None, progress).map_err(Refused::Pose)?;
    let mut short = task.settings.clone();
    short.steps = (short.steps / REPAIR_PART).max(1);
    let again = Task {
        settings: &short,
        ..task.clone()
    };
    let mut repairs = 0;
    let mut last = None;
    for shrinks in 0..SHRINKS {
        let broken = match certify(task, frequencies, runs, &designed.series) {
            Ok(certificate) => {
                return Ok(Plan {
                    designed,
                    certificate,
                });
            }
            Err(broken) => broken,
        };
        let part = broken.part;
        let what = broken.what;
        last = Some(broken);
        let is_slight = part < SLIGHT && shrinks < SLIGHT_SHRINKS;
        if !is_slight && part.is_finite() && repairs < REPAIRS {
            repairs += 1;
            parts[what as usize] *= 0.995 / part.clamp(1.0, 2.0);
            let from = Some(&designed.series);
            if let Ok(found) = design(&again, frequencies, &parts, from, progress) {
                designed.series = found.series;
                designed.objective = found.objective;
                continue;
            }
            repairs = REPAIRS;
        }
        let factor = if is_slight { 0.998 / part } else { SMALLER };
        designed.series = designed.series.scaled(factor);
    }
    match last {
        Some(broken) => Err(Refused::Motion(broken)),
        None => Err(Refused::Pose(NoPose {
            what: Limited::Position,
            joint: 0,
            place: f64::INFINITY,
        })),
    }
}

/// Certifies a motion for all values that the robot may have.
///
/// # Errors
///
/// [`Broken`] with the first limit that the motion breaks.
pub fn certify(
    task: &Task<'_>,
    frequencies: &Frequencies,
    runs: &Loop,
    series: &Series,
) -> Result<Certificate, Broken> {
    let model = task.model;
    let mut certified = Peaks(certify_reference(series, task.bounds)?);
    let is_rigid = !model.has_springs();
    let controller = Controller {
        reference: series.reference(model),
        ..runs.controller.clone()
    };
    let mut simulated = Peaks::default();
    let mut first = None;
    let times = (runs.period, frequencies.duration());
    for theta in possible_values(task) {
        if is_rigid && task.controller.is_none() {
            let robot = (model, theta.as_slice());
            let followed = certify_followed(series, robot, task.bounds, task.kinematics)?;
            certified.join(followed);
        }
        let robot = (model, &theta);
        let (kept, simulation) =
            check_loop(robot, &controller, times, task.bounds, task.kinematics)?;
        simulated.join(kept);
        first.get_or_insert(simulation);
    }
    Ok(Certificate {
        certified: certified.0,
        simulated: simulated.0,
        simulation: first.unwrap_or_default(),
    })
}

/// Returns the first quantity without any limit that a design needs; `None` if the limits are enough.
///
/// The design needs limits of each joint: of torque, or of position and of velocity or acceleration.
#[must_use]
pub fn missing_limit(bounds: &Bounds, has_loop: bool) -> Option<(usize, Vec<Limited>)> {
    for (joint, joint_bounds) in bounds.joints.iter().enumerate() {
        let [position, velocity, acceleration, _] = joint_bounds.orders;
        let is_slow = velocity.is_limited() || acceleration.is_limited();
        let has_force =
            joint_bounds.torque.is_limited() || has_loop && joint_bounds.deflection.is_limited();
        if !(is_slow && (position.is_limited() || has_force)) && !(has_force && has_loop) {
            let mut missing = Vec::new();
            if !position.is_limited() {
                missing.push(Limited::Position);
            }
            if !is_slow {
                missing.push(Limited::Velocity);
            }
            return Some((joint, missing));
        }
    }
    None
}
