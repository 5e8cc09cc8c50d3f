//! Simulated motions of one robot in the designed loop.

use sprung_core::chain::JointKind;

use super::refusal::ControlRefusal;
use super::task::ControlTask;
use crate::description::{Controller, Reference, Simulate};
use crate::model::Theta;
use crate::simulate::{Move, Trajectory, Twin, TwinSetup};

/// Longest simulation of a reference, s, and its ignored beginning: the robot starts at rest.
const LONGEST: f64 = 8.0;
pub(super) const SETTLES: f64 = 1.0;

/// Way of a move: at most this, rad (m), and this part of the range of positions.
const WAY: f64 = 0.1;
const WAY_PART: f64 = 0.05;

/// Way of a step as a part of that of a move.
const STEP_PART: f64 = 0.05;

/// Least length of a move, s, and least number of samples in a period of vibration.
const MOVE: f64 = 0.5;
const MOVE_SAMPLES: f64 = 20.0;

/// Evaluated vibration periods after a move, and least time, s.
const PERIODS: f64 = 12.0;
const HOLD: f64 = 1.0;

/// Part of the hold in which the vibration is measured, and part at its end that shows rest.
const MEASURED: f64 = 0.4;
const REST: f64 = 0.2;

/// Part of the way by which a link may vibrate at the end.
pub(super) const RESTS: f64 = 0.01;

/// Part of a torque's limit that counts as reached.
const REACHED: f64 = 1.0 - 1e-9;

/// A designed loop.
#[derive(Clone, Copy, Debug)]
pub(super) struct Designed<'a> {
    pub(super) controller: &'a Controller,
    /// Impulses of the shaper; empty without one.
    pub(super) shaper: &'a [[f64; 2]],
    /// Lowest light vibration of the loop, Hz; `None` without any.
    pub(super) lowest_hz: Option<f64>,
}

/// A kind of simulated motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Along the reference of the experiment, without its beginning.
    Reference,
    /// From rest to rest.
    Move,
}

impl Kind {
    fn words(self) -> String {
        match self {
            Self::Reference => "on the reference of the experiment",
            Self::Move => "in a move from rest to rest",
        }
        .to_owned()
    }

    /// Returns the time that does not count, s.
    fn settles(self) -> f64 {
        match self {
            Self::Reference => SETTLES,
            Self::Move => 0.0,
        }
    }
}

/// One simulated motion.
#[derive(Clone, Debug)]
pub(super) struct Run {
    /// True link positions, \[samples\]\[n\].
    pub(super) links: Vec<Vec<f64>>,
    /// Desired link positions, \[samples\]\[n\].
    pub(super) wanted: Vec<Vec<f64>>,
    /// Largest torque of each joint as a part of its limit.
    pub(super) torque: Vec<f64>,
}

/// All motions of one robot.
pub(super) struct Robot {
    pub(super) designed: Option<Run>,
    pub(super) declared: Option<Run>,
    pub(super) unshaped: Run,
    pub(super) shaped: Run,
    pub(super) steps: [Run; 2],
}

/// What is simulated.
pub(super) struct Plan<'t, 'a> {
    task: &'t ControlTask<'a>,
    pub(super) designed: Designed<'t>,
    settings: Simulate,
    pub(super) way: Vec<f64>,
    /// Period of the vibration that is looked for, s.
    period: f64,
    pub(super) duration: f64,
    hold: f64,
    delay: f64,
}

impl<'t, 'a> Plan<'t, 'a> {
    pub(super) fn new(task: &'t ControlTask<'a>, designed: Designed<'t>) -> Self {
        let n = task.model.joint_count();
        let mut settings = task.twin.clone();
        settings.period_s = task.period;
        settings.seed = task.settings.seed;
        // The noise of the logged torque does not act on the robot.
        settings.torque_noise_nm = vec![0.0; n];
        let period = designed.lowest_hz.map(|hz| 1.0 / hz);
        Self {
            task,
            designed,
            settings,
            way: (task.ranges.iter())
                .map(|[low, high]| WAY.min(WAY_PART * (high - low)))
                .collect(),
            period: period.unwrap_or(MOVE).max(MOVE_SAMPLES * task.period),
            duration: period.unwrap_or(0.0).max(MOVE),
            hold: HOLD.max(PERIODS * period.unwrap_or(0.0)),
            delay: designed.shaper.last().map_or(0.0, |[time, _]| *time),
        }
    }

    /// Simulates all motions of a robot.
    pub(super) fn of(&self, robot: usize) -> Result<Robot, ControlRefusal> {
        let task = self.task;
        let theta = robot
            .checked_sub(1)
            .map_or(task.theta, |draw| &task.draws[draw]);
        let pose = &task.poses[robot % task.poses.len()];
        let designed_controller = self.designed.controller;
        let tracking = |controller: &Controller| -> Result<Option<Run>, ControlRefusal> {
            let Some(reference) = task.reference else {
                return Ok(None);
            };
            let motion = Trajectory::new(reference, task.model);
            let start = reference.clone();
            let duration = task.twin.duration_s.min(LONGEST);
            let run = self.run(theta, controller, start, &motion, duration, Kind::Reference)?;
            Ok(Some(run))
        };
        let designed = tracking(designed_controller)?;
        if let Some(run) = &designed {
            self.check_torques(run, Kind::Reference)?;
        }
        let declared = match task.declared.filter(|_| robot == 0 && !task.is_declared()) {
            Some(declared) => tracking(declared).ok().flatten(),
            None => None,
        };
        let moved = |way: f64, duration: f64, shaper: &[[f64; 2]]| {
            let end = (pose.iter().zip(&self.way).zip(task.ranges))
                .map(|((from, whole), [low, high])| {
                    let inward = if *from > 0.5 * (low + high) {
                        -1.0
                    } else {
                        1.0
                    };
                    from + inward * way * whole
                })
                .collect();
            let motion = Trajectory::of_move(Move {
                ends: [pose.clone(), end],
                begin: 0.0,
                duration,
            });
            let motion = motion.shaped(shaper.to_vec());
            let time = duration + self.delay + self.hold;
            let start = self.resting(pose);
            self.run(theta, designed_controller, start, &motion, time, Kind::Move)
        };
        let unshaped = moved(1.0, self.duration, &[])?;
        let shaped = moved(1.0, self.duration, self.designed.shaper)?;
        self.check_torques(&unshaped, Kind::Move)?;
        Ok(Robot {
            designed,
            declared,
            unshaped,
            shaped,
            steps: [
                moved(STEP_PART, 0.0, &[])?,
                moved(STEP_PART, 0.0, self.designed.shaper)?,
            ],
        })
    }

    fn check_torques(&self, run: &Run, kind: Kind) -> Result<(), ControlRefusal> {
        let limits = self.task.torque_limits;
        let mut all = run.torque.iter().zip(limits).enumerate();
        match all.find(|(_, (part, _))| **part >= REACHED) {
            None => Ok(()),
            Some((joint, (_, limit_nm))) => Err(ControlRefusal::Saturates {
                joint: self.task.model.joints()[joint].clone(),
                limit_nm: *limit_nm,
                motion: kind.words(),
            }),
        }
    }

    /// Returns a reference that rests in a pose.
    fn resting(&self, pose: &[f64]) -> Reference {
        let model = self.task.model;
        let of = |kind: JointKind| -> Vec<f64> {
            (pose.iter().enumerate())
                .map(|(joint, q)| if model.kind(joint) == kind { *q } else { 0.0 })
                .collect()
        };
        Reference {
            centre_deg: of(JointKind::Revolute)
                .iter()
                .map(|q| q.to_degrees())
                .collect(),
            centre_m: of(JointKind::Prismatic),
            sines: Vec::new(),
        }
    }

    /// Simulates one motion.
    fn run(
        &self,
        theta: &Theta,
        controller: &Controller,
        start: Reference,
        motion: &Trajectory,
        duration: f64,
        kind: Kind,
    ) -> Result<Run, ControlRefusal> {
        let task = self.task;
        let n = task.model.joint_count();
        let controller = Controller {
            reference: start,
            ..controller.clone()
        };
        let twin = Twin::new(&TwinSetup {
            model: task.model,
            theta,
            controller: &controller,
            settings: &self.settings,
        })
        .and_then(|twin| twin.with_feedforward(task.theta));
        let mut twin = twin
            .map_err(|_| ControlRefusal::Impossible)?
            .with_reference(motion.clone());
        let samples = (duration / task.period).ceil() as usize;
        let mut run = Run {
            links: Vec::with_capacity(samples),
            wanted: Vec::with_capacity(samples),
            torque: vec![0.0; n],
        };
        let mut desired = vec![[0.0; 5]; n];
        for _ in 0..samples {
            let sample = twin.sample().map_err(|_| ControlRefusal::RunsAway {
                motion: kind.words(),
            })?;
            motion.at(sample.time, &mut desired);
            run.wanted
                .push(desired.iter().map(|state| state[0]).collect());
            let [q, _, _] = sample.motion;
            run.links.push(q);
            if sample.time >= kind.settles() {
                let parts = sample.tau.iter().zip(task.torque_limits);
                for (most, (tau, limit)) in run.torque.iter_mut().zip(parts) {
                    *most = most.max(tau.abs() / limit);
                }
            }
        }
        Ok(run)
    }

    /// Returns the samples of a run between two parts of the hold.
    fn held<'r>(&self, run: &'r Run, [from, to]: [f64; 2]) -> &'r [Vec<f64>] {
        let begin = self.duration + self.delay;
        let at = |part: f64| ((begin + part * self.hold) / self.task.period).ceil() as usize;
        let end = at(to).min(run.links.len());
        &run.links[at(from).min(end)..end]
    }

    /// Returns the amplitude of the vibration of each link in a part of the hold, \[n\], rad (m): its largest deviation from the mean
    /// over one period, which leaves out the slow creep against dry friction.
    fn amplitudes(&self, run: &Run, part: [f64; 2]) -> Vec<f64> {
        let looked = self.held(run, part);
        let window =
            ((self.period / self.task.period) as usize).clamp(1, (looked.len() / 2).max(1));
        let of_joint = |joint: usize| {
            let mut sum: f64 = looked.iter().take(window).map(|row| row[joint]).sum();
            let mut largest = 0.0_f64;
            for k in 0..looked.len().saturating_sub(window) {
                let middle = looked[k + window / 2][joint];
                largest = largest.max((middle - sum / window as f64).abs());
                sum += looked[k + window][joint] - looked[k][joint];
            }
            largest
        };
        (0..self.way.len()).map(of_joint).collect()
    }

    /// Returns the largest vibration of a link after a move, rad (m).
    pub(super) fn vibration(&self, run: &Run) -> f64 {
        self.amplitudes(run, [0.0, MEASURED])
            .into_iter()
            .fold(0.0, f64::max)
    }

    /// Returns whether a link still vibrates at the end.
    pub(super) fn goes_on(&self, run: &Run) -> bool {
        let all = self.amplitudes(run, [1.0 - REST, 1.0]);
        all.iter()
            .zip(&self.way)
            .any(|(amplitude, way)| *amplitude > RESTS * way)
    }
}
