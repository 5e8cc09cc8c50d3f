//! Checks with the equations of the whole robot: units of positions, order and direction of the
//! joints, scale of the torques, kinematics and bodies.

use super::context::CheckContext;
use super::trial::{Trial, root_mean_square};
use crate::finding::{Finding, Severity};
use crate::prepare::{BodyScale, LinkRows, RowFit};

/// Number of samples of the log for trials of other meanings, rounded up to whole blocks. A trial
/// uses as few of them as its filters allow.
const SAMPLES_TRIED: usize = 4096;

/// Fits of the whole robot.
pub(super) struct WholeRobot<'a> {
    pub(super) context: &'a CheckContext<'a>,
    /// Joints that move.
    pub(super) moving: &'a [usize],
    /// Unexplained parts of the links' torques, joint by joint of `moving`: by all equations
    /// together, by each equation alone, and without bodies.
    pub(super) together: Vec<f64>,
    pub(super) each: Vec<f64>,
    pub(super) without: Vec<f64>,
    /// Torques of the log over those of the nominal bodies, of joints for which the log determines
    /// this scale.
    pub(super) scales: Vec<BodyScale>,
    /// Whether the bodies have nominal values.
    pub(super) has_bodies: bool,
    /// The log as described, and the torque that its equations do not explain.
    pub(super) given: Trial,
    pub(super) given_left: Vec<f64>,
}

/// Findings about the whole robot.
#[derive(Default)]
pub(super) struct AboutRobot {
    pub(super) findings: Vec<Finding>,
    /// Whether the findings explain all other faults of torques.
    pub(super) explains_all: bool,
    /// Joints whose torques were compared with the nominal bodies.
    pub(super) known_scale: Vec<usize>,
}

impl<'a> WholeRobot<'a> {
    /// Fits the equations of the joints that move; `None` if they cannot be fitted.
    pub(super) fn new(context: &'a CheckContext<'a>, moving: &'a [usize]) -> Option<Self> {
        let (reading, model) = (context.reading, context.reading.model());
        // Without link encoder a link position contains the stiffness of its joint, so other meanings of
        // the columns cannot be compared.
        if !model.joints_without_link().is_empty() {
            return None;
        }
        let rows = LinkRows::of(model, &context.whole, moving)?;
        if rows.rows.len() != moving.len() || moving.is_empty() {
            return None;
        }
        let given = Trial {
            excerpt: (context.excerpt.first(SAMPLES_TRIED)).thinned_for(reading, f64::INFINITY),
            channels: reading.channels().clone(),
        };
        let of_trial = LinkRows::new(&given.excerpt, reading, moving)?;
        let all = model
            .nominal_bodies()
            .map(|bodies| rows.scales(model, &bodies));
        let is_determined = |body: &BodyScale| body.is_determined(context.independent);
        Some(Self {
            has_bodies: all.is_some(),
            together: rows.together(model)?,
            each: rows.each(),
            without: rows.without_bodies(model),
            scales: (all.into_iter().flatten()).filter(is_determined).collect(),
            given_left: of_trial.together(model)?,
            given,
            context,
            moving,
        })
    }

    /// Examines the log, from the most certain faults to the least.
    ///
    /// - `fits`: fits of each joint's torque row.
    pub(super) fn examine(&self, fits: &[RowFit]) -> AboutRobot {
        let mut about = self.degrees(fits);
        if about.explains_all {
            return about;
        }
        let (scales, known) = self.torque_scales();
        // The torque of a single joint competes with the other meanings of the columns.
        let is_explained = self.scales.len() > 1
            && (scales.iter()).any(|finding| finding.severity > Severity::Warning);
        if !is_explained {
            let order = self.order(fits);
            if !order.is_empty() {
                about.findings.extend(order);
                about.explains_all = true;
                return about;
            }
        }
        about.findings.extend(scales);
        about.known_scale = known;
        about
    }

    /// Returns the part of the links' torques that a trial leaves unexplained; `None` if it is
    /// impossible.
    pub(super) fn left(&self, trial: &Trial) -> Option<Vec<f64>> {
        trial.left(self.context.reading, self.moving)
    }

    /// Returns the names of joints, as in `joint1, joint2 and joint3`.
    pub(super) fn names(&self, joints: &[usize]) -> String {
        listed(
            joints
                .iter()
                .map(|&joint| self.context.name(joint).to_owned()),
        )
    }
}

/// Returns residuals as one percentage, root mean square over the joints.
pub(super) fn percent(left: &[f64]) -> String {
    let percent = 100.0 * root_mean_square(left);
    if percent < 1.0 {
        format!("{percent:.1} %")
    } else {
        format!("{percent:.0} %")
    }
}

/// Joins words with commas and "and".
pub(super) fn listed(words: impl Iterator<Item = String>) -> String {
    let mut words: Vec<String> = words.collect();
    match words.pop() {
        Some(last) if words.is_empty() => last,
        Some(last) => format!("{} and {last}", words.join(", ")),
        None => String::new(),
    }
}
