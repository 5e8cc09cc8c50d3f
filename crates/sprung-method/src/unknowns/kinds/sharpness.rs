//! Coulomb friction that changes its direction over other velocities than the description assumes without being told.

use sprung_core::friction::Scale;

use super::catalogued::Catalogued;
use crate::unknowns::added_law::may_add_laws;
use crate::unknowns::unknown::{Effect, Kind, Place, Unknown};

/// Usual change of its logarithm.
const USUAL: f64 = 0.3;

/// Least change of the logarithm of a sharpness that affects a regression.
pub(crate) const LEAST_CHANGE_OF_SHARPNESS: f64 = 0.1;

pub(super) fn list(of: &Catalogued<'_>) -> Vec<Unknown> {
    (of.model.open_sharpness().iter())
        .filter(|_| !of.is_known)
        .filter(|&&joint| of.speeds[joint] > 0.0 && may_add_laws(of.experiment, joint))
        // Stribeck friction has nearly the same effect.
        .filter(|&&joint| !of.model.has_law(Scale::Stribeck, joint))
        .map(|&joint| Unknown {
            scale: USUAL,
            least: LEAST_CHANGE_OF_SHARPNESS,
            ..Unknown::new(
                format!("sharpness {}", of.names[joint]),
                Kind::Sharpness,
                Place::Joint(joint),
                "s/rad (s/m)",
                Effect::Sharpness(joint),
            )
        })
        .collect()
}
