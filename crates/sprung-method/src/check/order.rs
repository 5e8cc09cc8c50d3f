//! Tests whether the columns of joints are swapped, or joints turn in the other direction, with the
//! equations of the whole robot.

use super::resolution::UNEXPLAINED;
use super::robot::{WholeRobot, listed, percent};
use super::trial::{Group, Trial, gain, is_certain, root_mean_square};
use crate::finding::{Finding, Severity};
use crate::log::Quantity;

/// Conditions for the trials: mean logarithm by which all equations together leave more than each
/// alone, and smallest unexplained part of the bodies' torque in a joint whose bodies matter.
const SUSPICIOUS_MISFIT: f64 = 0.2;
const SUSPICIOUS_PART: f64 = 0.25;
const MATTERING_BODIES: f64 = 0.2;

/// Smallest number of independent samples of all joints for each parameter.
const SAMPLES_PER_UNKNOWN: f64 = 5.0;

/// Unexplained part of the links' torques at which a search ends, root mean square.
const WELL_EXPLAINED: f64 = 0.02;

/// A change of the columns' meaning.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Change {
    Swapped(Group, usize, usize),
    Reversed(usize),
}

impl Change {
    fn made(self, trial: &Trial) -> Option<Trial> {
        match self {
            Self::Swapped(group, one, two) => trial.swapped(group, one, two),
            Self::Reversed(joint) => Some(trial.reversed(joint)),
        }
    }
}

impl WholeRobot<'_> {
    /// Returns whether the equations of the robot leave so much unexplained that another meaning of
    /// the columns is possible.
    pub(super) fn is_suspicious(&self) -> bool {
        let misfit = gain(&self.together, &self.each) / self.moving.len() as f64;
        let badly = (self.together.iter().zip(&self.without)).any(|(left, without)| {
            *without > MATTERING_BODIES && *left > SUSPICIOUS_PART * without
        });
        misfit > SUSPICIOUS_MISFIT || badly || self.bodies_are_strange()
    }

    /// Returns whether the torque of the nominal bodies has another sign or shape than that of the log
    /// in a joint whose bodies matter.
    pub(super) fn bodies_are_strange(&self) -> bool {
        self.has_bodies
            && (self.moving.iter().zip(&self.without)).any(|(joint, without)| {
                let is_determined = self.scales.iter().any(|own| own.joint == *joint);
                *without > MATTERING_BODIES && !is_determined
            })
    }

    /// Returns whether the log has so many independent samples that a fit of the whole robot tells the
    /// meaning of the columns.
    pub(super) fn is_long_enough(&self) -> bool {
        let unknowns = self.context.reading.model().parameters().len() as f64;
        self.context.independent * self.moving.len() as f64 > SAMPLES_PER_UNKNOWN * unknowns
    }

    /// Findings: with columns of joints swapped or reversed the equations of the robot fit.
    pub(super) fn order(&self) -> Vec<Finding> {
        let joints = self.context.reading.model().joint_count();
        let is_whole = joints > 1 && self.moving.len() == joints;
        if !(is_whole && self.is_long_enough() && self.is_suspicious()) {
            return Vec::new();
        }
        let (mut trial, mut left) = (self.given.clone(), self.given_left.clone());
        let mut changes: Vec<Change> = Vec::new();
        while changes.len() < joints && root_mean_square(&left) > WELL_EXPLAINED {
            let best = (self.possible_changes(joints).into_iter())
                .filter_map(|change| {
                    let changed = change.made(&trial)?;
                    let now = self.left(&changed)?;
                    Some((gain(&left, &now), change, changed, now))
                })
                .max_by(|a, b| a.0.total_cmp(&b.0));
            let Some((gain, change, changed, now)) = best else {
                break;
            };
            if gain <= 0.0 || !is_certain(&left, &now) {
                break;
            }
            changes.push(change);
            (trial, left) = (changed, now);
        }
        if root_mean_square(&left) > UNEXPLAINED {
            return Vec::new();
        }
        self.swaps(&changes, &trial, &left)
            .into_iter()
            .chain(self.reversals(&changes, &left))
            .collect()
    }

    fn possible_changes(&self, joints: usize) -> Vec<Change> {
        let kind = |joint| self.context.reading.model().kind(joint);
        let mut all: Vec<Change> = (0..joints).map(Change::Reversed).collect();
        for one in 0..joints {
            for two in (one + 1..joints).filter(|&two| kind(one) == kind(two)) {
                all.extend(Group::ALL.map(|group| Change::Swapped(group, one, two)));
            }
        }
        all
    }

    fn swaps(&self, changes: &[Change], trial: &Trial, left: &[f64]) -> Option<Finding> {
        let swaps: Vec<String> = (changes.iter())
            .filter_map(|change| match *change {
                Change::Swapped(group, one, two) => Some(format!(
                    "{} of {}",
                    match group {
                        Group::All => "the columns",
                        Group::Positions => "the positions",
                        Group::Torques => "the torques",
                    },
                    self.names(&[one, two])
                )),
                Change::Reversed(_) => None,
            })
            .collect();
        if swaps.is_empty() {
            return None;
        }
        let lines = self.context.column_lines(&trial.channels);
        let first = (changes.iter()).find_map(|change| match *change {
            Change::Swapped(_, one, _) => Some(one),
            Change::Reversed(_) => None,
        })?;
        let column = self.context.column(&[Quantity::MotorTorque], first);
        Some(
            Finding::new(
                Severity::Error,
                "swapped-joints",
                format!(
                    "{} are swapped: with them exchanged, the equations of the robot leave {} of the links' \
                     torques unexplained instead of {} (root mean squares)",
                    listed(swaps.into_iter()),
                    percent(left),
                    percent(&self.given_left)
                ),
                "give the columns in the order of the [[robot.joint]] blocks; a log of ROS may list joints \
                 by the alphabet",
            )
            .seen(
                self.context.file,
                column,
                root_mean_square(left),
                "",
            )
            .mended_by("[log]", &lines),
        )
    }

    fn reversals(&self, changes: &[Change], left: &[f64]) -> Option<Finding> {
        let mut joints: Vec<usize> = (changes.iter())
            .filter_map(|change| match change {
                Change::Reversed(joint) => Some(*joint),
                Change::Swapped(..) => None,
            })
            .collect();
        joints.sort_unstable();
        let first = *joints.first()?;
        let signs: Vec<String> = (self.context.reading.channels().all.iter())
            .filter(|channel| joints.contains(&channel.joint))
            .map(|channel| format!("\"{}\" = -1", channel.column))
            .collect();
        let line = format!("sign = {{ {} }}", signs.join(", "));
        Some(
            Finding::new(
                Severity::Error,
                "reversed-joint",
                format!(
                    "{}: positive is the other direction in the log than in the model. With positions and \
                     torques of {} reversed, the equations of the robot leave {} of the links' torques \
                     unexplained instead of {} (root mean squares)",
                    self.names(&joints),
                    if joints.len() == 1 { "this joint" } else { "these joints" },
                    percent(left),
                    percent(&self.given_left)
                ),
                &format!(
                    "set {line} in [log] (a column that has a sign already gets the opposite sign), or \
                     reverse the axis of the joint in the description of the robot"
                ),
            )
            .seen(
                self.context.file,
                self.context.column(&[Quantity::MotorTorque], first),
                root_mean_square(left),
                "",
            )
            .mended_by("[log]", &line),
        )
    }
}
