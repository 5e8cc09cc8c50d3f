//! Constants between the two encoders of a joint.

use sprung_core::chain::JointKind;
use sprung_core::parameters::JointParameter;

use super::look::{Look, SIGNIFICANT_SIGMAS};
use crate::description::EncoderOffset;
use crate::finding::{Finding, Severity};
use crate::log::Quantity;
use crate::model::Model;
use crate::prepare::{RowFit, fit_rows};

/// Part of the torque that a constant must make to be mentioned.
const OFFSET_TORQUE_SHARE: f64 = 0.02;

/// Angle, rad, that no spring is turned by on average.
const ZEROS_APART_RAD: f64 = 0.3;

/// A constant between the two encoders.
pub(super) struct Offset {
    /// Motor minus link where the spring is at rest, rad (m).
    pub(super) value: f64,
    pub(super) standard_error: f64,
    preload: f64,
}

impl Look<'_> {
    /// Constants between the two encoders of each joint, where the model has
    /// none of its own; nothing where it cannot tell.
    pub(super) fn offsets(&self) -> Vec<Option<Offset>> {
        let model = self.reading.model();
        let nothing = || (0..model.joint_count()).map(|_| None).collect();
        let own = (0..model.joint_count())
            .any(|joint| model.index(JointParameter::Preload, joint).is_some());
        let with = if own {
            model.clone()
        } else {
            let mut experiment = self.experiment.clone();
            experiment.identify.encoder_offset = Some(EncoderOffset::Estimate);
            match Model::new(&experiment) {
                Ok(model) => model,
                Err(_) => return nothing(),
            }
        };
        let reading = self.reading.with_model(with.clone());
        let all: Vec<usize> = (0..model.joint_count()).collect();
        let Some(fits) = fit_rows(self.excerpt, &reading, &all) else {
            return nothing();
        };
        let offset = |fit: &RowFit| {
            let parameters = fit.of_joints(&with, self.independent);
            let of = |wanted: JointParameter| {
                parameters
                    .iter()
                    .find(|(kind, ..)| *kind == wanted)
                    .copied()
            };
            let (_, stiffness, _) = of(JointParameter::Stiffness)?;
            let (_, preload, error) = of(JointParameter::Preload)?;
            (stiffness > 0.0).then(|| Offset {
                value: preload / stiffness,
                standard_error: error / stiffness,
                preload,
            })
        };
        fits.iter().map(offset).collect()
    }

    /// Encoders of a joint that count from different zeros, as those do that lose theirs.
    pub(super) fn zeros_apart(&self, joint: usize) -> Option<Finding> {
        let (model, channels) = (self.reading.model(), self.reading.channels());
        let link = channels.index(Quantity::LinkPosition, joint)?;
        let motor = channels.index(Quantity::MotorPosition, joint)?;
        let sum: f64 = (self.excerpt.channel(link))
            .zip(self.excerpt.channel(motor))
            .map(|(link, motor)| link - motor)
            .sum();
        let apart = sum / self.excerpt.samples() as f64;
        let turns = model.is_flexible(joint) && model.kind(joint) == JointKind::Revolute;
        if !turns || apart.abs() < ZEROS_APART_RAD {
            return None;
        }
        let [link, motor] = [link, motor].map(|channel| &channels.all[channel].column);
        Some(
            Finding::new(
                Severity::Info,
                "zeros-apart",
                format!(
                    "{}: \"{link}\" less \"{motor}\" is {apart:.3} rad on average: no spring is turned so \
                     far, so one of them has lost its zero. The motor's only moves a constant; the \
                     link's would turn gravity and the other joints with it",
                    self.name(joint)
                ),
                "see that the link's is right; if another column knows where the joint was, name it in \
                 starts_at_rad beside the column",
            )
            .seen(self.file, link, apart, "rad"),
        )
    }

    pub(super) fn offset(&self, joint: usize, offset: &Offset, fit: &RowFit) -> Option<Finding> {
        let model = self.reading.model();
        let samples = self.excerpt.samples() as f64;
        let torque = (fit.torque / samples).sqrt();
        let sure = offset.value.abs() > SIGNIFICANT_SIGMAS * offset.standard_error
            && offset.preload.abs() > OFFSET_TORQUE_SHARE * torque;
        // Where the model has a place for it, nothing is wrong.
        if !sure || model.index(JointParameter::Preload, joint).is_some() {
            return None;
        }
        let link = self.link(joint);
        Some(
            Finding::new(
                Severity::Warning,
                "encoder-offset",
                format!(
                    "{}: \"{link}\" and \"{}\" differ by {:.3e} rad (standard error {:.1e} rad) where the \
                     spring is at rest, which is taken for a torque of {:.3} N·m",
                    self.name(joint),
                    self.column(&[Quantity::MotorPosition], joint),
                    offset.value,
                    offset.standard_error,
                    offset.preload
                ),
                "let the offset be estimated: set encoder_offset = \"estimate\" in [identify]",
            )
            .seen(self.file, link, offset.value, "rad")
            .mended_by("[identify]", "encoder_offset = \"estimate\""),
        )
    }
}
