//! Stribeck velocities of the ladder's laws, by likelihood.

use super::law_set::Chosen;
use crate::estimate::result::{LawsByHoldOut, Refinement};

/// The Stribeck velocity of a joint by likelihood, rad/s (m/s).
#[derive(Clone, Copy, Debug)]
pub(in crate::estimate) struct FoundVelocity<'n> {
    pub(in crate::estimate) joint: &'n str,
    pub(in crate::estimate) velocity: f64,
    pub(in crate::estimate) standard_error: f64,
}

impl Chosen {
    /// Replaces the Stribeck velocities that the ladder found.
    pub(in crate::estimate) fn set_velocities<'n>(
        &mut self,
        found: impl IntoIterator<Item = FoundVelocity<'n>>,
    ) {
        replace_velocities(&mut self.result, found);
    }

    /// Takes over the gains of equivalent laws, and the torque error with them.
    pub(in crate::estimate) fn update(&mut self, other: Self) {
        let before = std::mem::replace(&mut self.result, other.result);
        self.finding = other.finding;
        let velocities = before.rungs.iter().filter(|rung| rung.made);
        replace_velocities(
            &mut self.result,
            velocities.filter_map(|law| {
                Some(FoundVelocity {
                    joint: law.joint.as_str(),
                    velocity: law.stribeck_velocity?,
                    standard_error: law.stribeck_velocity_error?,
                })
            }),
        );
    }

    /// Returns the laws for the results, with the Stribeck velocities of a refinement that is used.
    pub(in crate::estimate) fn described(&self, refined: Option<&Refinement>) -> LawsByHoldOut {
        let mut laws = self.result.clone();
        let velocities = refined
            .into_iter()
            .flat_map(|refinement| &refinement.stribeck_velocities);
        replace_velocities(
            &mut laws,
            velocities.map(|velocity| FoundVelocity {
                joint: velocity.joint.as_str(),
                velocity: velocity.velocity,
                standard_error: velocity.standard_error,
            }),
        );
        laws
    }
}

fn replace_velocities<'n>(
    laws: &mut LawsByHoldOut,
    found: impl IntoIterator<Item = FoundVelocity<'n>>,
) {
    for found in found {
        for rung in (laws.rungs.iter_mut()).filter(|rung| rung.made && rung.joint == found.joint) {
            if rung.stribeck_velocity.is_some() {
                rung.stribeck_velocity = Some(found.velocity);
                rung.stribeck_velocity_error = Some(found.standard_error);
            }
        }
    }
}
