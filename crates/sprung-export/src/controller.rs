//! A controller and an observer that the code of a robot contains.

use sprung_core::shaper::{Shaper, Tap, memory_len};
use sprung_core::velocity::AveragedVelocity;
use sprung_method::watch::ObserverSettings;

use super::error::ExportError;
use super::format::Format;
use crate::description::{Controller, ControllerKind};

/// Longest delay of an input shaper, samples.
const LONGEST_DELAY: usize = 10_000;

/// A designed controller: the controller in the code of a robot.
///
/// Every sample it shapes the desired motion, estimates velocities, adds the feedback to the feedforward
/// and limits the torques.
#[derive(Clone, Debug)]
pub struct ControlCode {
    /// Kind, gains, windows of the estimators of velocities, and speed of the compensation of friction. The model of
    /// the feedforward is that of the code, whatever the model of this controller is. The caller of the code gives the
    /// desired motion, so the reference is ignored.
    pub controller: Controller,
    /// Sampling period T, s, positive.
    pub period_s: f64,
    /// Largest torques of the motors, \[n\], N·m (N), positive; infinite if there is no limit.
    pub torque_limits: Vec<f64>,
    /// Taps of the input shaper, from [`sprung_core::shaper::sample`]; empty if the desired motion is not
    /// shaped.
    pub taps: Vec<Tap>,
    /// Lines about the controller for the comment before it.
    pub header: Vec<String>,
}

/// An observer of torques from outside in the code of a robot.
#[derive(Clone, Debug)]
pub struct ObserverCode {
    /// Filters and thresholds.
    pub settings: ObserverSettings,
    /// Lines about it for the comment before it.
    pub header: Vec<String>,
}

impl ControlCode {
    /// Checks the controller of a robot with `n` joints.
    ///
    /// # Errors
    ///
    /// [`ExportError::Controller`] if a value is outside its range or an array has a wrong length,
    /// [`ExportError::TooLarge`] if the shaper needs too much memory.
    pub(super) fn check(&self, format: Format, n: usize) -> Result<(), ExportError> {
        let refused = |what: String| ExportError::Controller { what };
        self.velocity()
            .map_err(|error| refused(error.to_string()))?;
        if self.taps.iter().any(|tap| tap.delay > LONGEST_DELAY) {
            return Err(ExportError::TooLarge {
                format: format.name(),
                what: format!("a shaper that is longer than {LONGEST_DELAY} samples"),
            });
        }
        Shaper::new(
            &self.taps_or_none(),
            &[0.0],
            vec![0.0; memory_len(&self.taps_or_none(), 1)],
        )
        .map_err(|error| refused(error.to_string()))?;
        let is_positive = |x: &&f64| **x > 0.0;
        if let Some(limit) = self.torque_limits.iter().find(|limit| !is_positive(limit)) {
            return Err(refused(format!("a torque limit is {limit} N·m")));
        }
        if self.torque_limits.len() != n {
            let limits = self.torque_limits.len();
            return Err(refused(format!("{limits} torque limits for {n} joints")));
        }
        self.check_gains(n)
    }

    fn check_gains(&self, n: usize) -> Result<(), ExportError> {
        let refused = |what: String| Err(ExportError::Controller { what });
        let controller = &self.controller;
        let mut arrays = Vec::new();
        match controller.kind {
            ControllerKind::Pd => {
                arrays.push(("gains of positions", &controller.kp_nm_per_rad, n));
                arrays.push(("gains of velocities", &controller.kd_nms_per_rad, n));
            }
            ControllerKind::StateFeedback => {
                if controller.gain.len() != n {
                    let rows = controller.gain.len();
                    return refused(format!("{rows} rows of gains for {n} joints"));
                }
                arrays.extend(
                    controller
                        .gain
                        .iter()
                        .map(|row| ("gains in a row", row, 4 * n)),
                );
            }
        }
        for (what, array, length) in arrays {
            if array.len() != length {
                return refused(format!("{} {what}, expected are {length}", array.len()));
            }
            if let Some(wrong) = array.iter().find(|x| !x.is_finite()) {
                return refused(format!("one of the {what} is {wrong}"));
            }
        }
        match controller.friction_compensation_speed_rad_per_s {
            Some(speed) if !(speed.is_finite() && speed > 0.0) => refused(format!(
                "the speed of the compensation of friction is {speed} rad/s"
            )),
            Some(_) | None => Ok(()),
        }
    }

    /// Returns the estimator of a velocity.
    ///
    /// # Errors
    ///
    /// [`VelocityError`] if the windows or the period are outside their ranges.
    ///
    /// [`VelocityError`]: sprung_core::velocity::VelocityError
    pub(super) fn velocity(
        &self,
    ) -> Result<AveragedVelocity, sprung_core::velocity::VelocityError> {
        let [p1, p2] = self.controller.velocity_window;
        AveragedVelocity::new(p1, p2, self.period_s)
    }

    /// Returns the taps of the shaper; one without delay if the desired motion is not shaped.
    pub(super) fn taps_or_none(&self) -> Vec<Tap> {
        if self.taps.is_empty() {
            return vec![Tap {
                delay: 0,
                weight: 1.0,
            }];
        }
        self.taps.clone()
    }
}
