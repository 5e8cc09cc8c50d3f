//! A designed controller as code.

use std::path::Path;

use sprung_core::shaper::{Impulse, Tap, sample};
use sprung_export::ControlCode;
use sprung_method::control::{CONTROL_FORMAT, ControlDesign};
use sprung_method::watch::Watch;
use sprung_robot::{Controller, ControllerKind, Feedforward, Reference};

use super::control_error::ControlError;
use super::error::SessionError;
use super::files::{Disk, read_text};

/// Reads the `control.json` of a design.
///
/// # Errors
///
/// [`SessionError`] if the file cannot be read or is no design.
pub fn read_control(file: &Path) -> Result<ControlDesign, SessionError> {
    let text = read_text(&Disk, file)?;
    let wrong = |why: String| ControlError::NoDesign {
        file: file.display().to_string(),
        why,
    };
    let design: ControlDesign =
        serde_json::from_str(&text).map_err(|error| wrong(error.to_string()))?;
    if design.format != CONTROL_FORMAT {
        return Err(wrong(format!(
            "its format is {}, and this version reads {CONTROL_FORMAT}",
            design.format
        ))
        .into());
    }
    Ok(design)
}

/// Reads a `watch.json`.
///
/// # Errors
///
/// [`SessionError`] if the file cannot be read or is no watch.
pub fn read_watch(file: &Path) -> Result<Watch, SessionError> {
    let text = read_text(&Disk, file)?;
    serde_json::from_str(&text).map_err(|error| SessionError::NoWatch {
        file: file.display().to_string(),
        why: error.to_string(),
    })
}

/// Returns a design in the form of the export.
pub(super) fn control_code(design: &ControlDesign) -> Result<ControlCode, ControlError> {
    if design.has_payload {
        return Err(ControlError::PayloadInCode);
    }
    let controller = &design.controller;
    let n = design.joints.len();
    let of = |order: usize| -> Vec<f64> {
        (0..n)
            .map(|i| {
                controller
                    .gain
                    .get(i)
                    .and_then(|row| row.get((2 * order + 1) * n + i))
            })
            .map(|value| value.copied().unwrap_or(f64::NAN))
            .collect()
    };
    let kind = if controller.has_feedforward {
        ControllerKind::StateFeedback
    } else {
        ControllerKind::Pd
    };
    let sequence: Vec<Impulse> = (controller.shaper.iter())
        .map(|[time, amplitude]| Impulse {
            time: *time,
            amplitude: *amplitude,
        })
        .collect();
    let mut taps = vec![Tap::default(); 2 * sequence.len()];
    let count = if sequence.is_empty() {
        0
    } else {
        sample(&sequence, controller.period_s, &mut taps)
            .map_err(|error| ControlError::Shaper(error.to_string()))?
    };
    taps.truncate(count);
    let mut header = vec![format!(
        "Controller: {}, period {} s, designed by {}.",
        controller.feedback, controller.period_s, design.generator
    )];
    if design.verdict.as_deref() == Some("unusable") {
        header.push(
            "WARNING: the verdict on the identified values is unusable; this code was asked for nevertheless.".to_owned(),
        );
    }
    Ok(ControlCode {
        controller: Controller {
            kind,
            kp_nm_per_rad: of(0),
            kd_nms_per_rad: of(1),
            gain: controller.gain.clone(),
            feedforward: Feedforward::Identified,
            friction_compensation_speed_rad_per_s: controller.friction_compensation_speed_rad_per_s,
            velocity_window: controller.velocity_window,
            shaper: Vec::new(),
            reference: Reference::default(),
        },
        period_s: controller.period_s,
        torque_limits: (controller.torque_limits_nm.iter())
            .map(|limit| limit.unwrap_or(f64::INFINITY))
            .collect(),
        taps,
        header,
    })
}
