//! `[robot.joint.servo]`: the drive law of a position servo that logs targets and no torque.

use schemars::JsonSchema;
use serde::Deserialize;

/// The drive law of a position servo. It gives the torque of the motor where the log has only the
/// target and the position. A servo with `gain_duty_per_rad` applies a voltage, a servo with
/// `gain_a_per_rad` controls the current.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct ServoDrive {
    /// Duty cycle of the supply voltage per position error, 1/rad: the gain of the firmware times
    /// its conversion.
    pub gain_duty_per_rad: Option<f64>,
    /// Current per position error, A/rad.
    pub gain_a_per_rad: Option<f64>,
    /// Duty cycle per velocity that brakes the motion, s/rad; 0 if absent.
    pub damping_duty_s_per_rad: Option<f64>,
    /// Current per velocity that brakes the motion, A·s/rad; 0 if absent.
    pub damping_as_per_rad: Option<f64>,
    /// Supply voltage, V.
    pub supply_v: Option<f64>,
    /// Largest duty cycle; 1 if absent.
    pub duty_limit: Option<f64>,
    /// Largest current, A; no limit if absent.
    pub current_limit_a: Option<f64>,
    /// Period of the position loop in the firmware, s; a continuous loop if absent.
    pub loop_period_s: Option<f64>,
    /// Back-EMF per velocity of the output, V·s/rad, if known; estimated if absent.
    pub back_emf_vs_per_rad: Option<f64>,
    /// Torque of the output at standstill per volt, N·m/V, if known: the torque constant over the
    /// resistance; estimated if absent.
    pub torque_nm_per_v: Option<f64>,
    /// Torque of the output per ampere, N·m/A, if known; estimated if absent.
    pub torque_nm_per_a: Option<f64>,
}

impl ServoDrive {
    /// Returns whether it applies a voltage; otherwise it controls the current.
    #[must_use]
    pub fn applies_voltage(&self) -> bool {
        self.gain_duty_per_rad.is_some()
    }

    /// Returns the torque per volt or ampere, if it is known.
    #[must_use]
    pub fn torque_per_command(&self) -> Option<f64> {
        self.torque_nm_per_v.or(self.torque_nm_per_a)
    }
}
