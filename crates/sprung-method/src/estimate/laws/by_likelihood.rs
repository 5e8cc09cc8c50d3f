//! Stribeck velocities of the ladder's laws, by likelihood.

use super::law_set::Chosen;
use crate::estimate::result::{LawsByHoldOut, Refinement};

impl Chosen {
    /// Replaces the Stribeck velocities that the ladder found.
    ///
    /// - `found`: joint, velocity and standard error, rad/s (m/s).
    pub(in crate::estimate) fn set_velocities<'n>(
        &mut self,
        found: impl IntoIterator<Item = (&'n str, f64, f64)>,
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
                let error = law.stribeck_velocity_error?;
                Some((law.joint.as_str(), law.stribeck_velocity?, error))
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
            velocities.map(|velocity| {
                (
                    velocity.joint.as_str(),
                    velocity.velocity,
                    velocity.standard_error,
                )
            }),
        );
        laws
    }
}

fn replace_velocities<'n>(
    laws: &mut LawsByHoldOut,
    found: impl IntoIterator<Item = (&'n str, f64, f64)>,
) {
    for (joint, velocity, error) in found {
        for rung in (laws.rungs.iter_mut()).filter(|rung| rung.made && rung.joint == joint) {
            if rung.stribeck_velocity.is_some() {
                rung.stribeck_velocity = Some(velocity);
                rung.stribeck_velocity_error = Some(error);
            }
        }
    }
}
