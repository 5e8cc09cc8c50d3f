//! Limits of a joint, within which experiments are designed.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Limits of a joint for `sprung excite`; those of the URDF count where a key is absent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(default)]
pub struct Limits {
    /// Lowest and highest position of motor and link, rad (m).
    pub position_rad: Option<[f64; 2]>,
    /// Largest velocity, rad/s (m/s).
    pub velocity_rad_per_s: Option<f64>,
    /// Largest acceleration, rad/s² (m/s²).
    pub acceleration_rad_per_s2: Option<f64>,
    /// Largest jerk, rad/s³ (m/s³).
    pub jerk_rad_per_s3: Option<f64>,
    /// Largest motor torque after the gear, N·m (N).
    pub torque_nm: Option<f64>,
    /// Largest rate of the motor torque, N·m/s (N/s).
    pub torque_rate_nm_per_s: Option<f64>,
    /// Largest deflection of the spring, rad (m).
    pub deflection_rad: Option<f64>,
}

impl Limits {
    /// Returns the limits with those of another source where a key is absent.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            position_rad: self.position_rad.or(other.position_rad),
            velocity_rad_per_s: self.velocity_rad_per_s.or(other.velocity_rad_per_s),
            acceleration_rad_per_s2: (self.acceleration_rad_per_s2)
                .or(other.acceleration_rad_per_s2),
            jerk_rad_per_s3: self.jerk_rad_per_s3.or(other.jerk_rad_per_s3),
            torque_nm: self.torque_nm.or(other.torque_nm),
            torque_rate_nm_per_s: self.torque_rate_nm_per_s.or(other.torque_rate_nm_per_s),
            deflection_rad: self.deflection_rad.or(other.deflection_rad),
        }
    }

    /// Returns the limits that are one positive number, with their keys.
    #[must_use]
    pub fn magnitudes(&self) -> [(&'static str, Option<f64>); 6] {
        [
            ("velocity_rad_per_s", self.velocity_rad_per_s),
            ("acceleration_rad_per_s2", self.acceleration_rad_per_s2),
            ("jerk_rad_per_s3", self.jerk_rad_per_s3),
            ("torque_nm", self.torque_nm),
            ("torque_rate_nm_per_s", self.torque_rate_nm_per_s),
            ("deflection_rad", self.deflection_rad),
        ]
    }
}
