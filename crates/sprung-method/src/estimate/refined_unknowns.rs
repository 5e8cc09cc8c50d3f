//! What a log shows beyond its description, with the values of a refinement.

use sprung_core::friction::Family;

use crate::description::{Joint, SpringTerm};
use crate::estimate::result::{EstimateResult, Refinement};
use crate::unknowns::{AddedLaw, LEAST_CHANGE_OF_SHARPNESS, UnknownResult};

/// The Stribeck velocity of a joint by likelihood, rad/s (m/s).
#[derive(Clone, Copy, Debug)]
pub(in crate::estimate) struct FoundVelocity<'n> {
    pub(in crate::estimate) joint: &'n str,
    pub(in crate::estimate) velocity: f64,
    pub(in crate::estimate) standard_error: f64,
}

/// Replaces the Stribeck velocities of added laws.
pub(in crate::estimate) fn replace_velocities<'n>(
    unknowns: &mut [UnknownResult],
    found: impl IntoIterator<Item = FoundVelocity<'n>>,
) {
    for found in found {
        let of_joint = |unknown: &&mut UnknownResult| unknown.place == found.joint;
        let laws = unknowns.iter_mut().filter(of_joint);
        for law in laws.filter_map(|unknown| unknown.law.as_mut()) {
            if law.stribeck_velocity.is_some() {
                law.stribeck_velocity = Some(found.velocity);
                law.stribeck_velocity_error = Some(found.standard_error);
            }
        }
    }
}

/// Returns unknowns with the values of a refinement that is used: Stribeck velocities, delays and the timing of the torques.
pub(in crate::estimate) fn refined_unknowns(
    unknowns: &[UnknownResult],
    refined: Option<&Refinement>,
) -> Vec<UnknownResult> {
    let mut unknowns = unknowns.to_vec();
    let Some(refined) = refined else {
        return unknowns;
    };
    let found = refined
        .stribeck_velocities
        .iter()
        .map(|velocity| FoundVelocity {
            joint: velocity.joint.as_str(),
            velocity: velocity.velocity,
            standard_error: velocity.standard_error,
        });
    replace_velocities(&mut unknowns, found);
    for unknown in &mut unknowns {
        let value = match unknown.kind.as_str() {
            "timing" => refined.torques_delay_s,
            "sharpness" => (refined.sharpnesses.iter())
                .find(|sharpness| sharpness.joint == unknown.place)
                .map(|sharpness| (sharpness.sharpness, sharpness.standard_error)),
            "delay" => (refined.delays.iter())
                .find(|delay| delay.column == unknown.place)
                .and_then(|delay| Some((delay.delay_s, delay.standard_error_s?))),
            _ => None,
        };
        if let Some((value, standard_error)) = value {
            (unknown.value, unknown.standard_error) = (value, standard_error);
        }
    }
    // The likelihood has taken the change back.
    unknowns.retain(|unknown| {
        let change = (unknown.value / Joint::USUAL_SHARPNESS).ln();
        unknown.kind != "sharpness" || change.abs() >= LEAST_CHANGE_OF_SHARPNESS
    });
    unknowns
}

/// Returns unknowns in which a law of several coefficients has their sum in a result: its torque in steady motion.
pub(in crate::estimate) fn with_curves(
    mut unknowns: Vec<UnknownResult>,
    result: Option<&EstimateResult>,
) -> Vec<UnknownResult> {
    let Some(result) = result else {
        return unknowns;
    };
    for unknown in &mut unknowns {
        let words = [Family::Presliding.word(), SpringTerm::Hysteresis.word()];
        let is_curve = |law: &&AddedLaw| words.contains(&law.law.as_str());
        let Some(law) = unknown.law.as_ref().filter(is_curve) else {
            continue;
        };
        let side = law.of.trim_end_matches("_friction");
        let curve = format!("{}.{side}_{}", unknown.place, law.law);
        if let Some(sum) = result.sum_of_curve(&curve) {
            (unknown.value, unknown.standard_error) = sum;
        }
    }
    unknowns
}
