//! Examines logs by their figures and the beginning of the first log.

use super::filters::filters;
use super::frequencies::one_frequency;
use super::joints::{Tested, joints as examine_joints};
use super::result::JointFigures;
use super::unknowns::are_torques_explained;
use crate::finding::{Finding, Severity};
use crate::log::{Channels, LOOKS_LIKE_DEGREES, Summary, Timing, check_timing};
use crate::model::Model;
use crate::prepare::{Excerpt, Prepared, inertial_findings};
use crate::regression::LogFigures;
use crate::unknowns::AboutUnknowns;

/// Smallest jitter for a note, as a fraction of the period.
const NOTED_JITTER_SHARE: f64 = 0.01;

/// Codes of faults that wrong kinematics may cause.
const MAY_FOLLOW_FROM_KINEMATICS: [&str; 5] = [
    "channel-gain",
    "delayed-channel",
    "laws-missing",
    "torque-scale",
    "torque-unexplained",
];

/// Codes of findings about the scales of the two encoders of a joint.
const SCALES_OF_ENCODERS: [&str; 2] = ["units-disagree", "slope-not-one"];

/// Codes of unknowns that change the slope of one encoder over the other.
const BEND_SLOPE: [&str; 3] = ["eccentric-encoder", "position-drifts", "position-jumps"];

/// Result of [`examine`].
#[derive(Clone, Debug, Default)]
pub struct Examination {
    /// Findings, worst first.
    pub findings: Vec<Finding>,
    /// Figures of the joints; empty if the log is too short for the filters.
    pub joints: Vec<JointFigures>,
}

/// Findings by the figures of one log.
#[derive(Clone, Debug)]
pub struct OfLog {
    findings: Vec<Finding>,
    /// Whether any position of a joint changes, \[n\].
    moves: Vec<bool>,
}

impl OfLog {
    /// Examines the figures of one log.
    ///
    /// - `name`: name of the log for messages.
    pub(crate) fn new(
        name: &str,
        channels: &Channels,
        model: &Model,
        figures: &LogFigures,
    ) -> Self {
        Self {
            findings: about_log(name, channels, model, figures),
            moves: (0..model.joint_count())
                .map(|joint| moves(channels, &figures.summary, joint))
                .collect(),
        }
    }

    /// Examines the figures of each log.
    pub(crate) fn of_each(prepared: &Prepared, figures: &[LogFigures]) -> Vec<Self> {
        let (channels, model) = (prepared.reading().channels(), prepared.reading().model());
        (figures.iter().zip(prepared.names()))
            .map(|(figures, name)| Self::new(name, channels, model, figures))
            .collect()
    }
}

/// Examines logs by their figures and the beginning of the first log.
///
/// - `logs`: findings by the figures of each log.
/// - `about`: what is said of the unknowns of the first log.
#[must_use]
pub fn examine(prepared: &Prepared, logs: &[OfLog], about: &AboutUnknowns) -> Examination {
    let about_unknowns = &about.findings[..];
    let (reading, excerpt) = (prepared.reading(), prepared.excerpt());
    let (model, channels) = (reading.model(), reading.channels());
    let mut findings: Vec<Finding> = (logs.iter())
        .flat_map(|log| log.findings.iter().cloned())
        .collect();
    // The equations know the size of a jump, and what bends a slope, better than single columns.
    let is_known = |found: &Finding| {
        let column = |finding: &Finding| {
            finding
                .evidence
                .as_ref()
                .and_then(|evidence| evidence.column.clone())
        };
        let bends = |other: &Finding| BEND_SLOPE.contains(&other.code.as_str());
        about_unknowns.iter().any(|other| {
            other.code == found.code && column(other) == column(found)
                || is_about_scale(found) && bends(other) && same_joint(found, other, channels)
        })
    };
    findings.retain(|found| !is_known(found));
    findings.extend(about_unknowns.iter().cloned());
    if let Some(name) = prepared.names().first() {
        findings.extend(inertial_findings(reading, excerpt, name));
    }
    let mut joints = Vec::new();
    if let (Some(name), Some(first)) = (prepared.names().first(), logs.first()) {
        let reading = prepared.examined();
        let (wrong, moving): (Vec<usize>, Vec<usize>) = (0..model.joint_count())
            .filter(|&joint| first.moves[joint])
            .partition(|&joint| {
                is_wrong(&findings, channels, joint) || is_bent(about_unknowns, channels, joint)
            });
        let tested = Tested {
            unequal: (wrong.into_iter())
                .filter(|&joint| is_of_scale(&findings, channels, joint))
                .collect(),
            moving,
        };
        let moving = &tested.moving[..];
        let is_sound = (findings.iter()).all(|finding| finding.severity < Severity::Error);
        let experiment = prepared.experiment();
        match examine_joints(experiment, &reading, excerpt, name, &tested, is_sound) {
            Some(examined) => {
                // The equations determine the unit of the positions; their range alone does not.
                findings.retain(|found| found.code != LOOKS_LIKE_DEGREES);
                findings.extend(filters(&reading, excerpt, name, moving));
                findings.extend(one_frequency(&reading, excerpt, name));
                // The equations determine signs and scales more reliably than correlations.
                let again = |found: &Finding| {
                    (examined.findings.iter()).any(|other| {
                        let same = other.code == found.code
                            || [other, found].iter().all(|finding| is_about_scale(finding));
                        same && same_joint(found, other, channels)
                    })
                };
                findings.retain(|found| !again(found));
                // A cause that is named explains the torque.
                let is_explained = |found: &Finding| {
                    found.code == "torque-unexplained"
                        && about_unknowns
                            .iter()
                            .any(|other| same_joint(found, other, channels))
                };
                findings.extend(
                    examined
                        .findings
                        .into_iter()
                        .filter(|found| !is_explained(found)),
                );
                // A robot whose equations explain the torques is no other one.
                let may_be_other = !are_torques_explained(about);
                if may_be_other
                    && (findings.iter()).all(|finding| {
                        let may_follow =
                            MAY_FOLLOW_FROM_KINEMATICS.contains(&finding.code.as_str());
                        finding.severity == Severity::Info
                            || finding.severity == Severity::Warning && may_follow
                    })
                {
                    findings.extend(examined.kinematics);
                }
                joints = examined.joints;
            }
            None => findings.push(too_short(name, excerpt)),
        }
    }
    if is_wrong_itself(&findings) {
        let is_of_unknown = |found: &Finding| about_unknowns.contains(found);
        findings.retain(|found| found.severity == Severity::Info || !is_of_unknown(found));
    }
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    Examination { findings, joints }
}

/// Returns whether a log contradicts its description, so that sizes of further unknowns mean nothing.
pub(super) fn is_wrong_itself(findings: &[Finding]) -> bool {
    (findings.iter()).any(|finding| finding.severity == Severity::Error)
}

/// Returns findings about one log alone: its columns and its clock.
fn about_log(name: &str, channels: &Channels, model: &Model, figures: &LogFigures) -> Vec<Finding> {
    let mut findings = crate::log::check(
        name,
        channels,
        model.joints(),
        &figures.summary,
        &figures.mended,
    );
    let timing = check_timing(name, channels, &figures.timing);
    let uneven = (timing.iter()).any(|finding| finding.code == "uneven-sampling");
    findings.extend(timing);
    findings.extend(gaps(name, figures));
    if !uneven {
        findings.extend(jitter(name, &figures.timing));
    }
    findings
}

/// Returns whether any position of a joint changes.
fn moves(channels: &Channels, summary: &Summary, joint: usize) -> bool {
    (channels.all.iter().enumerate())
        .filter(|(_, channel)| channel.joint == joint && channel.quantity.is_position())
        .any(|(i, _)| {
            summary
                .extent(i)
                .is_some_and(|extent| !extent.is_constant())
        })
}

/// Returns whether a finding is about the scales of the two encoders of a joint.
fn is_about_scale(finding: &Finding) -> bool {
    SCALES_OF_ENCODERS.contains(&finding.code.as_str())
}

/// Returns whether all errors of a joint are about the scales of its encoders.
fn is_of_scale(findings: &[Finding], channels: &Channels, joint: usize) -> bool {
    let (scale, others): (Vec<Finding>, Vec<Finding>) =
        findings.iter().cloned().partition(is_about_scale);
    is_wrong(&scale, channels, joint) && !is_wrong(&others, channels, joint)
}

/// Returns whether a column of a joint has an error; findings from the joint's equations would be
/// consequences of it.
fn is_wrong(findings: &[Finding], channels: &Channels, joint: usize) -> bool {
    (findings.iter())
        .filter(|finding| finding.severity == Severity::Error)
        .any(|finding| is_of_joint(finding, channels, joint))
}

/// Returns whether an encoder of a joint is eccentric, drifts or jumps. Another meaning of its columns would be a consequence of it.
fn is_bent(about_unknowns: &[Finding], channels: &Channels, joint: usize) -> bool {
    (about_unknowns.iter())
        .filter(|finding| BEND_SLOPE.contains(&finding.code.as_str()))
        .any(|finding| is_of_joint(finding, channels, joint))
}

/// Returns whether a finding is about a column of a joint.
fn is_of_joint(finding: &Finding, channels: &Channels, joint: usize) -> bool {
    let column = finding.evidence.as_ref().and_then(|of| of.column.as_ref());
    (channels.all.iter()).any(|channel| channel.joint == joint && Some(&channel.column) == column)
}

/// Returns whether two findings are about columns of one joint.
fn same_joint(one: &Finding, other: &Finding, channels: &Channels) -> bool {
    let joint = |finding: &Finding| {
        let column = finding.evidence.as_ref()?.column.as_ref()?;
        let channel = channels
            .all
            .iter()
            .find(|channel| channel.column == *column)?;
        Some(channel.joint)
    };
    joint(one).is_some() && joint(one) == joint(other)
}

fn gaps(file: &str, figures: &LogFigures) -> Option<Finding> {
    let gaps = &figures.timing.gaps;
    (gaps.count > 0).then(|| {
        let lost = match figures.lost {
            0 => String::new(),
            lost => format!("; {lost} samples between gaps are too few for the filters"),
        };
        Finding::new(
            if figures.lost > 0 {
                Severity::Warning
            } else {
                Severity::Info
            },
            "gaps",
            format!(
                "{file} has {} gap{}, {:.3} s together, at which the filters restart{lost}",
                gaps.count,
                if gaps.count == 1 { "" } else { "s" },
                gaps.duration
            ),
            "check that the recorder keeps up; the log need not be cut",
        )
        .seen(file, "", gaps.duration, "s")
    })
}

/// Returns a finding about a slightly uneven clock.
fn jitter(file: &str, timing: &Timing) -> Option<Finding> {
    (timing.jitter.largest > NOTED_JITTER_SHARE).then(|| {
        Finding::new(
            Severity::Info,
            "jitter",
            format!(
                "{file}: steps of the time differ from the period of {:.4} ms by up to {:.1} %",
                1e3 * timing.period,
                100.0 * timing.jitter.largest
            ),
            "nothing if the times are rounded; otherwise let the controller stamp each sample when it is \
             taken",
        )
        .seen(file, "", 100.0 * timing.jitter.largest, "%")
    })
}

fn too_short(file: &str, excerpt: &Excerpt) -> Finding {
    Finding::new(
        Severity::Warning,
        "too-short-to-examine",
        format!(
            "{file}: {:.3} s are too short for the filters, so torques, signs and delays were not \
             checked",
            excerpt.duration()
        ),
        "record a longer log; three periods of position_cutoff_hz pad each end",
    )
    .seen(file, "", excerpt.duration(), "s")
}
