//! Tries other meanings of the columns with the equations of the whole robot: columns of two joints
//! swapped, joints that turn in the other direction, torques in another unit.

use rayon::prelude::*;

use super::resolution::UNEXPLAINED;
use super::robot::{WholeRobot, listed, percent};
use super::scale::{Explanation, explanations};
use super::trial::{Group, Trial, gain, is_certain, root_mean_square};
use crate::finding::{Finding, Severity};
use crate::log::{Channel, Quantity, rounded};
use crate::prepare::RowFit;

/// Conditions for the trials: mean logarithm by which the residual of all equations together
/// exceeds that of each alone, and smallest unexplained part of the bodies' torque in a joint with
/// relevant bodies.
const SUSPICIOUS_MISFIT: f64 = 0.2;
const SUSPICIOUS_PART: f64 = 0.25;
const MATTERING_BODIES: f64 = 0.2;

/// Smallest number of independent samples of all joints for each parameter.
const SAMPLES_PER_UNKNOWN: f64 = 5.0;

/// Unexplained part of the links' torques at which a search ends, root mean square.
const WELL_EXPLAINED: f64 = 0.02;

/// Difference of gains (sums of logarithms) below which two changes explain a log equally well.
const SAME_GAIN: f64 = 0.25;

/// A change of the columns' meaning.
#[derive(Clone, Debug, PartialEq)]
enum Change {
    /// The columns of a group of two joints are exchanged.
    Swapped(Group, usize, usize),
    /// All columns of a joint have the other sign.
    Reversed(usize),
    /// The torque of a joint is wrong by the factor of an explanation.
    Scaled(usize, Explanation),
    /// The torques of all joints are wrong by the factors of an explanation.
    AllScaled(Explanation),
}

impl Change {
    fn made(&self, trial: &Trial, joints: &[usize]) -> Option<Trial> {
        match self {
            Self::Swapped(group, one, two) => trial.swapped(*group, *one, *two),
            Self::Reversed(joint) => Some(trial.reversed(*joint)),
            Self::Scaled(joint, explanation) => {
                Some(trial.with_torque(*joint, explanation.factors[0].recip()))
            }
            Self::AllScaled(explanation) => {
                let factors = joints.iter().zip(&explanation.factors);
                Some(factors.fold(trial.clone(), |trial, (&joint, factor)| {
                    trial.with_torque(joint, factor.recip())
                }))
            }
        }
    }
}

/// A change that was tried.
struct Tried {
    change: Change,
    gain: f64,
    trial: Trial,
    left: Vec<f64>,
}

impl WholeRobot<'_> {
    /// Returns whether the unexplained torque is large enough for another meaning of the columns.
    pub(super) fn is_suspicious(&self) -> bool {
        let misfit = gain(&self.together, &self.each) / self.moving.len() as f64;
        let badly = (self.together.iter().zip(&self.without)).any(|(left, without)| {
            *without > MATTERING_BODIES && *left > SUSPICIOUS_PART * without
        });
        misfit > SUSPICIOUS_MISFIT || badly || self.bodies_are_strange()
    }

    /// Returns whether the torque of the nominal bodies has another sign or shape than that of the log in a joint with
    /// relevant bodies.
    pub(super) fn bodies_are_strange(&self) -> bool {
        self.has_bodies
            && (self.moving.iter().zip(&self.without)).any(|(joint, without)| {
                let is_determined = self.scales.iter().any(|body| body.joint == *joint);
                *without > MATTERING_BODIES && !is_determined
            })
    }

    /// Returns whether the log has enough independent samples for a fit of the whole robot to decide the meaning of the
    /// columns.
    pub(super) fn is_long_enough(&self) -> bool {
        let unknowns = self.context.reading.model().parameters().len() as f64;
        self.context.independent * self.moving.len() as f64 > SAMPLES_PER_UNKNOWN * unknowns
    }

    /// Findings: with columns of joints swapped, reversed or in another unit the equations of the robot
    /// fit. The changes compete; the best one speaks.
    ///
    /// - `fits`: fits of each joint's torque row.
    pub(super) fn order(&self, fits: &[RowFit]) -> Vec<Finding> {
        let joints = self.context.reading.model().joint_count();
        let is_whole = joints > 1 && self.moving.len() == joints;
        if !(is_whole && self.is_long_enough() && self.is_suspicious()) {
            return Vec::new();
        }
        let (mut trial, mut left) = (self.given.clone(), self.given_left.clone());
        let mut changes: Vec<Change> = Vec::new();
        let mut equal: Vec<Change> = Vec::new();
        while changes.len() < joints && root_mean_square(&left) > WELL_EXPLAINED {
            let mut tried = self.tried(&trial, &left);
            tried.sort_by(|a, b| b.gain.total_cmp(&a.gain));
            let Some(most) = tried.first().map(|best| best.gain) else {
                break;
            };
            tried.retain(|attempt| attempt.gain > most - SAME_GAIN);
            // Too large torques of one joint resemble too small torques of the others.
            if let Change::Scaled(..) = tried[0].change {
                let off = |attempt: &Tried| self.off_nominal(&attempt.change, fits);
                tried.sort_by(|a, b| off(a).total_cmp(&off(b)));
            }
            let mut tried = tried.into_iter();
            let Some(best) = tried.next() else {
                break;
            };
            if best.gain <= 0.0 || !is_certain(&left, &best.left) {
                break;
            }
            equal = tried.map(|attempt| attempt.change).collect();
            changes.push(best.change);
            (trial, left) = (best.trial, best.left);
        }
        let of_all = |change: &Change| matches!(change, Change::AllScaled(_));
        if root_mean_square(&left) > UNEXPLAINED || changes.iter().any(of_all) {
            return Vec::new();
        }
        if changes.len() > 1 {
            equal.clear();
        }
        let mut findings: Vec<Finding> = (self.swaps(&changes, &trial, &left).into_iter())
            .chain(self.reversals(&changes, &left))
            .chain(self.scales_of_torques(&changes, &left))
            .collect();
        if let (Some(first), false) = (findings.first_mut(), equal.is_empty()) {
            let others = equal.iter().map(|change| self.words(change));
            first.text = format!(
                "{}. {} explains the log equally well",
                first.text,
                others.collect::<Vec<String>>().join("; or: ")
            );
        }
        findings
    }

    /// Returns the distance of the parameters from their nominal values with the torque of one
    /// joint corrected, sum of logarithms; infinite for other changes.
    fn off_nominal(&self, change: &Change, fits: &[RowFit]) -> f64 {
        let Change::Scaled(joint, explanation) = change else {
            return f64::INFINITY;
        };
        let off = self.moving.iter().filter_map(|&moving_joint| {
            let ratio = self.over_nominal(moving_joint, &fits[moving_joint])?;
            let factor = if moving_joint == *joint {
                explanation.factors[0]
            } else {
                1.0
            };
            Some((ratio / factor).ln().abs())
        });
        off.sum()
    }

    /// Tries all changes of a reading.
    fn tried(&self, trial: &Trial, left: &[f64]) -> Vec<Tried> {
        let joints = self.context.reading.model().joint_count();
        (self.possible_changes(joints).into_par_iter())
            .filter_map(|change| {
                let changed = change.made(trial, self.moving)?;
                let now = self.left(&changed)?;
                Some(Tried {
                    gain: gain(left, &now),
                    change,
                    trial: changed,
                    left: now,
                })
            })
            .collect()
    }

    fn possible_changes(&self, joints: usize) -> Vec<Change> {
        let kind = |joint| self.context.reading.model().kind(joint);
        let mut all: Vec<Change> = (0..joints).map(Change::Reversed).collect();
        for one in 0..joints {
            for two in (one + 1..joints).filter(|&two| kind(one) == kind(two)) {
                all.extend(Group::ALL.map(|group| Change::Swapped(group, one, two)));
            }
            let explanations = explanations(self.context, &[one]);
            all.extend(
                explanations
                    .into_iter()
                    .map(|explanation| Change::Scaled(one, explanation)),
            );
        }
        // The same factor in all joints changes no residual.
        let differs = |explanation: &Explanation| {
            let first = explanation.factors[0];
            (explanation.factors.iter()).any(|factor| (factor / first).ln().abs() > f64::EPSILON)
        };
        let of_all = explanations(self.context, self.moving);
        all.extend(of_all.into_iter().filter(differs).map(Change::AllScaled));
        all
    }

    /// Returns a change in words, with its line.
    fn words(&self, change: &Change) -> String {
        match change {
            Change::Swapped(group, one, two) => {
                format!(
                    "Exchanging {} of {}",
                    group.words(),
                    self.names(&[*one, *two])
                )
            }
            Change::Reversed(joint) => {
                format!("Reversing all columns of {}", self.context.name(*joint))
            }
            Change::Scaled(_, explanation) | Change::AllScaled(explanation) => {
                format!("The line {}", explanation.line)
            }
        }
    }

    fn swaps(&self, changes: &[Change], trial: &Trial, left: &[f64]) -> Option<Finding> {
        let swaps: Vec<String> = (changes.iter())
            .filter_map(|change| match change {
                Change::Swapped(group, one, two) => Some(format!(
                    "{} of {}",
                    group.words(),
                    self.names(&[*one, *two])
                )),
                Change::Reversed(_) | Change::Scaled(..) | Change::AllScaled(_) => None,
            })
            .collect();
        if swaps.is_empty() {
            return None;
        }
        let lines = self.context.column_lines(&trial.channels);
        let first = (changes.iter()).find_map(|change| match *change {
            Change::Swapped(_, one, _) => Some(one),
            Change::Reversed(_) | Change::Scaled(..) | Change::AllScaled(_) => None,
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

    /// Findings: not the torque of a joint is reversed but both of its positions, which its motor row cannot tell.
    ///
    /// - `joints`: those whose torque is reversed relative to the motor position.
    pub(super) fn reversed(&self, joints: &[usize]) -> Vec<(usize, Finding)> {
        let turned = |trial: &Trial, joint: usize| trial.with_torque(joint, -1.0);
        let mut trial = joints
            .iter()
            .fold(self.given.clone(), |trial, &joint| turned(&trial, joint));
        let mut findings = Vec::new();
        for &joint in joints {
            let by_positions = turned(&trial, joint).with_positions(joint, -1.0);
            let (Some(by_torque), Some(left)) = (self.left(&trial), self.left(&by_positions))
            else {
                continue;
            };
            if is_certain(&by_torque, &left) {
                findings.push((joint, self.positions_reversed(joint, &left, &by_torque)));
                trial = by_positions;
            }
        }
        findings
    }

    fn positions_reversed(&self, joint: usize, left: &[f64], by_torque: &[f64]) -> Finding {
        let line = self.other_signs(|of| of.joint == joint && of.quantity.is_position());
        Finding::new(
            Severity::Error,
            "reversed-joint",
            format!(
                "{}: the positions have the other direction than the torque and the model. With both reversed, the \
                 equations of the robot leave {} of the links' torques unexplained, with the torque reversed {} (root \
                 mean squares)",
                self.context.name(joint),
                percent(left),
                percent(by_torque)
            ),
            &format!("set {line} in [log] (a column that has a sign already gets the opposite sign)"),
        )
        .seen(
            self.context.file,
            self.context.column(&[Quantity::MotorPosition], joint),
            root_mean_square(left),
            "",
        )
        .mended_by("[log]", &line)
    }

    /// Returns the line that reverses the signs of some columns.
    fn other_signs(&self, is_meant: impl Fn(&Channel) -> bool) -> String {
        let columns = self.context.reading.channels().all.iter();
        let signs: Vec<String> = (columns.filter(|of| is_meant(of)))
            .map(|of| format!("\"{}\" = -1", of.column))
            .collect();
        format!("sign = {{ {} }}", signs.join(", "))
    }

    fn reversals(&self, changes: &[Change], left: &[f64]) -> Option<Finding> {
        let mut joints: Vec<usize> = (changes.iter())
            .filter_map(|change| match change {
                Change::Reversed(joint) => Some(*joint),
                Change::Swapped(..) | Change::Scaled(..) | Change::AllScaled(_) => None,
            })
            .collect();
        joints.sort_unstable();
        let first = *joints.first()?;
        let line = self.other_signs(|of| joints.contains(&of.joint));
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

    /// Findings: the torque of a joint has another unit or is of the other side of the gearbox.
    fn scales_of_torques(&self, changes: &[Change], left: &[f64]) -> Vec<Finding> {
        let finding = |joint: usize, explanation: &Explanation| {
            let column = self.context.column(&[Quantity::MotorTorque], joint);
            let factor = explanation.factors[0];
            let (size, times) = if factor > 1.0 {
                ("large", factor)
            } else {
                ("small", factor.recip())
            };
            Finding::new(
                Severity::Error,
                "torque-scale",
                format!(
                    "{}: \"{column}\" is {} times too {size}. With this torque corrected, the equations of \
                     the robot leave {} of the links' torques unexplained instead of {} (root mean \
                     squares). {}",
                    self.context.name(joint),
                    rounded(times),
                    percent(left),
                    percent(&self.given_left),
                    explanation.cause
                ),
                &format!("set {} in [log], or give the column its unit", explanation.line),
            )
            .seen(self.context.file, column, factor, "")
            .mended_by(explanation.table, &explanation.line)
        };
        (changes.iter())
            .filter_map(|change| match change {
                Change::Scaled(joint, explanation) => Some(finding(*joint, explanation)),
                Change::Swapped(..) | Change::Reversed(_) | Change::AllScaled(_) => None,
            })
            .collect()
    }
}
