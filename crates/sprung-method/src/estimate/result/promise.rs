//! Promised prediction errors.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Prediction errors of a joint along a measured motion, filtered by the filter pair, root mean
/// squares.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "PromisedErrors")]
pub struct JointPrediction {
    /// Name of the joint.
    pub joint: String,
    /// Motor torque, N·m (N).
    pub torque_nm: f64,
    /// Error of the motor torque, N·m (N).
    pub torque_error_nm: f64,
    /// Deflection of the spring, rad (m); absent without a spring of positive stiffness.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deflection_rad: Option<f64>,
    /// Error of the deflection that moves the link, rad (m): residual of the link's equation over
    /// the stiffness.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deflection_error_rad: Option<f64>,
}
