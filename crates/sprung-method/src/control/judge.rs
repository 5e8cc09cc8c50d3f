//! The loop at many poses, for the identified robot and robots from the posterior.

use rayon::prelude::*;

use super::linear::Linear;
use super::margins::{Stability, stability};
use super::modes::{Mode, assigned};
use super::pose::linear;
use super::task::ControlTask;
use crate::description::{Control, Controller};
use crate::model::{Model, Theta};

/// Number of tested pairs of a robot and a pose beside those of the identified robot.
const PAIRS: usize = 300;

/// Lowest frequency of a vibration of a spring, Hz.
const SLOWEST: f64 = 1e-3;

/// A robot in a pose.
#[derive(Clone, Copy, Debug)]
pub(super) struct Case<'a> {
    /// 0 for the identified robot, then the draws.
    pub(super) robot: usize,
    pub(super) theta: &'a Theta,
    /// Index of the pose.
    pub(super) pose: usize,
}

/// Natural frequency, Hz, and damping ratio.
pub(super) type Point = [f64; 2];

/// The loop in one case.
#[derive(Clone, Debug)]
pub(super) struct Seen {
    pub(super) robot: usize,
    pub(super) pose: usize,
    pub(super) stability: Stability,
    /// Vibration of each joint's spring with motors free and with motors held, \[n\] each.
    pub(super) springs: [Vec<Option<Point>>; 2],
}

/// Returns the identified robot at all poses.
pub(super) fn identified<'a>(task: &ControlTask<'a>) -> Vec<Case<'a>> {
    (0..task.poses.len())
        .map(|pose| Case {
            robot: 0,
            theta: task.theta,
            pose,
        })
        .collect()
}

/// Returns the robots of the posterior, each at some of the poses, with about equally many robots in each pose.
pub(super) fn drawn<'a>(task: &ControlTask<'a>) -> Vec<Case<'a>> {
    let poses = task.poses.len();
    let each = (PAIRS / task.draws.len().max(1)).clamp(1, poses);
    (task.draws.iter().enumerate())
        .flat_map(|(draw, theta)| {
            (0..each).map(move |k| Case {
                robot: draw + 1,
                theta,
                pose: (draw * each + k) % poses,
            })
        })
        .collect()
}

/// Returns the stability of the loop in each case; `None` where no robot can have the values.
pub(super) fn stabilities(
    task: &ControlTask<'_>,
    controller: &Controller,
    cases: &[Case<'_>],
) -> Vec<Option<Stability>> {
    (cases.par_iter())
        .map(|case| {
            let q = &task.poses[case.pose];
            stability(task.model, case.theta, controller, q, task.period)
        })
        .collect()
}

/// Returns the loop and the vibrations of the springs in each case that a robot can have.
pub(super) fn look(
    task: &ControlTask<'_>,
    controller: &Controller,
    cases: &[Case<'_>],
) -> Vec<Seen> {
    (cases.par_iter())
        .filter_map(|case| {
            let q = &task.poses[case.pose];
            Some(Seen {
                robot: case.robot,
                pose: case.pose,
                stability: stability(task.model, case.theta, controller, q, task.period)?,
                springs: springs(task.model, &linear(task.model, case.theta, q)?),
            })
        })
        .collect()
}

/// Returns whether a loop keeps its margins.
pub(super) fn keeps(stability: &Stability, settings: &Control) -> bool {
    let margins = stability.margins.iter().all(|margin| {
        margin.gain_db >= settings.gain_margin_db && margin.phase_deg >= settings.phase_margin_deg
    });
    stability.growth_per_s.is_none() && margins
}

/// Returns the vibration of the spring of each joint with motors free and with motors held.
fn springs(model: &Model, linear: &Linear) -> [Vec<Option<Point>>; 2] {
    let (n, robot) = (model.joint_count(), model.robot());
    let flexible: Vec<usize> = (0..n).filter(|&joint| model.is_flexible(joint)).collect();
    let stiffness = |joint: usize| -linear.stiffness[(robot.motor_coordinate(joint), joint)];
    let of = |linear: &Linear, ends: &dyn Fn(usize) -> (Option<usize>, usize)| {
        let mut modes = Mode::all(linear);
        // A rigid-body motion has a frequency only by rounding.
        modes.retain(|mode| mode.hz() > SLOWEST);
        let shares: Vec<Vec<f64>> = (0..flexible.len())
            .map(|k| {
                let stiffness = stiffness(flexible[k]);
                modes
                    .iter()
                    .map(|mode| mode.spring_share(linear, stiffness, ends(k)))
                    .collect()
            })
            .collect();
        let mut all = vec![None; n];
        for (k, owner) in assigned(&shares).into_iter().enumerate() {
            all[flexible[k]] = owner.map(|mode| [modes[mode].hz(), modes[mode].damping()]);
        }
        all
    };
    [
        of(linear, &|k| {
            (Some(robot.motor_coordinate(flexible[k])), flexible[k])
        }),
        of(&linear.of(&flexible), &|k| (None, k)),
    ]
}
