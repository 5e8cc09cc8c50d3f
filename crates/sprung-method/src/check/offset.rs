//! Constant offsets between the two encoders of a joint.

use sprung_core::chain::JointKind;
use sprung_core::parameters::JointParameter;

use super::context::{CheckContext, SIGNIFICANT_SIGMAS};
use crate::description::EncoderOffset;
use crate::finding::{Finding, Severity};
use crate::log::Quantity;
use crate::model::Model;
use crate::prepare::{RowFit, fit_rows};

/// Smallest torque of an offset for a finding, as a fraction of the motor torque.
const OFFSET_TORQUE_SHARE: f64 = 0.02;

/// Average deflection, rad, that no spring reaches.
const MAX_MEAN_DEFLECTION_RAD: f64 = 0.3;

/// A constant offset between the two encoders of a joint.
pub(super) struct Offset {
    /// Motor minus link position at zero spring torque, rad (m).
    pub(super) value: f64,
    pub(super) standard_error: f64,
    preload: f64,
}

impl CheckContext<'_> {
    /// Estimates the offset between the two encoders of each joint; `None` if the log does not
    /// determine it.
    pub(super) fn offsets(&self) -> Vec<Option<Offset>> {
        let model = self.reading.model();
        let nothing = || (0..model.joint_count()).map(|_| None).collect();
        let has_preload = (0..model.joint_count())
            .any(|joint| model.index(JointParameter::Preload, joint).is_some());
        let with = if has_preload {
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
            let of =
                |wanted: JointParameter| (parameters.iter()).find(|of| of.kind == wanted).copied();
            let stiffness = of(JointParameter::Stiffness)?.value;
            let preload = of(JointParameter::Preload)?;
            (stiffness > 0.0).then(|| Offset {
                value: preload.value / stiffness,
                standard_error: preload.error / stiffness,
                preload: preload.value,
            })
        };
        fits.iter().map(offset).collect()
    }

    /// Finding: the encoders of a joint have different zeros, for example after one encoder lost
    /// its zero.
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
        if !turns || apart.abs() < MAX_MEAN_DEFLECTION_RAD {
            return None;
        }
        let [link, motor] = [link, motor].map(|channel| &channels.all[channel].column);
        Some(
            Finding::new(
                Severity::Info,
                "zeros-apart",
                format!(
                    "{}: \"{link}\" minus \"{motor}\" is {apart:.3} rad on average: no spring deflects so \
                     far, so one encoder has lost its zero. A wrong zero of the motor only changes a \
                     constant; a wrong zero of the link changes the direction of gravity and the pose \
                     of the arm",
                    self.name(joint)
                ),
                "check the zero of the link; if another column contains the joint's position, name that \
                 column in starts_at_rad beside the faulty one",
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
        // If the model has a preload, it accounts for the offset.
        if !sure || model.index(JointParameter::Preload, joint).is_some() {
            return None;
        }
        let link = self.link(joint);
        Some(
            Finding::new(
                Severity::Warning,
                "encoder-offset",
                format!(
                    "{}: \"{link}\" and \"{}\" differ by {:.3e} rad (standard error {:.1e} rad) at zero \
                     spring torque; the model takes this offset for a torque of {:.3} N·m",
                    self.name(joint),
                    self.column(&[Quantity::MotorPosition], joint),
                    offset.value,
                    offset.standard_error,
                    offset.preload
                ),
                "set encoder_offset = \"estimate\" in [identify], so that sprung estimates the offset",
            )
            .seen(self.file, link, offset.value, "rad")
            .mended_by("[identify]", "encoder_offset = \"estimate\""),
        )
    }
}
