//! Shapes of friction laws before a log is read.

use sprung_core::friction::Shape;

use crate::description::Joint;

/// Stribeck velocity before it is searched, rad/s (m/s).
const INITIAL_STRIBECK_VELOCITY: f64 = 0.1;

/// Velocity that scales the residual laws before a log gives it, rad/s (m/s).
const INITIAL_RESIDUAL_VELOCITY: f64 = 1.0;

/// Returns the shape of a joint's friction laws before a log is read.
pub(super) fn initial_shape(joint: &Joint) -> Shape {
    let stribeck = joint.stribeck_velocity_rad_per_s;
    let residual = joint.residual_velocity_rad_per_s;
    Shape {
        sharpness: joint.sharpness(),
        stribeck_velocity: stribeck.unwrap_or(INITIAL_STRIBECK_VELOCITY),
        residual_velocity: residual.unwrap_or(INITIAL_RESIDUAL_VELOCITY),
    }
}
