//! Encoders of a joint whose zeros are far apart.

use sprung_core::chain::JointKind;

use super::context::CheckContext;
use crate::finding::{Finding, Severity};
use crate::log::Quantity;

/// Average deflection, rad, that no spring reaches.
const MAX_MEAN_DEFLECTION_RAD: f64 = 0.3;

impl CheckContext<'_> {
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
}
