//! Checks of the controller that is to be designed.

use super::fault::{Fault, fault};
use super::payload::possible;
use super::window::check_window;
use crate::control::{Control, Feedback};
use crate::numbers::Shown;
use crate::robot::Robot;

/// Least damping ratio that a quadratic cost of positions and velocities gives.
const LEAST_DAMPING: f64 = 0.71;

pub(super) fn check_control(control: &Control, robot: &Robot) -> Result<(), Fault> {
    let wrong = |key: &str, message: String| Err(fault(&["control", key], message));
    let n = robot.joint.len();
    let bandwidth = &control.bandwidth_hz;
    if !(bandwidth.len() <= 1 || bandwidth.len() == n) {
        return wrong(
            "bandwidth_hz",
            format!(
                "bandwidth_hz has {} numbers; give one for all joints, or {n}, one per joint",
                bandwidth.len()
            ),
        );
    }
    let positive = (bandwidth.iter().map(|value| ("bandwidth_hz", Some(*value)))).chain([
        ("damping", Some(control.damping)),
        ("period_s", control.period_s),
    ]);
    for (key, value) in positive {
        if let Some(value) = value
            && !(value.is_finite() && value > 0.0)
        {
            return wrong(key, format!("{key} = {} must be positive", Shown(value)));
        }
    }
    if control.feedback == Feedback::StateFeedback && control.damping < LEAST_DAMPING {
        return wrong(
            "damping",
            format!(
                "damping = {} is too small for state-feedback, whose quadratic cost gives at least {LEAST_DAMPING}; give \
                 that, or feedback = \"pd\"",
                Shown(control.damping)
            ),
        );
    }
    for (key, value, least, most) in [
        ("gain_margin_db", control.gain_margin_db, 0.0, 40.0),
        ("phase_margin_deg", control.phase_margin_deg, 0.0, 89.0),
        ("damping", control.damping, 0.0, 10.0),
        (
            "friction_compensation_speed_rad_per_s",
            control.friction_compensation_speed_rad_per_s.unwrap_or(0.0),
            0.0,
            1e6,
        ),
    ] {
        if !(least..=most).contains(&value) {
            return wrong(
                key,
                format!(
                    "{key} = {} must be between {least} and {most}",
                    Shown(value)
                ),
            );
        }
    }
    for (key, value, least, most) in [
        ("draws", control.draws, 1, 10_000),
        ("simulations", control.simulations, 1, 10_000),
        ("poses", control.poses, 1, 10_000),
        ("shaper_modes", control.shaper_modes.unwrap_or(0), 0, 4),
    ] {
        if !(least..=most).contains(&value) {
            return wrong(
                key,
                format!("{key} = {value} must be between {least} and {most}"),
            );
        }
    }
    if let Some(window) = control.velocity_window {
        check_window(window, &["control", "velocity_window"])?;
    }
    if let Some(payload) = &control.payload {
        if payload.mass_kg.is_none() {
            return wrong(
                "payload",
                "the payload of control needs mass_kg and com_m".to_owned(),
            );
        }
        if let Err(what) = possible(payload) {
            return wrong("payload", format!("the payload of control: {what}"));
        }
    }
    Ok(())
}
