//! Shapes of friction laws before a log is read.

use sprung_core::friction::Shape;

use crate::description::Joint;

/// Stribeck velocity before it is searched, rad/s (m/s).
const INITIAL_STRIBECK_VELOCITY: f64 = 0.1;

/// Width of the widest element of presliding friction before a log gives it, rad (m).
const INITIAL_PRESLIDING_WIDTH: f64 = 0.1;

/// Width of the widest element of hysteresis before a log gives it, rad (m).
const INITIAL_HYSTERESIS_WIDTH: f64 = 0.01;

/// Returns the shape of a joint's friction laws before a log is read.
pub(super) fn initial_shape(joint: &Joint) -> Shape {
    let stribeck = joint.stribeck_velocity_rad_per_s;
    let presliding = joint.presliding_width_rad;
    let hysteresis = joint.hysteresis_width_rad;
    Shape {
        sharpness: joint.sharpness(),
        stribeck_velocity: stribeck.unwrap_or(INITIAL_STRIBECK_VELOCITY),
        presliding_width: presliding.unwrap_or(INITIAL_PRESLIDING_WIDTH),
        hysteresis_width: hysteresis.unwrap_or(INITIAL_HYSTERESIS_WIDTH),
        play: joint.play_half_width_rad.unwrap_or_default(),
        play_centre: joint.play_centre_rad.unwrap_or_default(),
    }
}
