//! A controller that the code of a robot contains.

use sprung_core::velocity::LONGEST_WINDOW;

use super::error::ExportError;
use super::format::Format;

/// Longest delay of an input shaper, samples.
const LONGEST_DELAY: usize = 10_000;

/// A designed controller as plain data: what `sprung export` writes beside the dynamics of a robot.
///
/// Every sample it shapes the desired motion, computes feedforward and estimated velocities, adds the
/// feedback and limits the torques.
#[derive(Clone, Debug, PartialEq)]
pub struct ControllerCode {
    /// Sampling period T, s, positive.
    pub period: f64,
    /// The velocity estimators average over `p1 + 1` positions and `p2 + 1` differences, as
    /// `sprung_core::velocity::AveragedVelocity` does.
    pub velocity_window: [usize; 2],
    /// Largest torques of the motors, \[n\], N·m (N), positive; infinite if there is no limit.
    pub torque_limits: Vec<f64>,
    /// Rotor motion and torques by the desired motion of the links.
    pub feedforward: FeedforwardCode,
    /// The feedback.
    pub feedback: FeedbackCode,
    /// Taps of the input shaper; empty if the desired motion is not shaped.
    pub shaper: Vec<ShaperTap>,
}

/// Feedforward of a controller.
#[derive(Clone, Debug, PartialEq)]
pub enum FeedforwardCode {
    /// None: the motors follow the desired motion of the links without torques in advance.
    None,
    /// That of the identified model without friction, `sprung_core::controller::Feedforward::fill`.
    WithoutFriction,
    /// That of the identified model, `sprung_core::controller::Feedforward::fill_with_friction`.
    WithFriction {
        /// Velocities within which the friction changes its direction, \[n\], rad/s (m/s), not negative.
        velocity_scales: Vec<f64>,
    },
}

/// Feedback of a controller.
#[derive(Clone, Debug, PartialEq)]
pub enum FeedbackCode {
    /// State feedback, eq. (33).
    State {
        /// `F`, \[n\] rows of \[4n\]: on the errors of link positions, rotor positions, link velocities
        /// and rotor velocities.
        gain: Vec<Vec<f64>>,
    },
    /// PD on the motors, eq. (24).
    Motors {
        /// Gains of the positions, \[n\], N·m/rad (N/m).
        kp: Vec<f64>,
        /// Gains of the velocities, \[n\], N·m·s/rad (N·s/m).
        kd: Vec<f64>,
    },
}

/// An impulse of an input shaper: `y[k]` is the sum of `weight * x[k - delay]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShaperTap {
    /// Samples.
    pub delay: usize,
    /// Part of the desired motion.
    pub weight: f64,
}

impl ControllerCode {
    /// Checks the controller of a robot with `n` joints.
    ///
    /// # Errors
    ///
    /// [`ExportError::Controller`] if a value is outside its range or an array has a wrong length,
    /// [`ExportError::TooLarge`] if the shaper needs too much memory.
    pub(super) fn check(&self, format: Format, n: usize) -> Result<(), ExportError> {
        let refused = |what: String| Err(ExportError::Controller { what });
        if !(self.period.is_finite() && self.period > 0.0) {
            return refused(format!("its period is {} s", self.period));
        }
        if let Some(p) = self.velocity_window.iter().find(|p| **p >= LONGEST_WINDOW) {
            let samples = p.saturating_add(1);
            return refused(format!(
                "a velocity window has {samples} samples, the longest is {LONGEST_WINDOW}"
            ));
        }
        if let Some(limit) = self.torque_limits.iter().find(|limit| {
            let is_positive = **limit > 0.0;
            !is_positive
        }) {
            return refused(format!("a torque limit is {limit} N·m"));
        }
        if self.shaper.iter().any(|tap| tap.delay > LONGEST_DELAY) {
            return Err(ExportError::TooLarge {
                format: format.name(),
                what: format!("a shaper that is longer than {LONGEST_DELAY} samples"),
            });
        }
        let weights: Vec<f64> = self.shaper.iter().map(|tap| tap.weight).collect();
        let mut arrays = vec![("weights of the shaper", &weights, weights.len())];
        match &self.feedforward {
            FeedforwardCode::None | FeedforwardCode::WithoutFriction => {}
            FeedforwardCode::WithFriction { velocity_scales } => {
                if let Some(scale) = velocity_scales.iter().find(|scale| **scale < 0.0) {
                    return refused(format!("a velocity scale is {scale} rad/s"));
                }
                arrays.push(("velocity scales", velocity_scales, n));
            }
        }
        match &self.feedback {
            FeedbackCode::State { gain } => {
                if gain.len() != n {
                    let rows = gain.len();
                    return refused(format!("{rows} rows of gains for {n} joints"));
                }
                arrays.extend(gain.iter().map(|row| ("gains in a row", row, 4 * n)));
            }
            FeedbackCode::Motors { kp, kd } => {
                arrays.push(("gains of positions", kp, n));
                arrays.push(("gains of velocities", kd, n));
            }
        }
        for (what, own, length) in arrays {
            if own.len() != length {
                return refused(format!("{} {what}, expected are {length}", own.len()));
            }
            if let Some(wrong) = own.iter().find(|x| !x.is_finite()) {
                return refused(format!("one of the {what} is {wrong}"));
            }
        }
        if self.torque_limits.len() != n {
            let limits = self.torque_limits.len();
            return refused(format!("{limits} torque limits for {n} joints"));
        }
        Ok(())
    }

    /// Returns the taps of the shaper; one without delay if the desired motion is not shaped.
    pub(super) fn taps(&self) -> Vec<ShaperTap> {
        if self.shaper.is_empty() {
            return vec![ShaperTap {
                delay: 0,
                weight: 1.0,
            }];
        }
        self.shaper.clone()
    }
}
