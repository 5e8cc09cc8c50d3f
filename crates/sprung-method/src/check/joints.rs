//! Checks with the torque row of each joint: whether the torque explains the motion, and whether
//! another meaning of the columns would explain it better.

use super::context::CheckContext;
use super::resolution::{UNEXPLAINED, beyond_resolution, transition_shares};
use super::result::JointFigures;
use super::rivals::{Meaning, Winner};
use super::robot::{AboutRobot, WholeRobot};
use crate::description::Experiment;
use crate::finding::{Finding, Severity};
use crate::log::Quantity;
use crate::prepare::{Excerpt, RowFit, fit_all_rows, independent};
use crate::regression::Reading;

/// Findings about the joints of a log, with figures.
pub(super) struct Examined {
    pub(super) findings: Vec<Finding>,
    pub(super) joints: Vec<JointFigures>,
    /// Finding that the kinematics are wrong, valid if the log has no other fault.
    pub(super) kinematics: Option<Finding>,
}

/// Joints that a log allows to test.
pub(super) struct Tested {
    /// Moving joints without a fault of a single column.
    pub(super) moving: Vec<usize>,
    /// Joints whose encoders have different scales; the motor row determines the ratio.
    pub(super) unequal: Vec<usize>,
}

/// Examines the torque rows at the beginning of a log.
///
/// - `tested`: which joints give information.
/// - `is_sound`: whether no column is wrong by itself, so that the equations of the whole robot hold.
///
/// Returns `None` if the excerpt is too short for the filters.
pub(super) fn joints(
    experiment: &Experiment,
    reading: &Reading,
    excerpt: &Excerpt,
    file: &str,
    tested: &Tested,
    is_sound: bool,
) -> Option<Examined> {
    let moving = &tested.moving[..];
    let context = CheckContext {
        experiment,
        reading,
        excerpt,
        few: excerpt.thinned_for(reading, f64::INFINITY),
        whole: excerpt.reduce_thinned(reading)?.whole()?,
        file,
        independent: independent(excerpt, reading),
    };
    let all: Vec<usize> = (0..reading.model().joint_count()).collect();
    let fits = fit_all_rows(reading.model(), &context.whole)?;
    let shares = if (fits.iter()).any(|fit| fit.relative_residual() > UNEXPLAINED) {
        transition_shares(reading, excerpt, &fits)
    } else {
        vec![0.0; all.len()]
    };
    let unexplained =
        |joint: usize, relative: f64| beyond_resolution(relative, shares[joint]) > UNEXPLAINED;
    let weak: Vec<usize> = (moving.iter().copied())
        .filter(|&joint| {
            let fit = fits[joint].short(reading.model());
            fit.stiffness.is_some_and(|k| k < 0.0) || unexplained(joint, fit.relative_residual)
        })
        .collect();
    let mut findings: Vec<Finding> = (all.iter())
        .filter_map(|&joint| context.zeros_apart(joint))
        .collect();
    let ByRows {
        few,
        swaps,
        mut reported,
        rescaled,
    } = context.by_rows(&fits, &weak, tested, &shares, &mut findings);
    let whole = if reported.is_empty() && is_sound {
        WholeRobot::new(&context, moving)
    } else {
        None
    };
    let reversed: Vec<(usize, Finding)> = (moving.iter())
        .filter(|joint| !rescaled.contains(joint))
        .filter_map(|&joint| Some((joint, context.reversed(joint, &fits[joint])?)))
        .collect();
    // A sign that one joint tells needs no other meaning of the columns.
    let is_told =
        |(joint, _): &(usize, Finding)| !unexplained(*joint, fits[*joint].relative_residual());
    let about = match &whole {
        Some(whole) if reversed.is_empty() || !reversed.iter().all(is_told) => whole.examine(&fits),
        _ => AboutRobot::default(),
    };
    findings.extend(about.findings);
    if about.explains_all {
        reported.extend(&all);
    }
    context.tell(&swaps, &few, &mut reported, &mut findings);
    let turned: Vec<usize> = reversed.iter().map(|(joint, _)| *joint).collect();
    for &joint in &weak {
        if !reported.contains(&joint)
            && !turned.contains(&joint)
            && let Some(finding) = context.opposite_and_late(joint)
        {
            findings.push(finding);
            reported.push(joint);
        }
    }
    let by_positions = (whole.as_ref()).map_or_else(Vec::new, |whole| whole.reversed(&turned));
    for (joint, finding) in reversed {
        let mut others = by_positions.iter().filter(|(other, _)| *other == joint);
        findings.push(others.next().map_or(finding, |(_, other)| other.clone()));
        reported.push(joint);
    }
    let is_open =
        |joint: &&usize| !reported.contains(*joint) && !about.known_scale.contains(*joint);
    let open: Vec<usize> = moving.iter().filter(is_open).copied().collect();
    if let Some((joints, finding)) = context.exchanged_by_nominal(&open, &fits) {
        findings.push(finding);
        reported.extend(joints);
    }
    for &joint in moving {
        if !reported.contains(&joint) {
            let fit = &fits[joint];
            if unexplained(joint, fit.relative_residual()) {
                findings.push(context.unexplained(joint, fit, shares[joint]));
            } else {
                findings.extend(context.unexcited(joint, fit));
            }
            if !about.known_scale.contains(&joint) {
                findings.extend(context.scale(joint, fit));
            }
        }
    }
    let kinematics = whole.and_then(|whole| whole.other_kinematics());
    Some(Examined {
        joints: figures(&context, &fits),
        findings,
        kinematics,
    })
}

/// Returns the figures of the joints.
fn figures(context: &CheckContext<'_>, fits: &[RowFit]) -> Vec<JointFigures> {
    let model = context.reading.model();
    (fits.iter().enumerate())
        .map(|(joint, fit)| {
            let row = fit.short(model);
            JointFigures {
                joint: context.name(joint).to_owned(),
                slope: None,
                explained_percent: 100.0 * (1.0 - row.relative_residual.powi(2)),
                stiffness: row.stiffness,
            }
        })
        .collect()
}

/// Evidence of motor rows and torque sensors about the meaning of columns.
struct ByRows {
    /// Fits of few samples.
    few: Vec<RowFit>,
    /// Exchanged joints, which the equations of the whole robot show better.
    swaps: Vec<Winner>,
    reported: Vec<usize>,
    /// Joints whose motor torque has another scale by the torque sensors.
    rescaled: Vec<usize>,
}

impl CheckContext<'_> {
    /// Tries other meanings of columns with the motor rows, and adds findings.
    fn by_rows(
        &self,
        fits: &[RowFit],
        weak: &[usize],
        tested: &Tested,
        shares: &[f64],
        findings: &mut Vec<Finding>,
    ) -> ByRows {
        let moving = &tested.moving[..];
        let doubtful: Vec<usize> = (moving.iter().copied())
            .filter(|&joint| weak.contains(&joint) || self.encoders_oppose(joint))
            .collect();
        let few = self.compared(fits, &[&doubtful[..], &tested.unequal].concat());
        findings.extend(self.scales_of_motors(&tested.unequal, &few));
        let winners = self.winners(&few, &doubtful, shares);
        let (swaps, others): (Vec<Winner>, Vec<Winner>) =
            (winners.into_iter()).partition(|won| matches!(won.best.meaning, Meaning::Swapped(_)));
        let mut reported: Vec<usize> = Vec::new();
        self.tell(&others, &few, &mut reported, findings);
        let by_sensors = self.torque_sensors(moving, findings);
        reported.extend(&by_sensors);
        // Friction of a torque of another scale is small compared with that of the sensor, so its sign is undetermined.
        let rescaled = if findings
            .iter()
            .any(|finding| finding.code == "torque-scale")
        {
            by_sensors
        } else {
            Vec::new()
        };
        ByRows {
            few,
            swaps,
            reported,
            rescaled,
        }
    }

    /// Adds findings about other meanings of columns, of joints without a finding.
    fn tell(
        &self,
        winners: &[Winner],
        before: &[RowFit],
        reported: &mut Vec<usize>,
        findings: &mut Vec<Finding>,
    ) {
        for won in winners {
            if won.best.joints.iter().any(|joint| reported.contains(joint)) {
                continue;
            }
            if let Some(finding) = self.other_meaning(won, before) {
                findings.push(finding);
                reported.extend(&won.best.joints);
            }
        }
    }

    /// Returns findings about motor positions of another scale than the link positions.
    fn scales_of_motors(&self, joints: &[usize], before: &[RowFit]) -> Vec<Finding> {
        (joints.iter())
            .filter_map(|&joint| {
                // Below 1 the link position may be the wrong one; its range tells its unit.
                let (ratio, now) =
                    (self.motor_scale(joint, &before[joint])).filter(|(ratio, _)| *ratio > 1.0)?;
                self.other_scale(joint, ratio, &now, &before[joint])
            })
            .collect()
    }

    /// Finding: the motor torque does not explain the motion of the joint.
    ///
    /// - `share`: part of the torque that the resolution of the positions explains.
    fn unexplained(&self, joint: usize, fit: &RowFit, share: f64) -> Finding {
        let relative = fit.relative_residual();
        let torque = self.column(&[Quantity::MotorTorque], joint);
        let resolution = if share > 0.0 {
            format!(
                ", of which the resolution of the positions explains {:.0} %",
                100.0 * share
            )
        } else {
            String::new()
        };
        Finding::new(
            Severity::Warning,
            "torque-unexplained",
            format!(
                "{}: the motion explains {:.0} % of \"{torque}\" (squares, filtered); {:.0} % of its \
                 root mean square remains unexplained{resolution}: the torque does not match the motion",
                self.name(joint),
                100.0 * (1.0 - relative.powi(2)).max(0.0),
                100.0 * relative
            ),
            "check that the column is the torque of this joint, that its sign and unit are right, \
             and whether a contact, a load or a friction law is missing in the model",
        )
        .seen(self.file, torque, relative, "")
    }

    /// Finding: the motion determines friction only.
    fn unexcited(&self, joint: usize, fit: &RowFit) -> Option<Finding> {
        let parameters = fit.of_joints(self.reading.model(), self.independent);
        let blind: Vec<String> = (parameters.iter())
            .filter(|of| of.kind.is_vital() && of.value.abs() < 2.0 * of.error)
            .map(|of| format!("{}.{}", self.name(joint), of.kind.name()))
            .collect();
        if blind.is_empty() || !self.reading.model().is_flexible(joint) {
            return None;
        }
        Some(
            Finding::new(
                Severity::Warning,
                "only-friction",
                format!(
                    "{}: friction explains the torque, and the estimate of {} lies within two standard \
                     errors of zero: the joint hardly accelerates",
                    self.name(joint),
                    blind.join(" and ")
                ),
                "record a log with higher accelerations and more reversals of direction",
            )
            .about(blind)
            .seen(
                self.file,
                self.column(&[Quantity::MotorPosition], joint),
                fit.relative_residual(),
                "",
            ),
        )
    }
}
