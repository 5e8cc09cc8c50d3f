//! Joints whose spring a log does not determine, as a part of the results.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sprung_core::parameters::JointParameter;

use crate::numbers::rounded_down;

/// A joint whose spring the logs do not determine; it is taken as rigid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RigidJoint {
    /// Name of the joint.
    pub joint: String,
    /// Lower bound of the stiffness at 95 %, N·m/rad (N/m).
    pub stiffness_above_nm_per_rad: f64,
    /// Estimate of the compliance, rad/(N·m) (m/N); noise may make it negative.
    pub compliance_rad_per_nm: f64,
    /// Its standard error, rad/(N·m) (m/N).
    pub compliance_standard_error_rad_per_nm: f64,
    /// Cross-validation by which one equation of a rigid joint replaced those of link and motor; absent if a torque
    /// sensor separates link and motor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hold_out: Option<RigidByHoldOut>,
}

/// The spring of a joint by its deflection and its torque sensor, of a robot without motor torques.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SensedSpring {
    /// Name of the joint.
    pub joint: String,
    /// Stiffness, N·m/rad (N/m).
    pub stiffness_nm_per_rad: f64,
    /// Its standard error, N·m/rad (N/m).
    pub standard_error_nm_per_rad: f64,
    /// 95 % confidence interval, N·m/rad (N/m).
    pub ci95_nm_per_rad: [f64; 2],
}

/// Residuals of the filtered torque of a joint in eighths of the beginning of the first log, each predicted by a fit of
/// the other eighths, relative to the torque.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RigidByHoldOut {
    /// With a spring; absent if an eighth does not determine the parameters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flexible: Option<f64>,
    /// As a rigid joint.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rigid: Option<f64>,
}

impl RigidJoint {
    /// Returns the bound in the form of tables: `> 12 000`.
    #[must_use]
    pub fn bound(&self) -> String {
        format!("> {}", rounded_down(self.stiffness_above_nm_per_rad))
    }

    /// Returns the name of its stiffness.
    #[must_use]
    pub fn stiffness(&self) -> String {
        format!("{}.{}", self.joint, JointParameter::Stiffness.name())
    }

    /// Adds the spring that simulations take: the least stiff spring that the logs allow. A joint with the equation of a
    /// rigid joint needs none.
    ///
    /// - `lacks`: whether a parameter of the robot with this name has no value.
    pub fn complete(&self, lacks: impl Fn(&str) -> bool, values: &mut BTreeMap<String, f64>) {
        for (kind, value) in [
            (JointParameter::Stiffness, self.stiffness_above_nm_per_rad),
            (JointParameter::CubicStiffness, 0.0),
            (JointParameter::Damping, 0.0),
        ] {
            let name = format!("{}.{}", self.joint, kind.name());
            if lacks(&name) {
                values.entry(name).or_insert(value);
            }
        }
    }
}
