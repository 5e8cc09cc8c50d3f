//! What the torque's row of each joint says about the log: does the torque
//! explain the motion, and would another reading of the columns explain it better?

use super::look::Look;
use super::relative::{ChannelDelay, RelativeDelays, relative_delays};
use super::resolution::{UNEXPLAINED, beyond_resolution, transition_shares};
use super::result::{DELAYED, DelayFigures, JointFigures};
use crate::description::Experiment;
use crate::finding::{Finding, Severity};
use crate::log::Quantity;
use crate::prepare::{Excerpt, RowFit, fit_rows, independent};
use crate::regression::Reading;

/// Part of the torque's squared residual that a delay must take away, and the
/// standard errors that it must be away from none.
const DELAY_SHARE_OF_SQUARES: f64 = 0.15;
const DELAY_SIGMAS: f64 = 3.0;

/// How far parameters may be from the maker's, all in one direction, before the
/// scale of the torque is doubted.
const DOUBTED_SCALE: f64 = 6.0;

/// What is known about the joints of a log.
pub(super) struct Examined {
    pub(super) findings: Vec<Finding>,
    pub(super) joints: Vec<JointFigures>,
}

/// Examines the torque's rows of the beginning of a log.
///
/// - `moving`: joints that move; others say nothing.
///
/// Returns nothing if it is too short for the filters.
pub(super) fn joints(
    experiment: &Experiment,
    reading: &Reading,
    excerpt: &Excerpt,
    file: &str,
    moving: &[usize],
) -> Option<Examined> {
    let look = Look {
        experiment,
        reading,
        excerpt,
        file,
        independent: independent(excerpt, reading),
    };
    let all: Vec<usize> = (0..reading.model().joint_count()).collect();
    let fits = fit_rows(excerpt, reading, &all)?;
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
        .filter_map(|&joint| look.zeros_apart(joint))
        .collect();
    let mut told = look.exchanged(&fits, &weak, &mut findings);
    look.swapped(&fits, &weak, &mut told, &mut findings);
    for &joint in &weak {
        if told.contains(&joint) {
            continue;
        }
        let better =
            (look.opposite(joint, &fits[joint])).or_else(|| look.other_scale(joint, &fits[joint]));
        if let Some(finding) = better {
            findings.push(finding);
            told.push(joint);
        }
    }
    for &joint in moving {
        if let Some(finding) = look.reversed(joint, &fits[joint]) {
            findings.push(finding);
            told.push(joint);
        }
    }
    let wanting: Vec<usize> = (weak.iter().copied())
        .filter(|joint| !told.contains(joint))
        .collect();
    let delays = relative_delays(excerpt, reading, &wanting);
    for delay in &delays {
        if moving.contains(&delay.joint) && !told.contains(&delay.joint) {
            let finding = look.delayed(delay);
            if finding.is_some() && !unexplained(delay.joint, delay.residual[1]) {
                told.push(delay.joint);
            }
            findings.extend(finding);
        }
    }
    for &joint in moving {
        if !told.contains(&joint) {
            let fit = &fits[joint];
            if unexplained(joint, fit.relative_residual()) {
                findings.push(look.unexplained(joint, fit, shares[joint]));
            } else {
                findings.extend(look.unexcited(joint, fit));
            }
            findings.extend(look.scale(joint, fit));
        }
    }
    let offsets = look.offsets();
    for &joint in moving {
        if !told.contains(&joint)
            && let Some(offset) = &offsets[joint]
        {
            findings.extend(look.offset(joint, offset, &fits[joint]));
        }
    }
    let of = |joint: usize| delays.iter().find(|delay| delay.joint == joint);
    let joints = all.iter().map(|&joint| {
        let row = fits[joint].short(reading.model());
        JointFigures {
            joint: reading.model().joints()[joint].clone(),
            slope: None,
            explained_percent: 100.0 * (1.0 - row.relative_residual.powi(2)),
            stiffness: row.stiffness,
            delay: of(joint).map(|delay| look.as_figures(&delay.likely)),
            encoder_offset_rad: offsets[joint].as_ref().map(|offset| offset.value),
            encoder_offset_standard_error_rad: (offsets[joint].as_ref())
                .map(|offset| offset.standard_error),
        }
    });
    Some(Examined {
        joints: joints.collect(),
        findings,
    })
}

impl Look<'_> {
    fn delayed(&self, found: &RelativeDelays) -> Option<Finding> {
        let [without, with] = found.residual;
        let ChannelDelay {
            channel,
            delay,
            standard_error,
        } = found.likely;
        let sure = with.powi(2) < (1.0 - DELAY_SHARE_OF_SQUARES) * without.powi(2)
            && delay.abs() > DELAY_SIGMAS * standard_error;
        if !sure {
            return None;
        }
        let column = &self.reading.channels().all[channel].column;
        let setting = format!("delay_s = {{ \"{column}\" = \"estimate\" }}");
        Some(
            Finding::new(
                Severity::Warning,
                DELAYED,
                format!(
                    "{}: if \"{column}\" was recorded {delay:.3} s late (standard error \
                     {standard_error:.3} s), the motor row explains {:.1} % of the torque instead of \
                     {:.1} %",
                    self.name(found.joint),
                    100.0 * (1.0 - with.powi(2)).max(0.0),
                    100.0 * (1.0 - without.powi(2)).max(0.0)
                ),
                &format!(
                    "set delay_s = {{ \"{column}\" = {delay:.3} }} in [log], or \"estimate\"; \
                     sprung check --thorough finds it to a fraction of a sample"
                ),
            )
            .about(self.about_stiffness(found.joint))
            .seen(self.file, column, delay, "s")
            .mended_by("[log]", &setting),
        )
    }

    /// The energy that the motor puts in is not what moves the joint.
    ///
    /// - `share`: what the resolution of the positions leaves of the torque.
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
                 root mean square is left over{resolution}: the energy that goes in does not come out",
                self.name(joint),
                100.0 * (1.0 - relative.powi(2)).max(0.0),
                100.0 * relative
            ),
            "see that the column is the torque of this joint, that its sign and unit are right, \
             and whether a contact, a load or a friction law is missing in the model",
        )
        .seen(self.file, torque, relative, "")
    }

    /// The scale of the torque against the maker's values.
    fn scale(&self, joint: usize, fit: &RowFit) -> Option<Finding> {
        let mut ratios: Vec<f64> = (fit.beside_nominal(self.reading.model()).iter())
            .map(|(value, nominal)| value / nominal)
            .filter(|ratio| ratio.is_finite() && *ratio > 0.0)
            .collect();
        ratios.sort_by(f64::total_cmp);
        if ratios.len() < 2 {
            return None;
        }
        let (least, most) = (*ratios.first()?, *ratios.last()?);
        let middle = ratios[ratios.len() / 2].min(ratios[(ratios.len() - 1) / 2]);
        let far = middle.max(1.0 / middle);
        // All to one side: a scale, not a parameter.
        if far < DOUBTED_SCALE || (least < 1.0 && most > 1.0) {
            return None;
        }
        let torque = self.column(&[Quantity::MotorTorque], joint);
        let constant = (self.experiment.robot.joint.get(joint))
            .and_then(|joint| joint.torque_constant_nm_per_a)
            .filter(|constant| (middle * constant).ln().abs() < 2_f64.ln());
        let (likely, line) = match constant {
            _ if (300.0..3000.0).contains(&middle) => (
                "millinewton metres".to_owned(),
                format!("motor_torque = {{ column = \"{torque}\", unit = \"mN·m\" }}"),
            ),
            Some(constant) => (
                format!("a current (torque constant {constant} N·m/A)"),
                format!("motor_current_a = [\"{torque}\"]"),
            ),
            None => (
                "another unit, the other side of the gearbox, or raw counts".to_owned(),
                format!(
                    "motor_torque = {{ column = \"{torque}\", unit = \"N·m\", gain = {:.4} }}",
                    1.0 / middle
                ),
            ),
        };
        Some(
            Finding::new(
                // The maker's values may be the ones that are wrong.
                Severity::Warning,
                "torque-scale",
                format!(
                    "{}: stiffness, inertia and friction come out {middle:.3} times the nominal ones, \
                     all in one direction ({least:.3} to {most:.3}): \"{torque}\" looks like {likely}, \
                     or the positions have another unit",
                    self.name(joint)
                ),
                "say the unit and the side of the torque; or correct the nominal values",
            )
            .seen(self.file, torque, middle, "")
            .mended_by("[log]", &line),
        )
    }

    /// A motion that shows friction and nothing else.
    fn unexcited(&self, joint: usize, fit: &RowFit) -> Option<Finding> {
        let parameters = fit.of_joints(self.reading.model(), self.independent);
        let blind: Vec<String> = (parameters.iter())
            .filter(|(kind, value, error)| kind.is_vital() && value.abs() < 2.0 * error)
            .map(|(kind, ..)| format!("{}.{}", self.name(joint), kind.name()))
            .collect();
        if blind.is_empty() || !self.reading.model().is_flexible(joint) {
            return None;
        }
        Some(
            Finding::new(
                Severity::Warning,
                "only-friction",
                format!(
                    "{}: friction explains the torque so well that {} stays within its error: the \
                     joint hardly accelerates",
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

    fn as_figures(&self, delay: &ChannelDelay) -> DelayFigures {
        DelayFigures {
            column: self.reading.channels().all[delay.channel].column.clone(),
            delay_s: delay.delay,
            standard_error_s: delay.standard_error,
        }
    }
}
